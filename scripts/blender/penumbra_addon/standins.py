"""A clean copy of a recorded character in a scene of its own, for the exporter of glTF.

The copy has what glTF can say and nothing else: bones with a key in every frame, meshes whose modifiers other than the
armature are applied, shape keys with their weights. So constraints, drivers, NLA tracks and modifiers of the original
come along as far as the format has them, and the exporter need not step through the heavy scene. `causes.py` tells what
the format does not have.
"""
from dataclasses import dataclass, field

import bpy
import numpy as np
from mathutils import Matrix

from .glb import VERTEX
from .play import is_ours
from .programs import Failed


@dataclass
class StandIns:
    scene: object
    names: dict = field(default_factory=dict)  # name of each copy -> name of its original
    of_data: dict = field(default_factory=dict)  # the same of their meshes and armatures
    objects: list = field(default_factory=list)
    actions: list = field(default_factory=list)
    clips: dict = field(default_factory=dict)  # names of the actions -> of the clips
    armature: object = None

    def remove(self):
        for thing in self.objects:
            data = thing.data
            bpy.data.objects.remove(thing)
            if data and not data.users:
                (bpy.data.armatures if isinstance(data, bpy.types.Armature) else bpy.data.meshes).remove(data)
        for action in self.actions:
            bpy.data.actions.remove(action)
        bpy.data.scenes.remove(self.scene)


def armature_modifiers(thing, armature):
    """The modifiers of a mesh, in the viewport, by which the armature moves it."""
    return [m for m in thing.modifiers if m.type == "ARMATURE" and m.object == armature and m.show_viewport]


def is_skinned(thing, armature):
    by_parent = thing.parent == armature and thing.parent_type == "ARMATURE"
    return armature is not None and (by_parent or bool(armature_modifiers(thing, armature)))


def build(context, who, things, record):
    """The copies of the armature and of `things`, in a new scene."""
    render = context.scene.render
    scene = bpy.data.scenes.new("Penumbra export")
    result = StandIns(scene)
    try:
        scene.render.fps, scene.render.fps_base = render.fps, render.fps_base * record.spans[0].step
        scene.frame_start, scene.frame_end = 0, max(span.count for span in record.spans) - 1
        result.armature = copy_armature(result, who.armature, record)
        for number, thing in enumerate(things):
            copy_mesh(context, result, thing, number, who, record)
    except BaseException:
        result.remove()
        raise
    return result


def add(result, thing, original):
    result.scene.collection.objects.link(thing)
    result.objects.append(thing)
    result.names[thing.name] = original.name
    result.of_data[thing.data.name] = original.data.name
    plain(thing)


def plain(thing):
    """Takes everything from an object that would move it beside its matrix."""
    thing.animation_data_clear()
    thing.constraints.clear()
    thing.delta_location, thing.delta_scale = (0, 0, 0), (1, 1, 1)
    thing.delta_rotation_euler, thing.delta_rotation_quaternion = (0, 0, 0), (1, 0, 0, 0)


def copy_armature(result, armature, record):
    copy = armature.copy()
    copy.data = armature.data.copy()
    add(result, copy, armature)
    copy.data.animation_data_clear()
    copy.parent = None
    copy.data.pose_position = "POSE"
    for bone in copy.data.bones:
        bone.use_inherit_rotation, bone.inherit_scale, bone.use_local_location = True, "FULL", True
        bone.bbone_segments = 1
    for bone in copy.pose.bones:
        bone.rotation_mode = "QUATERNION"
        while bone.constraints:
            bone.constraints.remove(bone.constraints[0])
    copy.matrix_world = Matrix(record.armature[0])
    for span in record.spans:
        first, end = record.rows_of(span)
        action = bone_action(span.name, copy, record.bones[first:end])
        if not np.allclose(record.armature, record.armature[0], atol=1e-7):
            copy.rotation_mode = "QUATERNION"
            key_matrices(action, "", record.armature[first:end], "Object")
        hang(result, copy, action, span)
    return copy


def hang(result, holder, action, span):
    """An NLA track for the clip: tracks of one name become one clip of the file."""
    data = holder.animation_data or holder.animation_data_create()
    track = data.nla_tracks.new()
    track.name = span.name
    track.strips.new(span.name, 0, action).name = span.name
    result.actions.append(action)
    result.clips[action.name] = span.name


def local_matrices(armature, poses):
    """matrix_basis [F,B,4,4] of bones from their matrices in the armature's space [F,B,4,4]."""
    bones = armature.data.bones
    index = {bone.name: number for number, bone in enumerate(bones)}
    rest = np.array([np.array(bone.matrix_local) for bone in bones])
    basis = np.empty_like(poses)
    for number, bone in enumerate(bones):
        if bone.parent is None:
            above = np.broadcast_to(rest[number], poses[:, number].shape)
        else:
            parent = index[bone.parent.name]
            above = poses[:, parent] @ (np.linalg.inv(rest[parent]) @ rest[number])
        basis[:, number] = np.linalg.pinv(above) @ poses[:, number]
    return basis


def bone_action(name, armature, poses):
    action = bpy.data.actions.new(name)
    basis = local_matrices(armature, poses)
    for number, bone in enumerate(armature.data.bones):
        path = f'pose.bones["{bpy.utils.escape_identifier(bone.name)}"].'
        key_matrices(action, path, basis[:, number], bone.name)
    return action


def key_matrices(action, path, matrices, group):
    """Keys for place, turn and scale in frames 0, 1, 2, ..."""
    parts = [Matrix(m).decompose() for m in matrices]
    turns = np.array([turn for _, turn, _ in parts])
    for row in range(1, len(turns)):  # a quaternion and its opposite are one turn
        if turns[row] @ turns[row - 1] < 0:
            turns[row] *= -1
    places, scales = np.array([place for place, _, _ in parts]), np.array([scale for _, _, scale in parts])
    for name, values in (("location", places), ("rotation_quaternion", turns), ("scale", scales)):
        for axis in range(values.shape[1]):
            key(action, path + name, axis, values[:, axis], group)


def key(action, path, axis, values, group):
    curve = action.fcurves.new(data_path=path, index=axis, action_group=group)
    curve.keyframe_points.add(len(values))
    curve.keyframe_points.foreach_set("co", np.stack([np.arange(len(values)), values], -1).astype(np.float32).ravel())
    for point in curve.keyframe_points:
        point.interpolation = "LINEAR"
    curve.update()


def copy_mesh(context, result, thing, number, who, record):
    skinned = is_skinned(thing, who.armature)
    mesh, shapes = applied(result, thing, who.armature, record.counts[number])
    copy = thing.copy()
    copy.data = mesh
    add(result, copy, thing)
    copy.modifiers.clear()
    for group in thing.vertex_groups[len(copy.vertex_groups) :]:
        copy.vertex_groups.new(name=group.name)
    for index, slot in enumerate(thing.material_slots[: len(mesh.materials)]):
        mesh.materials[index] = slot.material
    number_vertices(mesh, int(record.counts[:number].sum()))
    if shapes:
        add_shapes(copy, shapes)
    place(copy, thing, skinned, result.armature, record, number)
    if shapes:
        key_shapes(result, copy, record, number)


def number_vertices(mesh, first):
    attribute = mesh.attributes.new(VERTEX, "INT", "POINT")
    attribute.data.foreach_set("value", np.arange(first, first + len(mesh.vertices), dtype=np.int32))


def applied(result, thing, armature, count):
    """The mesh with all modifiers but the armature's, and where each shape key alone moves its vertices."""
    probe = thing.copy()
    probe.data = thing.data.copy()
    result.scene.collection.objects.link(probe)
    try:
        probe.parent = None
        plain(probe)
        probe.matrix_world = thing.matrix_world
        for modifier in armature_modifiers(probe, armature) + [m for m in probe.modifiers if is_ours(m)]:
            probe.modifiers.remove(modifier)  # ours too: an earlier result is no colour of the character
        blocks = probe.data.shape_keys.key_blocks[1:] if probe.data.shape_keys else []
        if blocks:
            probe.data.shape_keys.animation_data_clear()
        probe.show_only_shape_key = False
        return evaluate(result.scene, thing, probe, [b for b in blocks if not b.mute], count)
    finally:
        data = probe.data
        bpy.data.objects.remove(probe)
        bpy.data.meshes.remove(data)


def evaluate(scene, thing, probe, blocks, count):
    for block in blocks:
        block.slider_min, block.slider_max, block.value = 0, 1, 0
    layer = scene.view_layers[0]

    def now():
        probe.data.update_tag()
        probe.update_tag()
        layer.update()
        return probe.evaluated_get(layer.depsgraph)

    mesh = bpy.data.meshes.new_from_object(now(), preserve_all_data_layers=True, depsgraph=layer.depsgraph)
    if len(mesh.vertices) != count:
        bpy.data.meshes.remove(mesh)
        raise Failed(f"{thing.name}: modifiers make another number of vertices at rest; apply those that do")
    shapes = {}
    for block in blocks:
        block.value = 1
        shapes[block.name] = positions(now(), thing, count)
        block.value = 0
    return mesh, shapes


def positions(evaluated, thing, count):
    mesh = evaluated.to_mesh()
    if len(mesh.vertices) != count:
        raise Failed(f"{thing.name}: its modifiers make another number of vertices for a shape key")
    values = np.empty(3 * count, np.float32)
    mesh.vertices.foreach_get("co", values)
    evaluated.to_mesh_clear()
    return values


def add_shapes(copy, shapes):
    copy.shape_key_add(name="Basis", from_mix=False)
    for name, values in shapes.items():
        block = copy.shape_key_add(name=name, from_mix=False)
        block.data.foreach_set("co", values)
        block.slider_min, block.slider_max = -10, 10


def key_shapes(result, copy, record, number):
    """Weights of the shape keys in every frame, as clips of the bones' names."""
    for span in record.spans:
        first, end = record.rows_of(span)
        action = bpy.data.actions.new(span.name + " shapes")
        for name in copy.data.shape_keys.key_blocks.keys()[1:]:
            path = f'key_blocks["{bpy.utils.escape_identifier(name)}"].value'
            key(action, path, 0, record.keys[number][name][first:end], "Shapes")
        hang(result, copy.data.shape_keys, action, span)


def place(copy, thing, skinned, armature, record, number):
    """Makes the copy a child of the armature's copy, where the original is in the first frame."""
    to_armature = np.linalg.inv(record.armature[0]) @ record.meshes[0, number]
    bone = thing.parent_bone if thing.parent_type == "BONE" and thing.parent and not skinned else ""
    copy.parent, copy.matrix_parent_inverse = armature, Matrix()
    copy.parent_type = "BONE" if bone in armature.data.bones else "OBJECT"
    if skinned:
        # All vertices in the armature's space, so that no matrix of the object is left to lose.
        copy.data.transform(Matrix(to_armature), shape_keys=True)
        if np.linalg.det(to_armature[:3, :3]) < 0:
            copy.data.flip_normals()
        copy.matrix_basis = Matrix()
        copy.modifiers.new("Armature", "ARMATURE").object = armature
        drop_groups(copy, armature)
    elif copy.parent_type == "BONE":
        copy.parent_bone = bone
        index = armature.data.bones.find(bone)
        tip = np.array(Matrix.Translation((0, armature.data.bones[bone].length, 0)))
        copy.matrix_basis = Matrix(np.linalg.inv(record.bones[0, index] @ tip) @ to_armature)
    else:
        copy.matrix_basis = Matrix(to_armature)


def drop_groups(copy, armature):
    """Takes away the weights of bones that do not deform, which the armature modifier passes over."""
    for group in list(copy.vertex_groups):
        bone = armature.data.bones.get(group.name)
        if bone is None or not bone.use_deform:
            copy.vertex_groups.remove(group)
