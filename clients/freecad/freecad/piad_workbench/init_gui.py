"""The workbench, loaded by FreeCAD when its window opens."""

import os

import FreeCAD
import FreeCADGui

FOLDER = os.path.dirname(__file__)


class PiadWorkbench(FreeCADGui.Workbench):
    """Curves and surfaces through points."""

    MenuText = "piad"
    ToolTip = FreeCAD.Qt.translate("piad", "Fit curves and surfaces to points")
    Icon = os.path.join(FOLDER, "resources", "icons", "piad_workbench.svg")

    def Initialize(self) -> None:
        """Called when the workbench is opened first."""
        from . import commands

        commands.register()
        self.appendToolbar("piad", list(commands.NAMES))
        self.appendMenu("piad", list(commands.NAMES))

    def ContextMenu(self, recipient: str) -> None:
        """The menu of the right mouse button."""
        from . import commands

        self.appendContextMenu("piad", list(commands.NAMES))

    def GetClassName(self) -> str:
        """A workbench in Python."""
        return "Gui::PythonWorkbench"


FreeCADGui.addLanguagePath(os.path.join(FOLDER, "translations"))
FreeCADGui.addIconPath(os.path.join(FOLDER, "resources", "icons"))
FreeCADGui.addPreferencePage(os.path.join(FOLDER, "resources", "preferences.ui"), "piad")
FreeCADGui.addWorkbench(PiadWorkbench())
