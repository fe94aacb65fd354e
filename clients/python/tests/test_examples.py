"""The example scripts, with their host programs or stubs of them."""

from __future__ import annotations

import runpy
import sys
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any
from unittest.mock import MagicMock

import pytest
from conftest import ROOT, Server
from shapes import CURVE

import piad

EXAMPLES = ROOT / "examples" / "python"


@pytest.fixture(autouse=True)
def at_this_server(server: Server, monkeypatch: pytest.MonkeyPatch) -> None:
    """Scripts of CAD systems use the default address."""
    usual = piad.Client
    monkeypatch.setattr(piad, "Client", lambda _address: usual(server.url))


def install(monkeypatch: pytest.MonkeyPatch, name: str, **members: Any) -> None:
    module = ModuleType(name)
    vars(module).update(members)
    monkeypatch.setitem(sys.modules, name, module)


def run(name: str, **names: Any) -> dict[str, Any]:
    return runpy.run_path(str(EXAMPLES / name), names, run_name="__main__")


def test_freecad(monkeypatch: pytest.MonkeyPatch) -> None:
    spline = MagicMock()
    spline.toShape.return_value.Length = 100.0
    install(monkeypatch, "FreeCAD", Vector=lambda x, y, z: (x, y, z), ActiveDocument=MagicMock(), GuiUp=1)
    install(monkeypatch, "FreeCADGui", Selection=SimpleNamespace(getSelection=lambda: []))
    install(monkeypatch, "Part", BSplineCurve=lambda: spline, show=MagicMock())
    run("freecad_fit.py")
    poles, multiplicities, knots, periodic, degree, weights = spline.buildFromPolesMultsKnots.call_args.args
    assert sum(multiplicities) == len(poles) + degree + 1
    assert len(weights) == len(poles) and len(knots) == len(multiplicities) and not periodic


class RhinoPoints:
    """Adapts the list of rhino3dm to RhinoCommon: position and weight are one point."""

    def __init__(self, curve: Any):
        self._curve = curve

    def SetPoint(self, i: int, point: Any, weight: float) -> None:
        import rhino3dm

        self._curve.Points[i] = rhino3dm.Point4d(point.X * weight, point.Y * weight, point.Z * weight, weight)


def rhino_curve(*size: Any) -> Any:
    import rhino3dm

    made = rhino3dm.NurbsCurve(*size)
    return SimpleNamespace(real=made, Points=RhinoPoints(made), Knots=made.Knots)


def test_rhino(monkeypatch: pytest.MonkeyPatch) -> None:
    import rhino3dm

    points = [rhino3dm.Point3d(*point) for point in CURVE]
    geometry = SimpleNamespace(NurbsCurve=rhino_curve, Point3d=rhino3dm.Point3d)
    install(monkeypatch, "Rhino", Geometry=geometry)
    component = run("rhino_fit.py", points=points)
    curve = component["curve"].real
    assert curve.IsValid
    end = curve.PointAt(curve.Domain.T1)
    assert [end.X, end.Y, end.Z] == pytest.approx(CURVE[-1], abs=1e-6)

    added = MagicMock()
    install(monkeypatch, "rhinoscriptsyntax", GetPoints=lambda **_: points)
    install(monkeypatch, "scriptcontext", doc=added)
    run("rhino_fit.py")
    assert added.Objects.AddCurve.call_args.args[0].real.IsValid


def test_cadquery(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    from OCP.STEPControl import STEPControl_Reader

    path = tmp_path / "saddle.step"
    monkeypatch.setattr(sys, "argv", ["cadquery_fit.py", "any", str(path)])
    run("cadquery_fit.py")
    reader = STEPControl_Reader()
    reader.ReadFile(str(path))
    assert reader.TransferRoots() == 1


def test_blender(monkeypatch: pytest.MonkeyPatch) -> None:
    thing, mesh, scene, ops = MagicMock(), MagicMock(), SimpleNamespace(frame_start=1, frame_end=0), MagicMock()
    thing.shape_key_add.side_effect = lambda name: MagicMock(data=[SimpleNamespace(co=None) for _ in range(200)])
    data = SimpleNamespace(meshes=MagicMock(), objects=MagicMock())
    data.meshes.new.return_value, data.objects.new.return_value = mesh, thing
    context, app = SimpleNamespace(collection=MagicMock(), scene=scene), SimpleNamespace(background=True)
    install(monkeypatch, "bpy", data=data, context=context, app=app, ops=ops)
    run("blender_fit.py")
    vertices, edges, faces = mesh.from_pydata.call_args.args
    assert len(vertices) == 200 and len(edges) == 199 and not faces
    assert thing.shape_key_add.call_count == scene.frame_end + 1 > 10
    # Each iteration is one frame, including the first.
    assert scene.frame_start == 0 and ops.wm.save_as_mainfile.called
