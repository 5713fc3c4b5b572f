"""Cases for the tests of exports in other programs: the files that they read, and what they should have read."""
import os
import sys

import numpy as np
from gltf_reference import Glb
from programs import must

BIN = sys.argv[1]
CASES = [("capsule_man", "static"), ("capsule_man", "play"), ("face", "static"), ("face", "play")]


def export_cases(folder):
    """Exports two characters as both kinds. Returns the paths of the .glb files, those of CASES."""
    paths = []
    for rig, kind in CASES:
        glb, vis = os.path.join(BIN, "..", "samples", rig + ".glb"), os.path.join(folder, rig + ".vis.h5")
        if not os.path.exists(vis):
            must(os.path.join(BIN, "penumbra-bake"), "visibility", glb, "-o", vis, "--rays", "32", "--fps", "2")
        paths.append(os.path.join(folder, rig + "." + kind + ".glb"))
        more = ["--components", "3"] if kind == "play" else []
        must(os.path.join(BIN, "penumbra-pack"), "export", vis, glb, "-o", paths[-1], "--as", kind, *more)
    return paths


def vertices_of(path):
    """Positions [V,3] and colours [V,3] of the first primitive, and how many morph targets it has."""
    glb = Glb(path)
    primitive = glb.json["meshes"][0]["primitives"][0]
    position, color = (glb.accessor(primitive["attributes"][name]) for name in ("POSITION", "COLOR_0"))
    return position, color[:, :3], len(primitive.get("targets", []))


def worst_of_nearest(a, b, near):
    """How far the colours of vertices are from those of another list: for each vertex of a that of b, among those at
    its place, whose colour is most like it. a and b are pairs of positions and colours."""
    worst = 0.0
    for place, color in zip(*a):
        there = np.abs(b[0] - place).max(1) < near
        assert there.any(), ("nothing is at", place)
        worst = max(worst, float(np.abs(b[1][there] - color).max(1).min()))
    assert len(a[0]) > 0
    return worst
