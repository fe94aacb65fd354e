"""Runs the tests inside of FreeCAD, when its window is there: `freecad inside.py`.

PIAD_TESTS are names of tests (all without it), PIAD_RESULT is the file for what has come of them.
"""

import os
import sys
import traceback
import unittest

from PySide import QtCore

FOLDER = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, FOLDER)


def main() -> None:
    """The status is 0 if all tests have passed. FreeCAD itself would ask about open documents at its end."""
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
