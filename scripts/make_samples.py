"""Writes the synthetic rigs of data-samples/README.md: make_samples.py FOLDER. Needs numpy only; same bytes every time."""
import json
import os
import struct
import sys

import numpy as np

COMPONENTS = {"int8": 5120, "uint8": 5121, "int16": 5122, "uint16": 5123, "uint32": 5125, "float32": 5126}
SHAPES = {1: "SCALAR", 3: "VEC3", 4: "VEC4", 16: "MAT4"}


class Gltf:
    """A glTF document that grows by one array, node or clip at a time, and becomes a GLB."""

    def __init__(self):
        self.json = {"asset": {"version": "2.0", "generator": "penumbra make_samples.py"}, "scene": 0}
        self.json.update({k: [] for k in ("nodes", "meshes", "skins", "animations", "accessors", "bufferViews")})
        self.bytes = b""

    def view(self, array):
        self.bytes += b"\0" * (-len(self.bytes) % 4)
        self.json["bufferViews"].append({"buffer": 0, "byteOffset": len(self.bytes), "byteLength": array.nbytes})
        self.bytes += array.tobytes()
        return len(self.json["bufferViews"]) - 1

    def accessor(self, array, normalized=False):
        array = np.ascontiguousarray(array)
        array = array[:, None] if array.ndim == 1 else array
        accessor = {"componentType": COMPONENTS[array.dtype.name], "type": SHAPES[array.shape[1]], "count": len(array)}
        row = array.dtype.itemsize * array.shape[1]
        if row % 4 == 0 or array.shape[1] == 1:
            accessor["bufferView"] = self.view(array)
        else:  # vertex attributes start at multiples of 4
            padded = np.zeros((len(array), row + -row % 4), np.uint8)
            padded[:, :row] = array.view(np.uint8)
            accessor["bufferView"] = self.view(padded)
            self.json["bufferViews"][-1]["byteStride"] = padded.shape[1]
        if array.shape[1] == 3:
            accessor.update({"min": array.min(0).tolist(), "max": array.max(0).tolist()})
        elif array.shape[1] == 1 and array.dtype == np.float32:
            accessor.update({"min": [float(array.min())], "max": [float(array.max())]})
        if normalized:
            accessor["normalized"] = True
        self.json["accessors"].append(accessor)
        return len(self.json["accessors"]) - 1

    def sparse_accessor(self, base, rows, values):
        """`base` (or None: zeros) with `values` at `rows`."""
        values = np.ascontiguousarray(values, np.float32)
        index = self.accessor(values if base is None else base)
        accessor = self.json["accessors"][index]
        if base is None:
            accessor.pop("bufferView")
            accessor["count"] = int(rows.max()) + 1
        indices, overrides = self.view(rows.astype(np.uint16)), self.view(values)
        accessor["sparse"] = {
            "count": len(rows),
            "indices": {"bufferView": indices, "componentType": COMPONENTS["uint16"]},
            "values": {"bufferView": overrides},
        }
        return index

    def node(self, name, parent=None, **fields):
        self.json["nodes"].append({"name": name, **fields})
        index = len(self.json["nodes"]) - 1
        if parent is not None:
            self.json["nodes"][parent].setdefault("children", []).append(index)
        return index

    def mesh(self, *primitives):
        self.json["meshes"].append({"primitives": list(primitives)})
        return len(self.json["meshes"]) - 1

    def skin(self, joints, inverse_bind=None):
        skin = {"joints": joints}
        if inverse_bind is not None:  # [J,4,4]; glTF stores columns
            skin["inverseBindMatrices"] = self.accessor(inverse_bind.transpose(0, 2, 1).reshape(-1, 16).astype(np.float32))
        self.json["skins"].append(skin)
        return len(self.json["skins"]) - 1

    def clip(self, name, *channels):
        """channels: (node, path, times, values[, interpolation])"""
        samplers, targets = [], []
        for node, path, times, values, *mode in channels:
            values = np.asarray(values)
            normalized = values.dtype != np.float32 and values.dtype != np.float64
            values = values if normalized else values.astype(np.float32)
            sampler = {"input": self.accessor(np.asarray(times, np.float32)), "output": self.accessor(values, normalized)}
            if mode:
                sampler["interpolation"] = mode[0]
            targets.append({"sampler": len(samplers), "target": {"node": node, "path": path}})
            samplers.append(sampler)
        self.json["animations"].append({"name": name, "samplers": samplers, "channels": targets})

    def save(self, path):
        children = {c for n in self.json["nodes"] for c in n.get("children", [])}
        self.json["scenes"] = [{"nodes": [n for n in range(len(self.json["nodes"])) if n not in children]}]
        self.bytes += b"\0" * (-len(self.bytes) % 4)
        self.json["buffers"] = [{"byteLength": len(self.bytes)}]
        text = json.dumps({k: v for k, v in self.json.items() if v != []}).encode()
        text += b" " * (-len(text) % 4)
        with open(path, "wb") as f:
            f.write(struct.pack("<4sII", b"glTF", 2, 28 + len(text) + len(self.bytes)))
            f.write(struct.pack("<I4s", len(text), b"JSON") + text)
            f.write(struct.pack("<I4s", len(self.bytes), b"BIN\0") + self.bytes)


def capsule(start, end, radius, around=12, along=9):
    """Closed surface of the points at `radius` from the segment; outward triangles. Also each vertex' place on the
    segment in metres from `start` (negative and beyond the end on the caps)."""
    start, end = np.asarray(start, float), np.asarray(end, float)
    length = np.linalg.norm(end - start)
    axis = (end - start) / length
    side = np.cross(axis, [0, 0, 1] if abs(axis[2]) < 0.9 else [1, 0, 0])
    side /= np.linalg.norm(side)
    other = np.cross(axis, side)
    caps = along // 3  # rings on either cap, the rest on the straight part
    cap = np.arange(1, caps + 1) / (caps + 0.5) * np.pi / 2
    rings = [(-radius * np.cos(a), radius * np.sin(a)) for a in cap]
    rings += [(t, radius) for t in np.linspace(0, length, along - 2 * caps + 2)[1:-1]]
    rings += [(length + radius * np.cos(a), radius * np.sin(a)) for a in cap[::-1]]
    angle = 2 * np.pi * np.arange(around) / around
    circle = np.cos(angle)[:, None] * side + np.sin(angle)[:, None] * other
    points, places = [start - radius * axis], [-radius]
    for place, r in rings:
        points += list(start + place * axis + r * circle)
        places += [place] * around
    points.append(end + radius * axis)
    places.append(length + radius)
    return np.array(points), closed_tube(len(rings), around), np.array(places)


def closed_tube(rings, around):
    """Pole, `rings` of `around` vertices, pole."""
    triangles = []
    for i in range(around):
        j = (i + 1) % around
        triangles.append((0, 1 + j, 1 + i))
        for r in range(rings - 1):
            a, b = 1 + r * around, 1 + (r + 1) * around
            triangles += [(a + i, a + j, b + j), (a + i, b + j, b + i)]
        last = 1 + (rings - 1) * around
        triangles.append((last + i, last + j, last + around))
    return np.array(triangles, np.uint16)


def tube(height, radius, rings, around):
    """A tube along +y from y = 0, closed by flat ends."""
    angle = 2 * np.pi * np.arange(around) / around
    circle = radius * np.stack([np.sin(angle), 0 * angle, np.cos(angle)], 1)
    heights = np.linspace(0, height, rings)
    points = np.concatenate([[[0, 0, 0]]] + [circle + [0, y, 0] for y in heights] + [[[0, height, 0]]])
    return points, closed_tube(rings, around)


def box(size):
    corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) * np.asarray(size) / 2
    faces = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    return corners, np.array([t for a, b, c, d in faces for t in ((a, b, c), (a, c, d))], np.uint16)


def turn(axis, degrees):
    """Quaternions x y z w about a coordinate axis, one for each angle."""
    half = np.radians(np.atleast_1d(np.asarray(degrees, float))) / 2
    q = np.zeros((len(half), 4))
    q[:, "xyz".index(axis)] = np.sin(half)
    q[:, 3] = np.cos(half)
    return q


def compose(a, b):
    """Quaternion products a b, row by row."""
    v = a[:, 3:] * b[:, :3] + b[:, 3:] * a[:, :3] + np.cross(a[:, :3], b[:, :3])
    return np.hstack([v, a[:, 3:] * b[:, 3:] - (a[:, :3] * b[:, :3]).sum(1, keepdims=True)])


def translation_to(points):
    """Inverse bind matrices of joints that stand at `points` without rotation."""
    m = np.tile(np.eye(4), (len(points), 1, 1))
    m[:, :3, 3] = -np.asarray(points, float)
    return m


def primitive(g, points, triangles, joints=None, weights=None, dtype=np.float32):
    attributes = {"POSITION": g.accessor(points.astype(np.float32))}
    for n in range(0 if joints is None else joints.shape[1] // 4):
        columns = slice(4 * n, 4 * n + 4)
        w = np.round(weights[:, columns] * np.iinfo(dtype).max) if dtype != np.float32 else weights[:, columns]
        attributes["JOINTS_%d" % n] = g.accessor(joints[:, columns].astype(np.uint8))
        attributes["WEIGHTS_%d" % n] = g.accessor(w.astype(dtype), dtype != np.float32)
    return {"attributes": attributes, "indices": g.accessor(np.asarray(triangles, np.uint16).reshape(-1))}


def two_bone_weights(points, bend_at=0.5, half_width=0.15):
    upper = np.clip((points[:, 1] - bend_at) / (2 * half_width) + 0.5, 0, 1)
    zero = np.zeros_like(upper)
    return np.tile([0, 1, 0, 0], (len(points), 1)), np.stack([1 - upper, upper, zero, zero], 1)


def arm(g, parent=None):
    """Nodes of two bones along +y, 0.5 m each."""
    lower = g.node("lower", parent)
    return lower, g.node("upper", lower, translation=[0, 0.5, 0])


ARM_BIND = translation_to([[0, 0, 0], [0, 0.5, 0]])


def swing(g, lower, upper):
    """One clip that bends and turns both bones."""
    t = np.linspace(0, 1, 6)
    wave = np.sin(2 * np.pi * t)
    g.clip("swing", (upper, "rotation", t, turn("z", 80 * wave)), (lower, "rotation", t, turn("y", 40 * wave)))


def arm_sample(rings=9, around=8, dtype=np.float32):
    g = Gltf()
    lower, upper = arm(g)
    points, triangles = tube(1.0, 0.1, rings, around)
    joints, weights = two_bone_weights(points)
    skin = g.skin([lower, upper], ARM_BIND)
    g.node("tube", mesh=g.mesh(primitive(g, points, triangles, joints, weights, dtype)), skin=skin)
    return g, lower, upper


def bend():
    g, lower, upper = arm_sample(rings=21, around=24)
    t = np.linspace(0, 2, 21)
    once, twice = np.sin(np.pi * t / 2) ** 2, np.sin(np.pi * t)
    g.clip("bend", (upper, "rotation", t, turn("z", 150 * once)))
    g.clip("twist", (upper, "rotation", t, compose(turn("y", 120 * twice), turn("x", 90 * once))))
    root = np.stack([0.3 * twice, 0 * t, 0.2 * once], 1)
    g.clip(
        "sway",
        (lower, "translation", t, root),
        (lower, "rotation", t, turn("x", 30 * twice)),
        (upper, "rotation", t, compose(turn("x", -100 * once), turn("z", 40 * twice))),
    )
    return g


# name: (parent, joint position, end of the capsule, radius); y up, facing +z, T pose, metres
BODY = {
    "hips": (None, (0, 0.96, 0), (0, 1.08, 0), 0.13),
    "spine": ("hips", (0, 1.10, 0), (0, 1.38, 0), 0.14),
    "head": ("spine", (0, 1.53, 0), (0, 1.70, 0.02), 0.10),
}
for side, x in (("L", 1), ("R", -1)):
    BODY["upper_arm." + side] = ("spine", (0.19 * x, 1.40, 0), (0.44 * x, 1.40, 0), 0.055)
    BODY["lower_arm." + side] = ("upper_arm." + side, (0.46 * x, 1.40, 0), (0.72 * x, 1.40, 0), 0.045)
    BODY["thigh." + side] = ("hips", (0.10 * x, 0.90, 0), (0.10 * x, 0.52, 0), 0.085)
    BODY["shin." + side] = ("thigh." + side, (0.10 * x, 0.50, 0), (0.10 * x, 0.10, 0), 0.065)
    BODY["foot." + side] = ("shin." + side, (0.10 * x, 0.06, 0), (0.10 * x, 0.05, 0.17), 0.05)


def capsule_man_mesh():
    """All capsules in one mesh. Around its joint a capsule follows its parent by half, fading over 1.5 radii."""
    names = list(BODY)
    points, triangles, joints, weights = [], [], [], []
    for j, (parent, start, end, radius) in enumerate(BODY.values()):
        p, t, place = capsule(start, end, radius)
        triangles.append(t + sum(map(len, points)))
        points.append(p)
        of_parent = 0.5 * np.clip(1 - place / (1.5 * radius), 0, 1) if parent else np.zeros(len(p))
        joints.append(np.tile([j, names.index(parent) if parent else 0, 0, 0], (len(p), 1)))
        weights.append(np.stack([1 - of_parent, of_parent, 0 * of_parent, 0 * of_parent], 1))
    return [np.concatenate(a) for a in (points, triangles, joints, weights)]


def capsule_man_clips(g, node):
    t = np.linspace(0, 3, 31)
    cycle = 2 * np.pi * t / 1.5
    once = np.sin(np.pi * t / 3) ** 2

    def channels(**angles):  # joint_LR: [(axis, degrees)], outermost rotation first
        out = []
        for joint, turns in angles.items():
            q = turn(turns[0][0], turns[0][1] + 0 * t)
            for axis, degrees in turns[1:]:
                q = compose(q, turn(axis, degrees + 0 * t))
            out.append((node[joint.replace("_L", ".L").replace("_R", ".R")], "rotation", t, q))
        return out

    def root(y, z=0):
        return node["hips"], "translation", t, np.stack([0 * t, 0.96 + y + 0 * t, z + 0 * t], 1)

    g.clip(
        "wave",
        *channels(
            upper_arm_R=[("z", 75 - 115 * once)], lower_arm_R=[("z", -60 * once + 25 * once * np.sin(2 * cycle))],
            upper_arm_L=[("z", -70), ("y", -35 * once)], lower_arm_L=[("y", -20 - 70 * once)],
            spine=[("z", 8 * np.sin(cycle) * once), ("y", 20 * once)], head=[("y", 25 * np.sin(cycle))],
        ),
        root(0 * t),
    )  # fmt: skip
    g.clip(
        "squat",
        *channels(
            thigh_L=[("x", -95 * once), ("z", 8)], thigh_R=[("x", -95 * once), ("z", -8)],
            shin_L=[("x", 115 * once)], shin_R=[("x", 115 * once)],
            foot_L=[("x", -20 * once)], foot_R=[("x", -20 * once)], spine=[("x", 35 * once)],
            upper_arm_L=[("y", -85 * once), ("z", -60 * (1 - once))], lower_arm_L=[("y", -60 * once)],
            upper_arm_R=[("y", 85 * once), ("z", 60 * (1 - once))], lower_arm_R=[("y", 60 * once)],
        ),
        root(-0.42 * once, -0.1 * once),
    )  # fmt: skip
    s = np.sin(cycle)
    g.clip(
        "walk",
        *channels(
            thigh_L=[("x", -28 * s)], thigh_R=[("x", 28 * s)],
            shin_L=[("x", 25 - 22 * np.cos(cycle))], shin_R=[("x", 25 + 22 * np.cos(cycle))],
            foot_L=[("x", 6 * s)], foot_R=[("x", -6 * s)], spine=[("y", 8 * s), ("x", 5)],
            upper_arm_L=[("x", 30 * s), ("z", -72)], upper_arm_R=[("x", -30 * s), ("z", 72)],
            lower_arm_L=[("y", -25 - 15 * s)], lower_arm_R=[("y", 25 - 15 * s)],
        ),
        root(-0.02 - 0.02 * np.cos(2 * cycle), 0.9 * t),
    )  # fmt: skip


def capsule_man():
    g = Gltf()
    node = {}
    for name, (parent, start, _, _) in BODY.items():
        origin = BODY[parent][1] if parent else (0, 0, 0)
        node[name] = g.node(name, node.get(parent), translation=np.round(np.subtract(start, origin), 6).tolist())
    skin = g.skin(list(node.values()), translation_to([b[1] for b in BODY.values()]))
    g.node("body", mesh=g.mesh(primitive(g, *capsule_man_mesh())), skin=skin)
    capsule_man_clips(g, node)
    return g


def influences8():
    """A chain of eight joints; every vertex follows the six nearest (JOINTS_1)."""
    g = Gltf()
    points, triangles = tube(1.0, 0.1, 15, 8)
    heights = np.arange(8) / 8
    chain = [g.node("joint0")]
    for j in range(1, 8):
        chain.append(g.node("joint%d" % j, chain[-1], translation=[0, 0.125, 0]))
    influence = np.exp(-(((points[:, 1:2] - heights - 0.06) / 0.2) ** 2))
    joints = np.argsort(-influence, 1)
    weights = np.take_along_axis(influence, joints, 1)
    weights[:, 6:] = 0
    weights /= weights.sum(1, keepdims=True)
    skin = g.skin(chain, translation_to([[0, h, 0] for h in heights]))
    g.node("tube", mesh=g.mesh(primitive(g, points, triangles, joints, weights)), skin=skin)
    t = np.linspace(0, 1, 5)
    g.clip("curl", *[(n, "rotation", t, turn("xz"[j % 2], 25 * t)) for j, n in enumerate(chain[1:])])
    return g


def sparse():
    """Positions that a sparse accessor bends out of a straight tube, and a track that is sparse over zeros."""
    g, lower, upper = arm_sample()
    points, _ = tube(1.0, 0.1, 9, 8)
    rows = np.flatnonzero(points[:, 1] > 0.6)
    moved = points[rows] + [0.05, 0, 0]
    g.json["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = g.sparse_accessor(points.astype(np.float32), rows, moved)
    t = np.linspace(0, 1, 5)
    g.clip("slide", (lower, "translation", t, np.zeros((5, 3))), (upper, "rotation", t, turn("z", 60 * t)))
    values = g.sparse_accessor(None, np.array([1, 4]), [[0.1, 0, 0], [0, 0, 0.2]])
    g.json["animations"][0]["samplers"][0]["output"] = values
    return g


def quantized():
    """KHR_mesh_quantization: 16-bit positions whose scale and offset are in the inverse bind matrices."""
    g = Gltf()
    lower, upper = arm(g)
    points, triangles = tube(1.0, 0.1, 9, 8)
    joints, weights = two_bone_weights(points)
    scale, offset = 0.5, np.array([0, 0.5, 0])
    stored = np.round((points - offset) / scale * 32767).astype(np.int16)
    p = primitive(g, points, triangles, joints, weights, np.uint8)
    p["attributes"]["POSITION"] = g.accessor(stored, normalized=True)
    dequantise = np.diag([scale, scale, scale, 1.0])
    dequantise[:3, 3] = offset
    g.node("tube", mesh=g.mesh(p), skin=g.skin([lower, upper], ARM_BIND @ dequantise))
    bare = primitive(g, *box([1, 1, 1]))
    bare["attributes"]["POSITION"] = g.accessor(np.round(box([200, 60, 100])[0]).astype(np.int8))
    g.node("knob", upper, mesh=g.mesh(bare), translation=[0, 0.55, 0], scale=[0.002, 0.002, 0.002])
    g.json["extensionsUsed"] = g.json["extensionsRequired"] = ["KHR_mesh_quantization"]
    swing(g, lower, upper)
    return g


def weights_u16():
    g, lower, upper = arm_sample(dtype=np.uint16)
    swing(g, lower, upper)
    return g


def interpolation():
    """STEP and CUBICSPLINE tracks of all three properties, and rotations stored as normalised shorts."""
    g, lower, upper = arm_sample()
    t = np.array([0.25, 0.5, 1.0, 1.5])
    angles = turn("z", [0, 40, -30, 60])
    move = np.array([[0, 0, 0], [0.1, 0, 0], [0.1, 0.2, 0], [0, 0, 0.1]])
    size = np.array([[1, 1, 1], [1.2, 1, 0.8], [0.9, 1.1, 1], [1, 1, 1]])
    g.clip(
        "step", (upper, "rotation", t, angles, "STEP"), (lower, "translation", t, move, "STEP"), (lower, "scale", t, size, "STEP")
    )

    def spline(values, slope):
        keys = np.stack([slope * np.roll(values, 1, 0), values, slope * np.roll(values, -1, 0)], 1)
        return keys.reshape(-1, values.shape[1])

    g.clip(
        "cubic",
        (upper, "rotation", t, spline(angles, 0.7), "CUBICSPLINE"),
        (lower, "translation", t, spline(move, -0.9), "CUBICSPLINE"),
        (lower, "scale", t, spline(size, 0.2), "CUBICSPLINE"),
    )
    g.clip("shorts", (upper, "rotation", t, np.round(angles * 32767).astype(np.int16)), (lower, "scale", t, size))
    return g


def props():
    """Rigid things: under a bone, mirrored under a still node, moving by itself under a bone and in the scene, still."""
    g, lower, upper = arm_sample()
    blade = lambda size: g.mesh(primitive(g, *box(size)))
    g.node("sword", upper, mesh=blade([0.05, 0.6, 0.02]), translation=[0.1, 0.5, 0], rotation=turn("z", 60)[0].tolist(), scale=[1, 1.5, 0.5])
    strap = g.node("strap", lower, translation=[0, 0.2, 0.12], rotation=turn("y", 30)[0].tolist())
    g.node("shield", strap, mesh=blade([0.3, 0.4, 0.04]), scale=[-1, 1, 1])
    flag = g.node("flag", upper, mesh=blade([0.2, 0.1, 0.01]), translation=[-0.1, 0.3, 0])
    g.node("tassel", flag, mesh=blade([0.02, 0.1, 0.02]), translation=[-0.1, -0.1, 0])
    bird = g.node("bird", translation=[0.6, 1, 0])
    g.node("body", bird, mesh=blade([0.1, 0.1, 0.2]))
    g.node("ground", mesh=blade([2, 0.02, 2]), translation=[0, -0.05, 0])
    swing(g, lower, upper)
    t = np.linspace(0, 1, 5)
    g.clip(
        "fly",
        (flag, "rotation", t, turn("y", 90 * t)),
        (bird, "translation", t, np.stack([0.6 - t, 1 + 0 * t, 0.3 * t], 1)),
        (upper, "rotation", t, turn("x", 45 * t)),
    )
    return g


def two_skins():
    """Three skinned meshes: two share a skin, the third has its own space (its bind pose is moved and scaled)."""
    g, lower, upper = arm_sample()
    points, triangles = tube(1.0, 0.1, 9, 8)
    joints, weights = two_bone_weights(points)
    sleeve = primitive(g, points * [1.2, 0.4, 1.2] + [0, 0.3, 0], triangles, joints, weights)
    g.node("sleeve", mesh=g.mesh(sleeve), skin=0)
    space = np.diag([0.01, 0.01, 0.01, 1])  # centimetres to metres
    space[:3, 3] = [0.4, 0, 0]
    twin = primitive(g, points * 100, triangles, joints, weights)
    g.node("twin", mesh=g.mesh(twin), skin=g.skin([upper, lower], (ARM_BIND @ space)[::-1]))
    swing(g, lower, upper)
    return g


def matrix_nodes():
    """Nodes with matrices above the skeleton and in it, a mirrored mesh, strips and fans, and no indices."""
    g = Gltf()
    root = np.array([[0.01, 0, 0, 0.3], [0, 0, 0.01, 0], [0, -0.01, 0, 0.1], [0, 0, 0, 1]])  # z up, centimetres
    armature = g.node("armature", matrix=root.T.reshape(-1).tolist())
    lower = g.node("lower", armature, translation=[0, 0, 0])
    middle = np.eye(4)
    middle[:3, 3] = [0, 50, 0]
    holder = g.node("holder", lower, matrix=middle.T.reshape(-1).tolist())
    upper = g.node("upper", holder, scale=[1, 1, 1.25])
    points, triangles = tube(100.0, 10.0, 9, 8)
    joints, weights = two_bone_weights(points / 100)
    g.node("tube", mesh=g.mesh(primitive(g, points, triangles, joints, weights)), skin=g.skin([lower, upper], translation_to([[0, 0, 0], [0, 50, 0]])))
    strip = {"attributes": {"POSITION": g.accessor(np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]], np.float32) * 30)}, "mode": 5}
    fan = {"attributes": {"POSITION": g.accessor(np.array([[0, 0, 1], [1, 0, 1], [1.2, 0.6, 1], [0, 1, 1]], np.float32) * 30)}, "mode": 6}
    points_only = {"attributes": strip["attributes"], "mode": 0}
    g.node("panes", holder, mesh=g.mesh(strip, fan, points_only), scale=[1, -1, 1])
    t = np.linspace(0, 1, 6)
    g.clip("swing", (upper, "rotation", t, turn("z", 70 * t)), (lower, "translation", t, np.outer(t, [0, 30, 20])))
    return g


SAMPLES = [bend, capsule_man, influences8, sparse, quantized, weights_u16, interpolation, props, two_skins, matrix_nodes]


def main():
    if len(sys.argv) != 2:
        sys.exit("usage: make_samples.py FOLDER")
    os.makedirs(sys.argv[1], exist_ok=True)
    for sample in SAMPLES:
        path = os.path.join(sys.argv[1], sample.__name__ + ".glb")
        sample().save(path + ".part")
        os.replace(path + ".part", path)


main()
