"""CadQuery and build123d: a surface through a grid of points as a face, written as STEP.

    pip install ./clients/python cadquery        # or build123d
    python cadquery_fit.py [SERVER [FILE]]

Without both, OpenCASCADE (cadquery-ocp) writes the face itself.
"""

import math
import sys

from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeFace
from OCP.IFSelect import IFSelect_RetDone
from OCP.STEPControl import STEPControl_AsIs, STEPControl_Writer

import piad


def face_of(surface):
    """A TopoDS_Face. In CadQuery it is `cq.Face(face)`, in build123d `Face(face)`."""
    return BRepBuilderAPI_MakeFace(surface.to_occ(), 1e-6).Face()


def write_step(face, path):
    try:
        import cadquery
    except ImportError:
        writer = STEPControl_Writer()
        writer.Transfer(face, STEPControl_AsIs)
        if writer.Write(path) != IFSelect_RetDone:
            raise OSError(f"{path} could not be written")
    else:
        cadquery.exporters.export(cadquery.Workplane(cadquery.Face(face)), path)


def main(server="http://127.0.0.1:8080", path="saddle.step"):
    points = [[[x, y, 5 * math.sin(x / 10) * math.cos(y / 10)] for y in range(0, 50, 5)] for x in range(0, 60, 5)]
    with piad.Client(server) as client:
        job = client.create(points, tolerance=1e-6, name="saddle")
        for iteration in job.iterations(view="errors"):
            print(f"{iteration.number:4} {iteration.error.max:.3e} mm")
        write_step(face_of(job.result().surface), path)


if __name__ == "__main__":
    main(*sys.argv[1:])
