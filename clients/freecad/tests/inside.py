"""Runs the tests inside FreeCAD, once its window is open: `freecad inside.py`.

PIAD_TESTS are names of tests (default: all), PIAD_RESULT is the file for the result.
"""

import os
import sys
import traceback
import unittest

from PySide import QtCore

FOLDER = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, FOLDER)


def main() -> None:
    """Exits with status 0 if all tests passed. A regular exit of FreeCAD would ask about open
    documents."""
    status = 1
    with open(os.environ["PIAD_RESULT"], "w") as result:
        try:
            loader = unittest.TestLoader()
            names = os.environ.get("PIAD_TESTS", "").split()
            suite = loader.loadTestsFromNames(names) if names else loader.discover(FOLDER)
            status = 0 if unittest.TextTestRunner(result, verbosity=2).run(suite).wasSuccessful() else 1
        except BaseException:
            traceback.print_exc(file=result)
    from freecad.piad_workbench import server

    server._OWN.stop()
    os._exit(status)


QtCore.QTimer.singleShot(0, main)
