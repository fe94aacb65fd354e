"""From a scanned mesh to a trimmed face: the tutorial "Fit a trimmed face to a mesh" of docs/tutorials/mesh-to-step.md."""

import math
import os
import subprocess
import tempfile
import unittest

import FreeCAD as App
import Part

STEPS = 40


def cap():
    """The vertices and triangles of a round cap with a hole, with a ragged boundary as of a scanner."""
    places, numbers = [], {}
    for i in range(STEPS + 1):
        for j in range(STEPS + 1):
            x, y = 60 * i / STEPS - 30, 60 * j / STEPS - 30
            far = math.hypot(x, y)
            if 8 <= far <= 30:
                numbers[i, j] = len(places)
                places.append((x, y, 4 - 0.004 * far * far + 0.3 * math.sin(0.2 * x)))
    triangles = []
    for i in range(STEPS):
        for j in range(STEPS):
            a, b, c, d = (numbers.get(at) for at in ((i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)))
            triangles += [corners for corners in ((a, b, c), (a, c, d)) if None not in corners]
    used = sorted({vertex for corners in triangles for vertex in corners})
    place = {vertex: k for k, vertex in enumerate(used)}
    return [places[vertex] for vertex in used], [tuple(place[it] for it in corners) for corners in triangles]


class TrimmedFace(unittest.TestCase):
    def test_a_mesh_becomes_a_trimmed_face(self):
        places, triangles = cap()
        vectors = [App.Vector(*place) for place in places]
        area = sum((vectors[b] - vectors[a]).cross(vectors[c] - vectors[a]).Length / 2 for a, b, c in triangles)
        with tempfile.TemporaryDirectory() as folder:
            mesh, step = os.path.join(folder, "cap.obj"), os.path.join(folder, "cap.step")
            with open(mesh, "w") as file:
                file.writelines("v %.6f %.6f %.6f\n" % place for place in places)
                file.writelines("f %d %d %d\n" % tuple(k + 1 for k in corners) for corners in triangles)
            command = [os.environ["PIAD_PROGRAM"], "fit", "-q", mesh, "--tolerance", "0.01", "--trim", "-o", step]
            subprocess.run(command, check=True)
            shape = Part.Shape()
            shape.read(step)
        self.assertTrue(shape.isValid())
        self.assertEqual(len(shape.Faces), 1)
        self.assertEqual(len(shape.Faces[0].Wires), 2)
        self.assertAlmostEqual(shape.Area / area, 1, delta=0.01)
        for vector in vectors[::7]:
            self.assertLess(shape.distToShape(Part.Vertex(vector))[0], 1.5)


if __name__ == "__main__":
    unittest.main()
