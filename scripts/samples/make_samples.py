"""Writes the synthetic rigs of data-samples/README.md: make_samples.py FOLDER. Needs numpy; same bytes every time."""
import os
import pathlib
import sys

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent))
from samples.bat import bat
from samples.capsule_man import capsule_man
from samples.face import face
from samples.flapping_sheet import write_sheets
from samples.gltf import Gltf, primitive
from samples.shapes import box, compose, rotation, translation_to, tube, turn, two_bone_weights
from samples.text_formats import Bones, write_dae, write_fbx, write_x


def arm(g, parent=None):
    """Makes nodes of two bones along +y, 0.5 m each."""
    lower = g.node("lower", parent)
    return lower, g.node("upper", lower, translation=[0, 0.5, 0])


ARM_BIND = translation_to([[0, 0, 0], [0, 0.5, 0]])


def swing(g, lower, upper):
    """Makes one clip that bends and turns both bones."""
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


def influences8():
    """Makes a chain of eight joints. Every vertex follows the six nearest (JOINTS_1)."""
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
    """Makes positions that a sparse accessor bends out of a straight tube, and a track that is sparse over zeros."""
    g, lower, upper = arm_sample()
    points, _ = tube(1.0, 0.1, 9, 8)
    rows = np.flatnonzero(points[:, 1] > 0.6)
    moved = points[rows] + [0.05, 0, 0]
    attributes = g.json["meshes"][0]["primitives"][0]["attributes"]
    attributes["POSITION"] = g.sparse_accessor(points.astype(np.float32), rows, moved)
    t = np.linspace(0, 1, 5)
    g.clip("slide", (lower, "translation", t, np.zeros((5, 3))), (upper, "rotation", t, turn("z", 60 * t)))
    values = g.sparse_accessor(None, np.array([1, 4]), [[0.1, 0, 0], [0, 0, 0.2]])
    g.json["animations"][0]["samplers"][0]["output"] = values
    return g


def quantized():
    """Uses KHR_mesh_quantization: 16-bit positions whose scale and offset are in the inverse bind matrices."""
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
    """Makes STEP and CUBICSPLINE tracks of all three properties, and rotations stored as normalised shorts."""
    g, lower, upper = arm_sample()
    t = np.array([0.25, 0.5, 1.0, 1.5])
    angles = turn("z", [0, 40, -30, 60])
    move = np.array([[0, 0, 0], [0.1, 0, 0], [0.1, 0.2, 0], [0, 0, 0.1]])
    size = np.array([[1, 1, 1], [1.2, 1, 0.8], [0.9, 1.1, 1], [1, 1, 1]])
    g.clip(
        "step",
        (upper, "rotation", t, angles, "STEP"),
        (lower, "translation", t, move, "STEP"),
        (lower, "scale", t, size, "STEP"),
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
    """Makes rigid things: under a bone, mirrored under a still node, and moving by themselves under a bone and in the
    scene."""
    g, lower, upper = arm_sample()
    blade = lambda size: g.mesh(primitive(g, *box(size)))
    slant = turn("z", 60)[0].tolist()
    sword = blade([0.05, 0.6, 0.02])
    g.node("sword", upper, mesh=sword, translation=[0.1, 0.5, 0], rotation=slant, scale=[1, 1.5, 0.5])
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
    """Makes three skinned meshes: two share a skin, and the third has its own space (its bind pose is moved and
    scaled)."""
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
    """Makes nodes with matrices above the skeleton and in it, a mirrored mesh, strips and fans, and no indices."""
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
    skin = g.skin([lower, upper], translation_to([[0, 0, 0], [0, 50, 0]]))
    g.node("tube", mesh=g.mesh(primitive(g, points, triangles, joints, weights)), skin=skin)
    bare = lambda corners, mode: {"attributes": {"POSITION": g.accessor(np.float32(corners) * 30)}, "mode": mode}
    strip = bare([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]], 5)
    fan = bare([[0, 0, 1], [1, 0, 1], [1.2, 0.6, 1], [0, 1, 1]], 6)
    points_only = {"attributes": strip["attributes"], "mode": 0}
    g.node("panes", holder, mesh=g.mesh(strip, fan, points_only), scale=[1, -1, 1])
    t = np.linspace(0, 1, 6)
    g.clip("swing", (upper, "rotation", t, turn("z", 70 * t)), (lower, "translation", t, np.outer(t, [0, 30, 20])))
    return g


def still_face():
    """Makes the face without its morph targets: what the error of faces is compared with."""
    return face(morphs=False)


def swing_in_other_formats(folder):
    """Makes weights_u16's tube and clip without the rounding of weights: swing.glb, .x, .dae and .fbx."""
    g, lower, upper = arm_sample()
    swing(g, lower, upper)
    g.save(os.path.join(folder, "swing.glb"))
    points, triangles = tube(1.0, 0.1, 9, 8)
    _, weights = two_bone_weights(points)
    times = np.linspace(0, 1, 6).astype(np.float32)
    wave = np.sin(2 * np.pi * np.linspace(0, 1, 6))
    raised = np.eye(4)
    raised[1, 3] = 0.5
    local = [[rotation("y", 40 * w) for w in wave], [raised @ rotation("z", 80 * w) for w in wave]]
    bones = Bones(points, triangles, weights[:, :2], ["lower", "upper"], [-1, 0], times, local, [np.eye(4), raised])
    write_x(bones, os.path.join(folder, "swing.x"))
    write_dae(bones, os.path.join(folder, "swing.dae"))
    write_fbx(bones, os.path.join(folder, "swing.fbx"))
    write_fbx(bones, os.path.join(folder, "swing_pivot.fbx"), pivot=[3, -2, 10])


SAMPLES = [bend, capsule_man, influences8, sparse, quantized, weights_u16, interpolation, props, two_skins]
SAMPLES += [matrix_nodes, face, still_face]


def main():
    if len(sys.argv) != 2:
        sys.exit("usage: make_samples.py FOLDER")
    os.makedirs(sys.argv[1], exist_ok=True)
    for sample in SAMPLES:
        path = os.path.join(sys.argv[1], sample.__name__ + ".glb")
        sample().save(path + ".part")
        os.replace(path + ".part", path)
    swing_in_other_formats(sys.argv[1])
    write_x(bat(), os.path.join(sys.argv[1], "bat.x"), "flap")
    write_sheets(sys.argv[1])


main()
