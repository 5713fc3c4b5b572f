"""Runs in Blender for test_blender.py: ambient occlusion as Cycles bakes it, beside ours, on the same frames.

usage: blender -b --factory-startup --python blender_cycles.py -- ADDON BIN FOLDER RAYS
"""
import os
import subprocess
import sys
import time

import bpy
import numpy as np

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, os.path.join(HERE, "..", "..", "scripts", "blender"))
import character  # noqa: E402

ADDON, BIN, FOLDER, RAYS = sys.argv[sys.argv.index("--") + 1 :]
sys.path.insert(0, ADDON)
from penumbra_addon import record  # noqa: E402

FRAMES = (6, 12, 20)


def still_copy(thing):
    """Returns an object as Blender shows it in this frame, as a mesh without modifiers in world space."""
    evaluated = thing.evaluated_get(bpy.context.evaluated_depsgraph_get())
    mesh = bpy.data.meshes.new_from_object(evaluated)
    mesh.transform(evaluated.matrix_world)
    copy = bpy.data.objects.new("still", mesh)
    bpy.context.scene.collection.objects.link(copy)
    mesh.color_attributes.active_color = mesh.color_attributes.new("ao", "FLOAT_COLOR", "POINT")
    return copy


def set_normals(mesh):
    """Normals weighted by area, as the bake of a point cache has them."""
    points = np.empty(3 * len(mesh.vertices), np.float32)
    mesh.vertices.foreach_get("co", points)
    points = points.reshape(-1, 3).astype(np.float64)
    mesh.calc_loop_triangles()
    faces = np.empty(3 * len(mesh.loop_triangles), np.int32)
    mesh.loop_triangles.foreach_get("vertices", faces)
    faces = faces.reshape(-1, 3)
    a, b, c = (points[faces[:, k]] for k in range(3))
    normals = np.zeros_like(points)
    for k in range(3):
        np.add.at(normals, faces[:, k], np.cross(b - a, c - a))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    if hasattr(mesh, "use_auto_smooth"):  # before Blender 4.1
        mesh.use_auto_smooth = True
    mesh.normals_split_custom_set_from_vertices(normals)


def cycles(things, rays):
    """Ambient occlusion of every vertex as Cycles bakes it, and the seconds of its bake."""
    scene = bpy.context.scene
    scene.render.engine, scene.cycles.device, scene.cycles.samples = "CYCLES", "CPU", rays
    scene.cycles.use_adaptive_sampling = False
    scene.render.threads_mode, scene.render.threads = "FIXED", 1
    scene.world = scene.world or bpy.data.worlds.new("World")
    scene.world.light_settings.distance = 1000
    scene.render.bake.target = "VERTEX_COLORS"
    copies = [still_copy(thing) for thing in things]
    for copy in copies:
        set_normals(copy.data)
    for other in scene.objects:
        other.hide_render = other not in copies
        other.select_set(other in copies)
    bpy.context.view_layer.objects.active = copies[0]
    start = time.monotonic()
    bpy.ops.object.bake(type="AO")
    seconds = time.monotonic() - start
    values = []
    for copy in copies:
        colors = np.empty(4 * len(copy.data.vertices), np.float32)
        copy.data.attributes["ao"].data.foreach_get("color", colors)
        values.append(colors.reshape(-1, 4)[:, 0])
        bpy.data.objects.remove(copy)
    return np.concatenate(values), seconds


def ours(caches, rays):
    """The same of these frames by penumbra-bake with one thread, and its seconds."""
    cache, bake, table = (os.path.join(FOLDER, "cycles" + e) for e in (".npz", ".vis.h5", ".npy"))
    np.savez(cache, **caches, fps=np.float32(24))
    start = time.monotonic()
    words = ["-o", bake, "--rays", str(rays), "--threads", "1", "-q"]
    subprocess.run([BIN + "/penumbra-bake", "visibility", cache, *words], check=True)
    seconds = time.monotonic() - start
    subprocess.run([BIN + "/penumbra-pack", "export", bake, "-o", table, "--as", "npy", "-q"], check=True)
    return np.load(table), seconds


def main():
    rig, body, box = character.make()
    things, rays, truth, seconds, faces, points = [body, box], int(RAYS), [], 0.0, [], []
    for frame in FRAMES:
        bpy.context.scene.frame_set(frame)
        graph = bpy.context.evaluated_depsgraph_get()
        read = [record.read_mesh(thing, graph, faces if frame == FRAMES[0] else None) for thing in things]
        points.append(np.concatenate([p for p, _ in read]))
        values, taken = cycles(things, rays)
        truth.append(values)
        seconds += taken
    joined = np.concatenate([faces[0], faces[1] + read[0][1][0]]).astype(np.int32)
    table, our_seconds = ours({"verts": np.array(points, np.float32), "faces": joined}, rays)
    difference = table.astype(np.float64) - np.array(truth)
    rms = float(np.sqrt((difference**2).mean()))
    print(f"{len(FRAMES)} frames of {table.shape[1]} vertices, {rays} rays: rms {rms:.4f} of Cycles' bake, "
          f"mean {difference.mean():+.4f}; Cycles {seconds:.2f} s, ours {our_seconds:.2f} s, "
          f"{seconds / our_seconds:.1f} times faster")  # fmt: skip
    print("CYCLES", rms, seconds / our_seconds)


main()
