"""Blender script: animates the fit of a curve, one frame for each iteration.

Install the client into Blender's Python (`python -m pip install ./clients/python`), start a server,
and run this in the Text Editor. Blender's NURBS do not support custom knots, so each iteration is
sampled into a mesh with a shape key.

Without a window, `blender --background --python blender_fit.py` or, with `pip install bpy`,
`python blender_fit.py` writes piad.blend.
"""

import math
import os

import bpy

import piad

SERVER = "http://127.0.0.1:8080"
SAMPLES = 200
POINTS = [[math.cos(t), math.sin(2 * t), 0.3 * math.sin(3 * t)] for t in (2 * math.pi * i / 12 for i in range(12))]


def sampled_iterations():
    """The points of each iteration, as the server samples them."""
    with piad.Client(SERVER) as client:
        job = client.create(POINTS, closed=True, name="Blender")
        for iteration in job.iterations(view="samples", samples=SAMPLES):
            yield [tuple(map(float, point)) for point in iteration.samples.points]


def main():
    levels = list(sampled_iterations())
    mesh = bpy.data.meshes.new("piad")
    mesh.from_pydata(levels[0], [(i, i + 1) for i in range(SAMPLES - 1)], [])
    thing = bpy.data.objects.new("piad", mesh)
    bpy.context.collection.objects.link(thing)
    thing.shape_key_add(name="0")
    for number, points in enumerate(levels[1:], 1):
        key = thing.shape_key_add(name=str(number))
        for vertex, point in zip(key.data, points):
            vertex.co = point
        for frame, value in ((number - 1, 0.0), (number, 1.0), (number + 1, 0.0)):
            if frame < len(levels):
                key.value = value
                key.keyframe_insert("value", frame=frame)
    bpy.context.scene.frame_start, bpy.context.scene.frame_end = 0, len(levels) - 1
    print(f"{len(levels)} frames of {SAMPLES} vertices")
    if bpy.app.background:
        bpy.ops.wm.save_as_mainfile(filepath=os.path.abspath("piad.blend"))


main()
