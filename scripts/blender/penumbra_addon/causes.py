"""Why the exported character is not where Blender shows it. Only what was seen to differ is looked into."""
import numpy as np

from .play import is_ours
from .standins import armature_modifiers, is_skinned, local_matrices

# Modifiers that may give another shape in every frame. Those that do not are no cause, and then nothing differs.
MOVING = set(
    "CLOTH SOFT_BODY WAVE OCEAN BUILD MESH_CACHE HOOK NODES SURFACE_DEFORM MESH_DEFORM LATTICE SHRINKWRAP CURVE".split()
)
MOST = 1e-4  # distance of a posed vertex, in diagonals of the character


def errors(record, posed, vertex_of_source):
    """Largest distance of each mesh's vertices, in diagonals of the first frame.

    posed: f32 [F,R,3] of the programs; vertex_of_source: int [R].
    """
    first = record.points[0]
    diagonal = float(np.linalg.norm(first.max(0) - first.min(0))) or 1.0
    mesh_of = np.repeat(np.arange(len(record.counts)), record.counts)[vertex_of_source]
    worst = np.zeros(len(record.counts))
    for row, points in enumerate(posed):
        distance = np.linalg.norm(points - record.points[row][vertex_of_source], axis=-1)
        np.maximum.at(worst, mesh_of, np.where(np.isfinite(distance), distance, np.inf))
    return worst / diagonal


def unmatched(record, vertex_of_source):
    """How many vertices of faces the file does not have."""
    missing = record.used.copy()
    missing[vertex_of_source] = False
    return int(missing.sum())


def modifier_causes(thing, armature):
    found = []
    mods = [m for m in thing.modifiers if m.show_viewport]
    movers = armature_modifiers(thing, armature)
    last = mods.index(movers[-1]) if movers else len(mods)
    after = [m.name for m in mods[last + 1 :] if not is_ours(m)]
    if after:
        found.append(f"modifiers after the armature ({', '.join(after)}): move them before it, or apply them")
    if any(m.use_deform_preserve_volume for m in movers):
        found.append("Preserve Volume of the armature modifier: glTF has no dual quaternions")
    if any(m.use_bone_envelopes for m in movers):
        found.append("bone envelopes: bake them into weights")
    if any(m.vertex_group or m.use_multi_modifier for m in movers) or len(movers) > 1:
        found.append("several or masked armature modifiers: one with plain weights is what glTF has")
    moving = [m.name for m in mods[:last] if m.type in MOVING and not is_ours(m)]
    if moving:
        found.append(f"modifiers that move the mesh ({', '.join(moving)}): glTF keeps the shape of rest")
    return found


def motion_causes(thing, armature, record, number):
    found = []
    shape = thing.data.shape_keys
    if shape and not shape.use_relative:
        found.append("absolute shape keys: glTF has relative ones")
    local = np.linalg.inv(record.armature) @ record.meshes[:, number]
    if is_skinned(thing, armature):
        if not np.allclose(local, local[0], atol=1e-5):
            found.append("the object moves by itself beside its armature")
        return found + bone_causes(armature, record)
    bone = thing.parent_bone if thing.parent_type == "BONE" else ""
    index = armature.data.bones.find(bone)
    if index >= 0:
        local = np.linalg.inv(record.bones[:, index]) @ local
    if not np.allclose(local, local[0], atol=1e-5):
        found.append("the object moves by itself: parent it to a bone that moves so")
    return found + bone_causes(armature, record)


def bone_causes(armature, record):
    found = []
    bendy = [bone.name for bone in armature.data.bones if bone.bbone_segments > 1]
    if bendy:
        found.append(f"bendy bones ({', '.join(bendy[:3])}): glTF has straight ones")
    axes = local_matrices(armature, record.bones)[..., :3, :3]
    square = np.swapaxes(axes, -1, -2) @ axes
    sheared = abs(square - square * np.eye(3)).max(axis=(0, 2, 3)) > 1e-4 * abs(square).max()
    names = [bone.name for bone, is_sheared in zip(armature.data.bones, sheared) if is_sheared]
    if names:
        found.append(f"bones that are sheared by an uneven scale above them ({', '.join(names[:3])})")
    return found


def explain(things, armature, record, worst):
    """A line for each mesh that is off by more than MOST."""
    lines = []
    for number, (thing, error) in enumerate(zip(things, worst)):
        if error <= MOST:
            continue
        found = modifier_causes(thing, armature) + motion_causes(thing, armature, record, number)
        cause = "; ".join(found) or "no known cause: bake the frames instead"
        lines.append(f"{thing.name} is off by {error:.1e} diagonals: {cause}")
    return lines
