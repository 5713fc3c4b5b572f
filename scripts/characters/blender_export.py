"""A rigged character that Blender makes and exports: blender -b -P blender_export.py -- FOLDER

A tube of three bones with shape keys, under a node with non-uniform scale; one bone follows a target by a constraint
(exporters bake it); two actions move the bones, a third the shape keys. FOLDER gets it as glTF, FBX and Collada.
"""
import math
import pathlib
import sys

import bpy

folder = pathlib.Path(sys.argv[sys.argv.index("--") + 1])
bpy.ops.wm.read_factory_settings(use_empty=True)
scene = bpy.context.scene
scene.render.fps, scene.frame_start, scene.frame_end = 24, 0, 24


def linked(name, data):
    thing = bpy.data.objects.new(name, data)
    scene.collection.objects.link(thing)
    return thing


def tube(rings=24, corners=12):
    points, faces = [], []
    for ring in range(rings + 1):
        for corner in range(corners):
            turn = 2 * math.pi * corner / corners
            points.append((0.2 * math.cos(turn), 0.2 * math.sin(turn), 1.5 * ring / rings))
    for ring in range(rings):
        for corner in range(corners):
            a, b = ring * corners + corner, ring * corners + (corner + 1) % corners
            faces.append((a, b, b + corners, a + corners))
    mesh = bpy.data.meshes.new("body")
    mesh.from_pydata(points, [], faces)
    return linked("body", mesh)


def skeleton():
    rig = linked("rig", bpy.data.armatures.new("rig"))
    bpy.context.view_layer.objects.active = rig
    bpy.ops.object.mode_set(mode="EDIT")
    parent = None
    for number, name in enumerate(("hip", "spine", "head")):
        bone = rig.data.edit_bones.new(name)
        bone.head, bone.tail, bone.parent = (0, 0, 0.5 * number), (0, 0, 0.5 * number + 0.5), parent
        parent = bone
    bpy.ops.object.mode_set(mode="OBJECT")
    for bone in rig.pose.bones:
        bone.rotation_mode = "XYZ"
    return rig


def skin(body, rig):
    for number, name in enumerate(("hip", "spine", "head")):
        group = body.vertex_groups.new(name=name)
        for vertex in body.data.vertices:
            weight = max(0.0, 1 - abs(vertex.co.z - (0.5 * number + 0.25)) / 0.5)
            if weight > 0:
                group.add([vertex.index], weight, "REPLACE")
    body.parent = rig
    body.modifiers.new("rig", "ARMATURE").object = rig


def shapes(body):
    body.shape_key_add(name="Basis")
    for name, wide in (("smile", 1.6), ("frown", 0.7)):
        key = body.shape_key_add(name=name)
        for point in key.data:
            if point.co.z > 1:
                point.co.x, point.co.y = point.co.x * wide, point.co.y * wide


def action(rig, name, angles):
    rig.animation_data_create()
    rig.animation_data.action = bpy.data.actions.new(name)
    rig.animation_data.action.use_fake_user = True
    for frame, (spine, head) in angles:
        for bone, angle in (("spine", spine), ("head", head)):
            rig.pose.bones[bone].rotation_euler = (math.radians(angle), 0, math.radians(angle / 2))
            rig.pose.bones[bone].keyframe_insert("rotation_euler", frame=frame)
        rig.pose.bones["hip"].scale = (1, 1 + abs(spine) / 180, 1)
        rig.pose.bones["hip"].keyframe_insert("scale", frame=frame)


def export():
    bpy.ops.export_scene.gltf(filepath=str(folder / "blender_tube.glb"), export_format="GLB")
    bpy.ops.export_scene.gltf(filepath=str(folder / "blender_tube.gltf"), export_format="GLTF_EMBEDDED")
    bpy.ops.export_scene.fbx(filepath=str(folder / "blender_tube.fbx"), bake_anim=True, bake_anim_use_all_actions=True,
                             bake_anim_use_nla_strips=False, add_leaf_bones=False)
    bpy.ops.export_scene.fbx(filepath=str(folder / "blender_tube_all.fbx"), apply_scale_options="FBX_SCALE_ALL")
    bpy.ops.wm.collada_export(filepath=str(folder / "blender_tube.dae"), include_animations=True)


body, rig = tube(), skeleton()
shapes(body)
skin(body, rig)
rig.scale, rig.location = (1.5, 1.0, 0.8), (0.3, 0.1, 0)
target = linked("target", None)
target.location = (1, 1, 2)
track = rig.pose.bones["head"].constraints.new("DAMPED_TRACK")
track.target, track.influence = target, 0.5
action(rig, "wave", ((0, (0, 0)), (12, (40, 30)), (24, (0, 0))))
action(rig, "lean", ((0, (0, 0)), (18, (-50, 20))))
keys = body.data.shape_keys
for frame, value in ((0, 0.0), (12, 1.0), (24, 0.2)):
    keys.key_blocks["smile"].value = value
    keys.key_blocks["smile"].keyframe_insert("value", frame=frame)
folder.mkdir(parents=True, exist_ok=True)
export()
