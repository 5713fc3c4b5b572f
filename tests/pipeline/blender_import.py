"""Runs in Blender for test_blender_import.py: writes files as Blender's importer of glTF reads them.

usage: blender -b --factory-startup --python blender_import.py -- FILE.glb...

Beside each file comes FILE.glb.npz: of every corner of a face "positions" [C,3] as the file has them and "colors"
[C,4], linear; "keys", the number of shape keys beside the basis; "driven", how many curves drive their values; and
"attributes", the names of those that Blender does not make by itself.
"""
import sys

import bpy
import numpy as np

np.bool = bool  # the importer of Blender 3.4 has a name that numpy 1.24 lost


def corners(mesh):
    points, of_corner = np.empty(3 * len(mesh.vertices)), np.empty(len(mesh.loops), int)
    mesh.vertices.foreach_get("co", points)
    mesh.loops.foreach_get("vertex_index", of_corner)
    colors = np.empty(4 * len(mesh.loops), np.float32)
    mesh.color_attributes[0].data.foreach_get("color", colors)
    return points.reshape(-1, 3)[of_corner][:, [0, 2, 1]] * [1, 1, -1], colors.reshape(-1, 4)


for path in sys.argv[sys.argv.index("--") + 1 :]:
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.import_scene.gltf(filepath=path)
    (mesh,) = [thing.data for thing in bpy.data.objects if thing.type == "MESH" and thing.data.color_attributes]
    keys = mesh.shape_keys
    curves = [curve for action in bpy.data.actions for curve in action.fcurves if "key_blocks" in curve.data_path]
    positions, colors = corners(mesh)
    np.savez(path + ".npz", positions=positions, colors=colors, keys=len(keys.key_blocks) - 1 if keys else 0,
             driven=len({curve.data_path for curve in curves}),
             attributes=[a.name for a in mesh.attributes if a.name.startswith("_")])  # fmt: skip
