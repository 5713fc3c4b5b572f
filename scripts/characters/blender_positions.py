"""Where Blender puts the vertices of a Collada file: blender -b -P blender_positions.py -- FILE REQUEST OUT

Runs inside of Blender. REQUEST is a JSON list of [clip, seconds]; Collada has one timeline. OUT is an .npz with
"seconds", the end of the last action, and "frame0", ... [P,3]: corners of polygons, y up, in metres.
"""
import json
import sys

import bpy
import numpy as np

file, request, out = sys.argv[sys.argv.index("--") + 1:]
for thing in list(bpy.data.objects):
    bpy.data.objects.remove(thing)
bpy.ops.wm.collada_import(filepath=file)
scene = bpy.context.scene
rate = scene.render.fps / scene.render.fps_base


def shown(thing):
    while thing:
        if thing.hide_render:
            return False
        thing = thing.parent
    return True


def points():
    graph, found = bpy.context.evaluated_depsgraph_get(), []
    for instance in graph.object_instances:
        if instance.object.type != "MESH" or not shown(instance.object):
            continue
        mesh = instance.object.to_mesh()
        used = sorted({v for polygon in mesh.polygons for v in polygon.vertices})
        places = np.empty(3 * len(mesh.vertices))
        mesh.vertices.foreach_get("co", places)
        world = np.array(instance.matrix_world)
        found.append(places.reshape(-1, 3)[used] @ world[:3, :3].T + world[:3, 3])
        instance.object.to_mesh_clear()
    places = np.concatenate(found)
    return places[:, [0, 2, 1]] * [1, 1, -1]  # Blender's z is up


frames = {}
for number, (clip, seconds) in enumerate(json.load(open(request))):
    at = seconds * rate
    scene.frame_set(int(np.floor(at)), subframe=float(at - np.floor(at)))
    frames[f"frame{number}"] = points()
last = max((action.frame_range[1] / rate for action in bpy.data.actions), default=0)
np.savez(out, seconds=last, **frames)
