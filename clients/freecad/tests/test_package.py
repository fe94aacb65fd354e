"""Files for the add-on manager and translators."""

import glob
import os
import re
import unittest
import xml.etree.ElementTree as ElementTree

import FreeCADGui as Gui

from freecad import piad_workbench
from freecad.piad_workbench import commands, server

MODULE = os.path.dirname(piad_workbench.__file__)
FOLDER = os.path.dirname(os.path.dirname(MODULE))
SPACE = "{https://wiki.freecad.org/Package_Metadata}"
TEXT = re.compile(r'(?:translate|QT_TRANSLATE_NOOP)\(\s*"(?:piad|App::Property)",\s*"((?:[^"\\]|\\.)*)"')


class Package(unittest.TestCase):
    def test_metadata(self):
        root = ElementTree.parse(os.path.join(FOLDER, "package.xml")).getroot()
        for icon in root.iter(SPACE + "icon"):
            self.assertTrue(os.path.exists(os.path.join(FOLDER, icon.text)), icon.text)
        for licence in root.iter(SPACE + "license"):
            self.assertTrue(os.path.exists(os.path.join(FOLDER, licence.get("file"))), licence.text)
        self.assertIn(root.find(f".//{SPACE}classname").text, Gui.listWorkbenches())

    def test_commands_have_icons_and_texts(self):
        Gui.activateWorkbench("PiadWorkbench")
        for name in commands.NAMES:
            info = Gui.Command.get(name).getInfo()
            self.assertTrue(os.path.exists(info["pixmap"]), info["pixmap"])
            self.assertGreater(len(info["toolTip"]), 20)

    def test_the_client_in_the_package_is_used(self):
        self.assertEqual(os.path.dirname(os.path.dirname(server.piad().__file__)), FOLDER)

    def test_translators_have_all_texts(self):
        messages = ElementTree.parse(os.path.join(MODULE, "translations", "piad.ts")).getroot()
        known = {it.text for it in messages.iter("source")}
        texts = set()
        for path in glob.glob(os.path.join(MODULE, "*.py")):
            with open(path, encoding="utf-8") as file:
                texts |= set(TEXT.findall(file.read()))
        self.assertGreater(len(texts), 50)
        self.assertEqual(texts - known, set())
