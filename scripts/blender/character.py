"""Makes a character in Blender: a body of two materials with a shape key and subdivision, bones, a box in the hand.

Runs in Blender's Python, for tests and for the pictures of docs/blender.md.
"""
import math

import bpy
from mathutils import Vector

FRAMES = 24
STICKS = {  # bone: (parent, head, tail, radius of the body there)
    "spine": ("", (0, 0, 1.0), (0, 0, 1.35), 0.16),
    "chest": ("spine", (0, 0, 1.35), (0, 0, 1.6), 0.17),
    "head": ("chest", (0, 0, 1.6), (0, 0, 1.95), 0.12),
    "arm.L": ("chest", (0.2, 0, 1.55), (0.5, 0, 1.5), 0.06),
    "hand.L": ("arm.L", (0.5, 0, 1.5), (0.82, 0, 1.48), 0.05),
    "arm.R": ("chest", (-0.2, 0, 1.55), (-0.5, 0, 1.5), 0.06),
    "hand.R": ("arm.R", (-0.5, 0, 1.5), (-0.82, 0, 1.48), 0.05),
    "leg.L": ("", (0.11, 0, 0.95), (0.14, 0.02, 0.5), 0.09),
    "foot.L": ("leg.L", (0.14, 0.02, 0.5), (0.15, 0, 0.06), 0.06),
    "leg.R": ("", (-0.11, 0, 0.95), (-0.14, 0.02, 0.5), 0.09),
    "foot.R": ("leg.R", (-0.14, 0.02, 0.5), (-0.15, 0, 0.06), 0.06),
}


def make_body():
    """A skin around the sticks, whose vertices follow the nearest ones."""
    places, edges, radii = [Vector((0, 0, 0.98))], [], [0.17]

    def at(place, radius):
        for number, known in enumerate(places):
            if (known - Vector(place)).length < 0.02:
                return number
        places.append(Vector(place))
        radii.append(radius)
        return len(places) - 1

    for name, (parent, head, tail, radius) in STICKS.items():
        start = at(head, radius)
        if not parent or (Vector(head) - Vector(STICKS[parent][2])).length > 0.02:
            edges.append((at(STICKS[parent][1], 0.16) if parent else 0, start))
        edges.append((start, at(tail, radius * 0.8)))
    mesh = bpy.data.meshes.new("Body")
    mesh.from_pydata(places, [edge for edge in edges if edge[0] != edge[1]], [])
    body = bpy.data.objects.new("Body", mesh)
    bpy.context.scene.collection.objects.link(body)
    body.modifiers.new("Skin", "SKIN")
    for vertex, radius in zip(mesh.skin_vertices[0].data, radii):
        vertex.radius = radius, radius
    mesh.skin_vertices[0].data[0].use_root = True
    body.modifiers.new("Round", "SUBSURF").levels = 1
    graph = bpy.context.evaluated_depsgraph_get()
    body.data = bpy.data.meshes.new_from_object(body.evaluated_get(graph))
    body.modifiers.clear()
    return body


def make_armature():
    rig = bpy.data.objects.new("Hero", bpy.data.armatures.new("Hero"))
    bpy.context.scene.collection.objects.link(rig)
    bpy.context.view_layer.objects.active = rig
    bpy.ops.object.mode_set(mode="EDIT")
    for name, (parent, head, tail, _) in STICKS.items():
        bone = rig.data.edit_bones.new(name)
        bone.head, bone.tail = head, tail
        if parent:
            bone.parent = rig.data.edit_bones[parent]
    bpy.ops.object.mode_set(mode="OBJECT")
    for bone in rig.pose.bones:
        bone.rotation_mode = "XYZ"
    return rig


def distance(point, head, tail):
    line = tail - head
    share = min(max((point - head).dot(line) / line.length_squared, 0), 1)
    return (point - head - line * share).length


def weigh(body):
    """Weights by the distance to the sticks: smooth, and at most four a vertex."""
    for name in STICKS:
        body.vertex_groups.new(name=name)
    for vertex in body.data.vertices:
        near = sorted((distance(vertex.co, Vector(h), Vector(t)) / r, name) for name, (_, h, t, r) in STICKS.items())[:4]
        weights = [(max(1e-3, near[0][0] + 1.0 - d), name) for d, name in near if d < near[0][0] + 1.0]
        total = sum(w**3 for w, _ in weights)
        for weight, name in weights:
            body.vertex_groups[name].add([vertex.index], weight**3 / total, "REPLACE")


def paint(thing, *materials):
    for name, color in materials:
        material = bpy.data.materials.get(name) or bpy.data.materials.new(name)
        material.use_nodes = True
        material.node_tree.nodes["Principled BSDF"].inputs["Base Color"].default_value = (*color, 1)
        material.node_tree.nodes["Principled BSDF"].inputs["Roughness"].default_value = 0.8
        thing.data.materials.append(material)
    for face in thing.data.polygons:
        face.use_smooth = True


def add_shape(body):
    body.shape_key_add(name="Basis", from_mix=False)
    belly = body.shape_key_add(name="Belly", from_mix=False)
    for vertex, target in zip(body.data.vertices, belly.data):
        near = math.exp(-((vertex.co - Vector((0, -0.1, 1.2))).length_squared) / 0.04)
        target.co = vertex.co + Vector((0, -0.12 * near, 0))
    for frame, value in ((1, 0.0), (12, 1.0), (FRAMES, 0.2)):
        belly.value = value
        belly.keyframe_insert("value", frame=frame)


def animate(rig):
    turns = {"arm.L": (0, 0.2, 1.2), "hand.L": (0.2, 0, 1.3), "arm.R": (0.9, 0, -0.3), "leg.L": (-0.6, 0, 0)}
    turns["spine"] = (0.2, 0.3, 0)
    for name, turn in turns.items():
        bone = rig.pose.bones[name]
        for frame, share in ((1, 0.0), (12, 1.0), (FRAMES, 0.4)):
            bone.rotation_euler = [share * angle for angle in turn]
            bone.keyframe_insert("rotation_euler", frame=frame)
    rig.animation_data.action.name = "move"


def make_box(rig):
    bpy.ops.mesh.primitive_cube_add(size=0.16, location=(-0.86, 0, 1.48))
    box = bpy.context.object
    box.name = "Box"
    box.modifiers.new("Bevel", "BEVEL").width = 0.02
    paint(box, ("Wood", (0.5, 0.3, 0.1)))
    place = box.matrix_world.copy()
    box.parent, box.parent_type, box.parent_bone = rig, "BONE", "hand.R"
    bpy.context.view_layer.update()
    box.matrix_world = place
    return box


def make():
    """Makes the character the only thing in the scene; returns (armature, body, box)."""
    for thing in list(bpy.data.objects):
        bpy.data.objects.remove(thing)
    scene = bpy.context.scene
    scene.frame_start, scene.frame_end, scene.render.fps = 1, FRAMES, 24
    body, rig = make_body(), make_armature()
    weigh(body)
    paint(body, ("Skin", (0.8, 0.55, 0.4)), ("Cloth", (0.2, 0.3, 0.6)))
    for face in body.data.polygons:
        face.material_index = int(face.center.z < 1.45)
    add_shape(body)
    round_ = body.modifiers.new("Smooth", "SUBSURF")
    round_.levels = round_.render_levels = 1
    body.parent = rig
    body.modifiers.new("Armature", "ARMATURE").object = rig
    animate(rig)
    return rig, body, make_box(rig)
