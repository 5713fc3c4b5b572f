"""Runs in Blender for test_blender.py: the add-on from its zip, both routes, and what must be refused.

usage: blender -b --factory-startup --python blender_steps.py -- ZIP BIN FOLDER
"""
import os
import pathlib
import sys

import bpy
import numpy as np

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path[:0] = [HERE, os.path.join(HERE, "..", "..", "scripts", "blender")]
import blender_faults as faults  # noqa: E402
import character  # noqa: E402
from blender_common import check, refused, said, values, worst_difference  # noqa: E402

ARCHIVE, BIN, FOLDER = sys.argv[sys.argv.index("--") + 1 :]


def table_of(thing):
    """The numbers [F,V] of the last bake, by the button that exports them."""
    words = {"character": thing.name, "kind": "npy", "filepath": os.path.join(FOLDER, "table.npy")}
    check(bpy.ops.penumbra.export(**words) == {"FINISHED"}, said(thing.penumbra))
    return np.load(words["filepath"])


def bake_frames(rig, things):
    settings = rig.penumbra
    check(bpy.ops.penumbra.bake_frames() == {"FINISHED"}, said(settings))
    table = table_of(rig)
    check(table.min() < 0.5 and table.max() > 0.9, "occlusion has a range", table.min(), table.max())
    frames = range(1, character.FRAMES + 1)
    worst = worst_difference(things, "penumbra_ao", table, frames)
    print("route A: frames", len(table), "vertices", table.shape[1], "largest difference", worst)
    check(worst <= 1e-6, worst)
    return table


def survives(rig, table):
    """The saved file plays without the add-on, also between frames."""
    path = os.path.join(FOLDER, "saved with blanks ü.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path, compress=True)
    bpy.ops.preferences.addon_disable(module="penumbra_addon")
    bpy.ops.wm.open_mainfile(filepath=path)
    things = [bpy.data.objects["Body"], bpy.data.objects["Box"]]
    worst = worst_difference(things, "penumbra_ao", table, range(1, 4))
    bpy.context.scene.frame_set(5, subframe=0.5)
    between = np.concatenate([values(thing, "penumbra_ao") for thing in things])
    half = abs(between - (table[4] + table[5]) / 2).max()
    print("without the add-on: largest difference", worst, "between two frames", half)
    check(worst <= 1e-6 and half <= 1e-6, worst, half)
    bpy.ops.preferences.addon_enable(module="penumbra_addon")


def enable():
    bpy.ops.preferences.addon_install(filepath=ARCHIVE, overwrite=True)
    bpy.ops.preferences.addon_enable(module="penumbra_addon")
    bpy.context.preferences.addons["penumbra_addon"].preferences.folder = BIN


def main():
    rig, body, box = character.make()
    enable()
    bpy.context.scene.penumbra_character = rig
    bpy.context.view_layer.objects.active = rig
    settings = rig.penumbra
    settings.folder, settings.quality, settings.rays = FOLDER, "OWN", 64
    table = bake_frames(rig, [body, box])
    survives(rig, table)
    rig, body, box = (bpy.data.objects[name] for name in ("Hero", "Body", "Box"))
    check(rig.penumbra.rays == 64, "settings are saved in the .blend")
    bpy.context.preferences.addons["penumbra_addon"].preferences.folder = BIN
    bpy.context.view_layer.objects.active = rig
    make_asset(rig, [body, box])
    compare_and_export(rig)
    faults.other_versions()
    faults.names_of_files(FOLDER)
    faults.mouse_of_a_job()
    faults.show(body)
    refusals(rig, body, box)
    roles(rig, body, box)
    clips(rig, body, box)
    sheet()
    faults.twins(rig, box)
    rig_file = rig.penumbra.rig
    bad_inputs(rig)
    stopped(pathlib.Path(rig_file))
    faults.deleted_under_a_job("Hero")
    print("PASSED")


def paint_with_picture(thing):
    image = bpy.data.images.new("Grain", 8, 8)
    image.pixels.foreach_set(np.tile(np.array([0.5, 0.3, 0.1, 1], np.float32), 64))
    image.pack()
    tree = thing.material_slots[0].material.node_tree
    texture = tree.nodes.new("ShaderNodeTexImage")
    texture.image = image
    tree.links.new(texture.outputs["Color"], tree.nodes["Principled BSDF"].inputs["Base Color"])


def make_asset(rig, things):
    settings = rig.penumbra
    paint_with_picture(things[1])
    check(bpy.ops.penumbra.make_asset() == {"FINISHED"}, said(settings))
    print("route B:", said(settings), "pose error", settings.pose_error)
    check(0 < settings.pose_error <= 1e-4, settings.pose_error)
    check(b"\x89PNG" in pathlib.Path(settings.asset).read_bytes(), "the asset has the picture of the box")


def compare_and_export(rig):
    settings = rig.penumbra
    things = [bpy.data.objects["Body"], bpy.data.objects["Box"]]
    check(bpy.ops.penumbra.compare() == {"FINISHED"}, said(settings))
    bpy.context.scene.frame_set(12)
    both = [np.concatenate([values(t, "penumbra_ao" + e) for t in things]) for e in ("", "_model")]
    print("compare:", said(settings), "mean difference in frame 12", abs(both[0] - both[1]).mean())
    check(1e-5 < abs(both[0] - both[1]).mean() < 0.05, "the model is near the bake and not the bake")
    sizes = {}
    for kind in ("static", "play", "table", "npy"):
        check(bpy.ops.penumbra.export(kind=kind) == {"FINISHED"}, kind, said(settings))
        path = said(settings).removesuffix(" is written")
        sizes[path] = os.path.getsize(path)
        check(sizes[path] > 1000, path)
        print("export:", kind, os.path.basename(path), sizes[path], "bytes")
    check(len(sizes) == 4, "every kind has a name of its own", sizes)
    for words in ({"kind": "play", "max_error": 0.05}, {"kind": "table", "bent": True, "use_model": True}):
        path = os.path.join(FOLDER, "options" + (".glb" if words["kind"] == "play" else ".exr"))
        check(bpy.ops.penumbra.export(filepath=path, **words) == {"FINISHED"}, said(settings))
        check(os.path.getsize(path) not in (0, *sizes.values()), "the options are heard", words)
    refused(lambda: bpy.ops.penumbra.export(kind="npy", clips="no such"), settings, "no such")


def roles(rig, body, box):
    """A collection leaves the box out, and a custom property makes a moving plate an occluder."""
    settings, scene = rig.penumbra, bpy.context.scene
    left_out = bpy.data.collections.new("not in the bake")
    scene.collection.children.link(left_out)
    left_out.objects.link(box)
    left_out["penumbra_role"] = "without"
    settings.frames, settings.first, settings.last, settings.step = "OWN", 1, 13, 12
    check(bpy.ops.penumbra.bake_frames() == {"FINISHED"}, said(settings))
    alone = table_of(rig)
    check(alone.shape == (2, len(body.evaluated_get(bpy.context.evaluated_depsgraph_get()).data.vertices)), alone.shape)
    bpy.ops.mesh.primitive_cube_add(size=1, location=(0, -9, 1.3))
    plate = bpy.context.object
    plate.scale = 1, 0.05, 1
    plate.keyframe_insert("location", frame=12)
    plate.location = 0, -0.5, 1.3
    plate.keyframe_insert("location", frame=13)
    plate["penumbra_role"] = "occluder"
    check(bpy.ops.penumbra.bake_frames() == {"FINISHED"}, said(settings))
    beside = table_of(rig)
    near, far = alone[1].mean() - beside[1].mean(), alone[0].mean() - beside[0].mean()
    print("roles: the plate hides", near, "where it is near and", far, "where it is far")
    check(near > 0.03 > 0.01 > abs(far), near, far)
    check(bpy.ops.penumbra.make_asset() == {"FINISHED"}, said(settings))
    check("occluders that move" in said(settings), said(settings))
    plate["penumbra_role"] = "rubbish"
    refused(bpy.ops.penumbra.bake_frames, settings, "penumbra_role is 'rubbish'")
    bpy.data.objects.remove(plate)
    bpy.data.collections.remove(left_out)


def clips(rig, body, box):
    """Two actions, one after the other; then one of them again, as the timeline plays it."""
    settings, scene = rig.penumbra, bpy.context.scene
    bend = bpy.data.actions["move"].copy()
    bend.name = "bend ü"
    for curve in bend.fcurves:
        for point in curve.keyframe_points:
            point.co.x = 3 + (point.co.x - 1) / 2
        curve.update()
    for curve in [c for c in bend.fcurves if "leg.L" in c.data_path]:  # a bone that this clip leaves alone
        bend.fcurves.remove(curve)
    rig.animation_data.action = bend
    leg, head = rig.pose.bones["leg.L"], rig.pose.bones["head"]
    leg.rotation_euler, head.rotation_euler = (0.25, 0, 0), (0, 0, 0.5)  # without keys
    settings.frames, settings.clips, settings.step = "CLIPS", "move, bend ü", 1
    before, actions = rig.animation_data.action, bpy.data.actions.keys()
    check(bpy.ops.penumbra.make_asset() == {"FINISHED"}, said(settings))
    check(rig.animation_data.action == before and len(bpy.data.scenes) == 1, "the scene is as it was")
    check(bpy.data.actions.keys() == actions, bpy.data.actions.keys(), actions)
    names = [(c.name, c.first_row, c.rows, c.first_frame) for c in settings.played]
    check(names == [("move", 0, 24, 1), ("bend ü", 24, 12, 3)], names)
    posed = [tuple(round(angle, 6) for angle in bone.rotation_euler) for bone in (leg, head)]
    check(posed == [(0.25, 0, 0), (0, 0, 0.5)], "the user's own pose is as it was", posed)
    check(bpy.ops.penumbra.bake_frames() == {"FINISHED"}, said(settings))
    table = table_of(rig)
    worst = []
    for name, first, rows, start in names:
        bpy.ops.penumbra.play(clip=name)
        check(rig.animation_data.action.name == name, name)
        leg.rotation_euler = 0.25, 0, 0
        worst.append(worst_difference([body, box], "penumbra_ao", table[first : first + rows], range(start, start + rows)))
    print("clips: largest differences", worst)
    check(max(worst) <= 1e-6, worst)


def sheet():
    """A mesh without bones, which a modifier moves; then one that changes its number of vertices."""
    bpy.ops.mesh.primitive_grid_add(x_subdivisions=12, y_subdivisions=12, size=2, location=(5, 0, 0))
    thing = bpy.context.object
    thing.name = "Sheet, ü"
    thing.modifiers.new("Wave", "WAVE").height = 0.6
    settings = thing.penumbra
    settings.folder, settings.quality, settings.rays = FOLDER, "OWN", 64
    settings.frames, settings.first, settings.last = "OWN", 30, 32
    words = {"character": thing.name}
    check(bpy.ops.penumbra.bake_frames(**words) == {"FINISHED"}, said(settings))
    table = table_of(thing)
    check(table.min() < 0.9 and worst_difference([thing], "penumbra_ao", table, range(30, 33)) <= 1e-6, table.min())
    refused(lambda: bpy.ops.penumbra.make_asset(**words), settings, "has no armature")
    thing.modifiers.new("Build", "BUILD").frame_duration = 50
    refused(lambda: bpy.ops.penumbra.bake_frames(**words), settings, "a modifier changes the mesh")
    bpy.ops.object.mode_set(mode="EDIT")
    refused(lambda: bpy.ops.penumbra.bake_frames(**words), settings, "is in edit mode")
    bpy.ops.object.mode_set(mode="OBJECT")
    bpy.data.objects.remove(thing)


def bad_inputs(rig):
    bpy.context.view_layer.objects.active = rig
    settings, chosen = rig.penumbra, bpy.context.preferences.addons["penumbra_addon"].preferences
    settings.frames, settings.clips = "CLIPS", "no such clip"
    refused(bpy.ops.penumbra.bake_frames, settings, "there is no action 'no such clip'")
    settings.frames, settings.first, settings.last = "OWN", 5, 4
    refused(bpy.ops.penumbra.bake_frames, settings, "before the first")
    settings.last = 6
    folder, settings.folder = settings.folder, ARCHIVE
    refused(bpy.ops.penumbra.bake_frames, settings, "cannot be made")
    settings.folder, chosen.folder = folder, FOLDER
    refused(bpy.ops.penumbra.bake_frames, settings, "was not found in")
    chosen.folder, chosen.prefix = BIN, "no-such-command run"
    refused(bpy.ops.penumbra.bake_frames, settings, "cannot be started")
    # A command before the programs, and files of another name where they run.
    there = os.path.join(FOLDER, "there")
    os.symlink(FOLDER, there)
    chosen.prefix, chosen.path_from, chosen.path_to = "nice -n 1", FOLDER, there
    check(bpy.ops.penumbra.bake_frames() == {"FINISHED"}, said(settings))
    check(settings.frame_count == 2, "by a prefix")
    chosen.prefix = chosen.path_from = chosen.path_to = ""
    settings.attribute = " "
    refused(bpy.ops.penumbra.bake_frames, settings, "the attribute has no name")
    settings.attribute = "other_ao"
    check(bpy.ops.penumbra.bake_frames() == {"FINISHED"}, said(settings))
    names = [m.name for m in bpy.data.objects["Body"].modifiers if m.name.startswith("Penumbra")]
    check(names == ["Penumbra other_ao"], "the modifier of the old name is gone", names)
    settings.frame_count += 1
    refused(lambda: bpy.ops.penumbra.export(kind="npy"), settings, "of the last run: bake again")


def stopped(rig_file):
    """Whoever closes a run stops the program, which leaves no file."""
    from penumbra_addon import preferences, routes

    out = os.path.join(FOLDER, "stopped.vis.h5")
    words = [rig_file, "-o", out, "--rays", 65536, *routes.TELL]
    running = preferences.programs(bpy.context).run("bake", "visibility", *words)
    share = 0.0
    while share == 0.0:
        share, status = next(running)
    running.close()
    print("stopped: at", share, status)
    check(share < 1 and not [name for name in os.listdir(FOLDER) if name.startswith("stopped")], os.listdir(FOLDER))
    left = [name for name in os.listdir(FOLDER) if name.endswith((".npz", ".info.json", ".values.npy", ".positions.npy"))]
    check(not left, "files between are removed", left)


def refusals(rig, body, box):
    settings = rig.penumbra
    armature = body.modifiers["Armature"]
    armature.use_deform_preserve_volume = True
    refused(bpy.ops.penumbra.make_asset, settings, "Preserve Volume")
    armature.use_deform_preserve_volume = False
    wave = body.modifiers.new("Wobble", "DISPLACE")
    wave.strength, wave.mid_level = 0.05, 0
    refused(bpy.ops.penumbra.make_asset, settings, "modifiers after the armature (Wobble)")
    body.modifiers.remove(wave)


main()
