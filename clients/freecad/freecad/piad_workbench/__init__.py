"""Curve and surface fitting with piad in FreeCAD.

- `points`: points of the selection; `settings`: the settings of a fit;
- `server`: the server; `fitting`: a fit as a series of updates; `shape`: conversion to shapes;
- `preview`: watches a fit in a thread; `drawing`: its nodes in the 3D view;
- `panel`, `drag`: the task panels; `feature`: the object in the document;
- `commands`, `init_gui`: the commands and the workbench.
"""
