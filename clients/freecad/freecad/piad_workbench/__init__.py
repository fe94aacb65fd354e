"""Curves and surfaces that piad fits, in FreeCAD.

- `points`: points of what is selected; `settings`: what a person can choose;
- `server`: the server that fits; `fitting`: a fit as a series of updates; `shape`: from them to shapes;
- `preview`: follows a fit in a thread; `drawing`: what it shows in the 3D view;
- `panel`, `drag`: the task panels; `feature`: the object that is left in the document;
- `commands`, `init_gui`: the commands and the workbench.
"""
