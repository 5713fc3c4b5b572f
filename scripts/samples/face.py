"""A bust whose face has morph targets: a head on a neck, two bones, and weights that clips drive."""
import numpy as np

from samples.gltf import Gltf, primitive
from samples.shapes import compose, translation_to, turn

AROUND, RINGS = 48, 52
NECK = np.array([0, 0.22, -0.01])  # where the head turns
TARGETS = ["jaw", "smile", "pout", "blink.L", "blink.R", "frown"]


def bump(angle, height, at_angle, at_height, wide, tall):
    return np.exp(-(((angle - at_angle) / wide) ** 2) - ((height - at_height) / tall) ** 2)


def surface(weights):
    """Returns points [V,3] of the bust with these weights. A face is a tube around y whose radius has bumps."""
    w = dict(zip(TARGETS, weights))
    knots = [(0, 0), (0, 0.20), (0.04, 0.19), (0.12, 0.14), (0.17, 0.075), (0.24, 0.065), (0.28, 0.085), (0.34, 0.105)]
    knots += [(0.42, 0.115), (0.49, 0.10), (0.54, 0.06), (0.56, 0)]
    length = np.concatenate([[0], np.cumsum(np.hypot(*np.diff(np.array(knots), axis=0).T))])
    s = np.linspace(0, length[-1], RINGS)
    y, r = np.interp(s, length, [k[0] for k in knots]), np.interp(s, length, [k[1] for k in knots])
    for _ in range(2):
        y[1:-1], r[1:-1] = [0.25 * v[:-2] + 0.5 * v[1:-1] + 0.25 * v[2:] for v in (y, r)]
    a = np.linspace(-np.pi, np.pi, AROUND, endpoint=False)
    y, angle, r = np.repeat(y, AROUND), np.tile(a, RINGS), np.repeat(r, AROUND)
    # Nose, eye sockets and the closed mouth; then what the targets change. The mouth opens as a hollow.
    at = lambda *of: bump(angle, y, *of)
    out = 0.030 * at(0, 0.38, 0.16, 0.035)
    for side, blink in ((1, w["blink.L"]), (-1, w["blink.R"])):
        out += (-0.026 + 0.022 * blink) * at(0.42 * side, 0.42, 0.20, 0.022)
        out += 0.012 * (1 + w["frown"]) * at(0.40 * side, 0.452 - 0.01 * w["frown"], 0.30, 0.012)
        out += w["smile"] * 0.016 * at(0.55 * side, 0.355, 0.20, 0.025)
    wide = 0.30 * (1 + 0.45 * w["smile"] - 0.40 * w["pout"])
    out += (0.010 + 0.022 * w["pout"]) * at(0, 0.345, wide, 0.012)
    out += (0.010 + 0.022 * w["pout"]) * at(0, 0.318 - 0.02 * w["jaw"], wide, 0.012)
    out += (-0.006 - 0.060 * w["jaw"]) * at(0, 0.332 - 0.01 * w["jaw"], wide, 0.010 + 0.014 * w["jaw"])
    radius = r + np.where(r > 0.03, out, 0)
    points = np.stack([radius * np.sin(angle), y, 0.85 * radius * np.cos(angle)], 1)
    # The jaw also takes the chin down and back.
    chin = np.clip((0.335 - y) / 0.03, 0, 1) * np.clip((y - 0.24) / 0.03, 0, 1) * np.clip(np.cos(angle), 0, 1)
    points[:, 1] -= 0.035 * w["jaw"] * chin
    points[:, 2] -= 0.015 * w["jaw"] * chin
    return points


def triangles():
    out = []
    for ring in range(RINGS - 1):
        for i in range(AROUND):
            j = (i + 1) % AROUND
            a, b, c, d = ring * AROUND + i, ring * AROUND + j, (ring + 1) * AROUND + i, (ring + 1) * AROUND + j
            out += [[a, b, c], [b, d, c]]
    return np.array(out)


def speech(t, seed):
    """Returns weights [T,6] of a face that talks, by sums of sines."""
    state = np.random.RandomState(seed)
    waves = sum(
        np.sin(2 * np.pi * np.outer(t, state.uniform(0.3, 1.6, len(TARGETS))) + state.uniform(0, 6.3, len(TARGETS)))
        for _ in range(2)
    )
    return np.clip(0.45 + 0.4 * waves, 0, 1)


def face(morphs=True):
    """Makes the bust, or the same one without its targets and their weights."""
    g = Gltf()
    rest = surface(np.zeros(len(TARGETS)))
    head = np.clip((rest[:, 1] - 0.19) / 0.07, 0, 1)
    joints = np.tile([0, 1, 0, 0], (len(rest), 1))
    weights = np.stack([1 - head, head, 0 * head, 0 * head], 1)
    part = primitive(g, rest, triangles(), joints, weights)
    moves = [(surface(np.eye(len(TARGETS))[i]) - rest).astype(np.float32) for i in range(len(TARGETS))]
    if morphs:
        part["targets"] = [{"POSITION": g.accessor(move)} for move in moves]
    mesh = g.mesh(part)
    if morphs:
        g.json["meshes"][mesh]["extras"] = {"targetNames": TARGETS}
    chest = g.node("chest")
    top = g.node("head", chest, translation=NECK.tolist())
    skin = g.skin([chest, top], translation_to([[0, 0, 0], NECK]))
    bust = g.node("bust", mesh=mesh, skin=skin)
    t = np.linspace(0, 4, 41)
    for number, name in enumerate(["chat", "speech", "song", "quarrel"]):
        phase = 0.7 * number
        nod = compose(turn("x", 18 * np.sin(1.3 * t + phase)), turn("y", 35 * np.sin(0.8 * t + 2 * phase)))
        channels = [(top, "rotation", t, nod)]
        if morphs:
            channels.append((bust, "weights", t, speech(t, number).reshape(-1)))
        g.clip(name, *channels)
    return g
