#!/usr/bin/python3
"""Measures the steps that a dense asset shows between vertices where a bake of all vertices is smooth.

  scripts/figures/measure_seams.py LIBRARY X.pnb FULL.vis.h5 [--smooth .01]

LIBRARY is libpenumbra.so. FULL.vis.h5 is a bake of all vertices that the asset draws. For each frame of the bake, E is
the cosine-weighted visibility / pi of every vertex, by the asset and by the bake. An edge is smooth where E of the bake
changes along it by less than --smooth. Prints how E of the asset changes along smooth edges: the root mean square, the
99.9th percentile and the largest step, beside those of the bake itself over the same edges, and the rms error of E.
Frames are matched by their bones. Needs numpy and h5py."""
import ctypes
import pathlib
import sys

import h5py
import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent))
from usage import ArgumentParser

parser = ArgumentParser(__doc__)
for name in ("library", "asset", "bake"):
    parser.add_argument(name)
parser.add_argument("--smooth", type=float, default=0.01)
arguments = parser.parse_args()
lib = ctypes.CDLL(arguments.library)
lib.penumbra_character_out_of_range.restype = ctypes.c_double
SIZE, POINTER = ctypes.c_size_t, ctypes.c_void_p


class Vertices(ctypes.Structure):
    _fields_ = [(name, POINTER) for name in ("positions", "normals", "tangents", "coefficients", "bounced")] + [
        ("first", SIZE), ("count", SIZE)]


class Followers(ctypes.Structure):
    _fields_ = [("first", SIZE), ("count", SIZE), ("corners", POINTER), ("weights", POINTER)]


class Cluster(ctypes.Structure):
    _fields_ = [("joint", SIZE), ("first_vertex", SIZE), ("vertex_count", SIZE), ("rest", ctypes.c_byte * 256)]


def must(status):
    assert status == 0, f"status {status}"


handle = ctypes.c_void_p()
must(lib.penumbra_asset_open_file(arguments.asset.encode(), ctypes.byref(handle), None))
character = ctypes.c_void_p()
must(lib.penumbra_character_create(handle, ctypes.byref(character), None))
followers = Followers()
must(lib.penumbra_asset_get_followers(handle, ctypes.byref(followers)))
count = followers.first + followers.count
clusters, cluster = 0, Cluster()
while lib.penumbra_asset_get_cluster(handle, SIZE(clusters), ctypes.byref(cluster)) == 0:
    clusters += 1
arrays = {name: np.zeros((count, width), np.float32)
          for name, width in (("positions", 3), ("normals", 3), ("tangents", 3), ("coefficients", 64))}
ambient = np.zeros(count, np.float32)
vertices = Vertices(*(arrays[name].ctypes.data for name in arrays), None, 0, count)
with h5py.File(arguments.bake) as bake:
    rest, triangles = bake["mesh/rest_positions"][:], bake["mesh/triangles"][:]
    bones, normals = bake["frames/bones"][:], bake["frames/normals"]
    moments = bake["visibility/coefficients"]
    order = int(round(moments.shape[2]**0.5))
    assert len(rest) == count, f"the bake has {len(rest)} vertices, the asset draws {count}"
    # Rest positions tell which vertex is which; those of hard edges are told apart by nothing and left out.
    place = {}
    must(lib.penumbra_character_set_pose(character, 0, np.ascontiguousarray(
        np.tile(np.eye(4, dtype=np.float32)[:3], (bones.shape[1], 1, 1))).ctypes.data_as(POINTER),
        SIZE(bones.shape[1]), None, SIZE(0), None))
    must(lib.penumbra_character_skin(character, ctypes.byref(vertices), None))
    for v, p in enumerate(arrays["positions"].round(6).tolist()):
        place.setdefault(tuple(p), []).append(v)
    of_bake = np.array([place.get(tuple(p), [-1])[0] if len(place.get(tuple(p), [])) == 1 else -1
                        for p in rest.round(6).tolist()])
    edges = np.unique(np.sort(np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]), axis=1),
                      axis=0)
    edges = edges[(of_bake[edges] >= 0).all(1)]
    steps, true_steps, errors = [], [], []
    for f in range(len(bones)):
        matrices = np.ascontiguousarray(bones[f], np.float32)
        must(lib.penumbra_character_set_pose(character, 0, matrices.ctypes.data_as(POINTER), SIZE(len(matrices)), None,
                                             SIZE(0), None))
        must(lib.penumbra_character_evaluate(character, SIZE(0), SIZE(clusters), ctypes.byref(vertices), None))
        must(lib.penumbra_character_skin(character, ctypes.byref(vertices), None))
        must(lib.penumbra_character_follow(character, ctypes.byref(vertices), None))
        must(lib.penumbra_character_ambient(character, ctypes.byref(vertices), ambient.ctypes.data_as(POINTER), None))
        # E = (1/pi) sum over bands of the cosine lobe's factors times the moments of the hemisphere.
        n, m = normals[f], moments[f].astype(np.float64)
        x, y, z = n.T.astype(np.float64)
        basis = [np.full(len(n), 0.28209479), -0.48860251 * y, 0.48860251 * z, -0.48860251 * x, 1.09254843 * x * y,
                 -1.09254843 * y * z, 0.31539157 * (3 * z * z - 1), -1.09254843 * x * z, 0.54627422 * (x * x - y * y)]
        # max(n.s, 0) has no band 3 and little of band 4, which is left out here and below.
        factors = [np.pi, 2 * np.pi / 3, np.pi / 4]
        true = sum(factors[int(i**0.5)] * basis[i] * m[:, i] for i in range(min(9, order * order))) / np.pi
        own = ambient[of_bake]
        smooth = np.abs(true[edges[:, 0]] - true[edges[:, 1]])
        kept = smooth < arguments.smooth
        steps.append(np.abs(own[edges[:, 0]] - own[edges[:, 1]])[kept])
        true_steps.append(smooth[kept])
        errors.append((own - true)[of_bake >= 0])
steps, true_steps, errors = (np.concatenate(rows) for rows in (steps, true_steps, errors))
for name, rows in (("asset", steps), ("bake", true_steps)):
    print(f"{name}: rms {np.sqrt((rows**2).mean()):.5f}, 99.9% below {np.percentile(rows, 99.9):.4f}, "
          f"largest {rows.max():.4f}")
print(f"{len(steps)} smooth edges of {len(edges)} x {len(bones)}; E is off by {np.sqrt((errors**2).mean()):.4f} rms")
