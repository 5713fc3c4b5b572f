"""A small humanoid of capsules whose arms, legs and trunk shade one another."""
import numpy as np

from samples.gltf import Gltf, primitive
from samples.shapes import capsule, compose, translation_to, turn

# Each entry is name: (parent, joint position, end of the capsule, radius); y up, facing +z, T pose, metres.
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


def capsule_man_mesh(around, along):
    """Joins all capsules in one mesh, of `along` rings of `around` vertices each. Around its joint a capsule follows
    its parent by half, fading over 1.5 radii."""
    names = list(BODY)
    points, triangles, joints, weights = [], [], [], []
    for j, (parent, start, end, radius) in enumerate(BODY.values()):
        p, t, place = capsule(start, end, radius, around, along)
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


def capsule_man(around=12, along=9):
    g = Gltf()
    node = {}
    for name, (parent, start, _, _) in BODY.items():
        origin = BODY[parent][1] if parent else (0, 0, 0)
        node[name] = g.node(name, node.get(parent), translation=np.round(np.subtract(start, origin), 6).tolist())
    skin = g.skin(list(node.values()), translation_to([b[1] for b in BODY.values()]))
    g.node("body", mesh=g.mesh(primitive(g, *capsule_man_mesh(around, along))), skin=skin)
    capsule_man_clips(g, node)
    return g
