"""Reads STEP and IGES with other software: OpenCASCADE and pyiges."""

import contextlib
import io
from dataclasses import dataclass

import numpy as np
import pyiges
from OCP.BRep import BRep_Tool
from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeVertex
from OCP.BRepCheck import BRepCheck_Analyzer
from OCP.BRepExtrema import BRepExtrema_DistShapeShape
from OCP.gp import gp_Pnt
from OCP.IFSelect import IFSelect_RetDone
from OCP.IGESControl import IGESControl_Reader
from OCP.IGESGeom import IGESGeom_BSplineCurve, IGESGeom_BSplineSurface
from OCP.Interface import Interface_Static
from OCP.Message import Message, Message_Gravity
from OCP.StepGeom import (
    StepGeom_BSplineCurve,
    StepGeom_BSplineCurveWithKnots,
    StepGeom_BSplineCurveWithKnotsAndRationalBSplineCurve,
    StepGeom_BSplineSurface,
    StepGeom_BSplineSurfaceWithKnots,
    StepGeom_BSplineSurfaceWithKnotsAndRationalBSplineSurface,
)
from OCP.STEPControl import STEPControl_Reader
from OCP.TopAbs import TopAbs_EDGE, TopAbs_FACE
from OCP.TopExp import TopExp_Explorer
from OCP.TopoDS import TopoDS


@dataclass
class Raw:
    """The numbers of a file."""

    degrees: list[int]
    knots: list[np.ndarray]
    closed: list[bool]
    poles: np.ndarray
    weights: np.ndarray | None
    domains: list[tuple[float, float]] | None = None


class CadFile:
    """A file as OpenCASCADE transfers it."""

    def __init__(self, path: str, roots: int | None = 1):
        for printer in Message.DefaultMessenger_s().Printers():
            printer.SetTraceLevel(Message_Gravity.Message_Alarm)
        step = path.endswith((".step", ".stp"))
        self.reader = STEPControl_Reader() if step else IGESControl_Reader()
        assert self.reader.ReadFile(path) == IFSelect_RetDone, "cannot be read"
        # Otherwise splines are split at knots where they are not smooth.
        Interface_Static.SetIVal_s("read.iges.bspline.continuity", 0)
        transferred = self.reader.TransferRoots()
        assert roots in (None, transferred), f"{transferred} roots"
        self.shape = self.reader.OneShape()
        self.model = self.reader.WS().Model() if step else self.reader.IGESModel()

    def entities(self):
        return [self.model.Value(i) for i in range(1, self.model.NbEntities() + 1)]

    def geometry(self):
        """The only curve or surface."""
        faces = explore(self.shape, TopAbs_FACE)
        if faces:
            assert len(faces) == 1, "not one face"
            return BRep_Tool.Surface_s(TopoDS.Face_s(faces[0]))
        edges = explore(self.shape, TopAbs_EDGE)
        assert len(edges) == 1, f"{len(edges)} edges"
        return BRep_Tool.Curve_s(TopoDS.Edge_s(edges[0]), 0.0, 0.0)

    def is_valid(self) -> bool:
        return BRepCheck_Analyzer(self.shape).IsValid()

    def distance(self, place) -> float:
        vertex = BRepBuilderAPI_MakeVertex(gp_Pnt(*map(float, place))).Vertex()
        return BRepExtrema_DistShapeShape(vertex, self.shape).Value()


def explore(shape, kind):
    explorer, found = TopExp_Explorer(shape, kind), []
    while explorer.More():
        found.append(explorer.Current())
        explorer.Next()
    return found


def point(p):
    return [p.X(), p.Y(), p.Z()]


def evaluate(geometry, *parameters):
    """Points at parameters, for surfaces on their grid."""
    if len(parameters) == 1:
        return np.array([point(geometry.Value(float(t))) for t in parameters[0]])
    u, v = parameters
    return np.array([[point(geometry.Value(float(s), float(t))) for t in v] for s in u])


def spread(knots, multiplicities):
    return np.repeat(np.array(knots), multiplicities)


def of_geometry(g) -> Raw:
    """The numbers of a curve or surface of OpenCASCADE that is not periodic."""
    if hasattr(g, "UDegree"):
        rows, columns = range(1, g.NbUPoles() + 1), range(1, g.NbVPoles() + 1)
        rational = g.IsURational() or g.IsVRational()
        return Raw(
            [g.UDegree(), g.VDegree()],
            [
                spread([g.UKnot(i + 1) for i in range(g.NbUKnots())],
                       [g.UMultiplicity(i + 1) for i in range(g.NbUKnots())]),
                spread([g.VKnot(i + 1) for i in range(g.NbVKnots())],
                       [g.VMultiplicity(i + 1) for i in range(g.NbVKnots())]),
            ],
            [g.IsUClosed(), g.IsVClosed()],
            np.array([[point(g.Pole(i, j)) for j in columns] for i in rows]),
            np.array([[g.Weight(i, j) for j in columns] for i in rows]) if rational else None,
        )
    poles = range(1, g.NbPoles() + 1)
    knots = range(1, g.NbKnots() + 1)
    return Raw(
        [g.Degree()],
        [spread([g.Knot(i) for i in knots], [g.Multiplicity(i) for i in knots])],
        [g.IsClosed()],
        np.array([point(g.Pole(i)) for i in poles]),
        np.array([g.Weight(i) for i in poles]) if g.IsRational() else None,
    )


def array(handle):
    return [handle.Value(i) for i in range(handle.Lower(), handle.Upper() + 1)]


def of_step(cad: CadFile) -> Raw:
    """The raw numbers of the only spline of a STEP file."""
    curve_kinds = (StepGeom_BSplineCurveWithKnots, StepGeom_BSplineCurveWithKnotsAndRationalBSplineCurve)
    surface_kinds = (
        StepGeom_BSplineSurfaceWithKnots,
        StepGeom_BSplineSurfaceWithKnotsAndRationalBSplineSurface,
    )
    splines = [e for e in cad.entities() if isinstance(e, (StepGeom_BSplineCurve, StepGeom_BSplineSurface))]
    assert len(splines) == 1, "not one spline"
    spline = splines[0]

    def place(p):
        return [p.CoordinatesValue(i) for i in (1, 2, 3)]

    if isinstance(spline, curve_kinds):
        rational = isinstance(spline, curve_kinds[1])
        knots = spline.BSplineCurveWithKnots() if rational else spline
        weights = spline.RationalBSplineCurve().WeightsData() if rational else None
        count = spline.NbControlPointsList()
        return Raw(
            [spline.Degree()],
            [spread(array(knots.Knots()), array(knots.KnotMultiplicities()))],
            [spline.ClosedCurve() == spline.ClosedCurve().StepData_LTrue],
            np.array([place(spline.ControlPointsListValue(i + 1)) for i in range(count)]),
            np.array(array(weights)) if rational else None,
        )
    assert isinstance(spline, surface_kinds)
    rational = isinstance(spline, surface_kinds[1])
    knots = spline.BSplineSurfaceWithKnots() if rational else spline
    rows = range(1, spline.NbControlPointsListI() + 1)
    columns = range(1, spline.NbControlPointsListJ() + 1)
    return Raw(
        [spline.UDegree(), spline.VDegree()],
        [
            spread(array(knots.UKnots()), array(knots.UMultiplicities())),
            spread(array(knots.VKnots()), array(knots.VMultiplicities())),
        ],
        [closed == closed.StepData_LTrue for closed in (spline.UClosed(), spline.VClosed())],
        np.array([[place(spline.ControlPointsListValue(i, j)) for j in columns] for i in rows]),
        np.array([[spline.WeightsDataValue(i, j) for j in columns] for i in rows]) if rational else None,
    )


def of_iges(cad: CadFile) -> Raw:
    """The raw numbers of the only spline of an IGES file."""
    (spline,) = cad.entities()
    if isinstance(spline, IGESGeom_BSplineCurve):
        count, degree = spline.UpperIndex() + 1, spline.Degree()
        # A closed curve with corners is clamped at one of them.
        assert spline.IsPeriodic() == (spline.IsClosed() and spline.Knot(-degree) < spline.Knot(0))
        return Raw(
            [degree],
            [np.array([spline.Knot(i - degree) for i in range(count + degree + 1)])],
            [spline.IsClosed()],
            np.array([point(spline.Pole(i)) for i in range(count)]),
            None if spline.IsPolynomial(True) else np.array([spline.Weight(i) for i in range(count)]),
            [(spline.UMin(), spline.UMax())],
        )
    assert isinstance(spline, IGESGeom_BSplineSurface)
    rows, columns = spline.UpperIndexU() + 1, spline.UpperIndexV() + 1
    p, q = spline.DegreeU(), spline.DegreeV()
    weights = np.array([[spline.Weight(i, j) for j in range(columns)] for i in range(rows)])
    return Raw(
        [p, q],
        [
            np.array([spline.KnotU(i - p) for i in range(rows + p + 1)]),
            np.array([spline.KnotV(i - q) for i in range(columns + q + 1)]),
        ],
        [spline.IsClosedU() and spline.IsPeriodicU(), spline.IsClosedV() and spline.IsPeriodicV()],
        np.array([[point(spline.Pole(i, j)) for j in range(columns)] for i in range(rows)]),
        None if spline.IsPolynomial(True) else weights,
        # OpenCASCADE reads the four numbers in a different order than it writes them and than IGES
        # 5.3 specifies (section 4.24), and does not use them.
        [(spline.UMin(), spline.VMin()), (spline.UMax(), spline.VMax())],
    )


def of_pyiges(path: str) -> Raw:
    """The same with a parser in Python."""
    with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
        iges = pyiges.read(path)
    curves, surfaces = iges.bsplines(), iges.bspline_surfaces()
    assert len(curves) + len(surfaces) == 1
    if curves:
        (curve,) = curves
        assert curve.prop4 == (curve.prop2 and curve.T[0] < curve.T[curve.M])
        return Raw(
            [curve.M],
            [np.array(curve.T)],
            [curve.prop2 == 1],
            np.array(curve.control_points),
            None if curve.prop3 == 1 else np.array(curve.W),
            [(curve.V0, curve.V1)],
        )
    (surface,) = surfaces
    shape = (surface.k2 + 1, surface.k1 + 1)
    return Raw(
        [surface.m1, surface.m2],
        [np.array(surface.knot1), np.array(surface.knot2)],
        [bool(surface.flag1 and surface.flag4), bool(surface.flag2 and surface.flag5)],
        np.array(surface.control_points()).reshape(*shape, 3).swapaxes(0, 1),
        None if surface.flag3 else np.array(surface.weights).reshape(shape).T,
    )
