#!/usr/bin/python3
"""Splits the large triangles of a .glb, so that light changes within them: a bake knows light at vertices alone.

split_triangles.py IN.glb OUT.glb [--share 0.03]

Every edge that is longer than this share of the character's diagonal at rest gets a vertex in its middle, again and
again. Two triangles that meet at an edge get the same one, so nothing tears. Texture coordinates, normals, weights and
morph targets are those between the ends; pictures, clips and all else stay as they are. Bake, fit and pack OUT.glb, and
give it to --materials-of.
"""
import json
import pathlib
import struct
import sys

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent))
from samples.gltf import Gltf
from usage import ArgumentParser

TYPES = {5120: np.int8, 5121: np.uint8, 5122: np.int16, 5123: np.uint16, 5125: np.uint32, 5126: np.float32}
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}
MAX_PASSES, MAX_INFLUENCES = 8, 8


def read_glb(path):
    data = path.read_bytes()
    if data[:4] != b"glTF" or len(data) < 20:
        sys.exit(f"split_triangles: {path}: not a .glb")
    if struct.unpack("<I", data[8:12])[0] != len(data):
        sys.exit(f"split_triangles: {path}: cut short, or with something behind its end")
    size = struct.unpack("<I", data[12:16])[0]
    g = Gltf()
    g.json = json.loads(data[20:20 + size])
    g.bytes = data[28 + size:]
    for name in g.json.get("extensionsRequired", []):
        if "compression" in name or "quantization" in name:
            sys.exit(f"split_triangles: {path}: needs {name}, which is not read")
    return g


def read_accessor(g, index):
    """[count, width], as stored; whole numbers that stand for fractions become these."""
    accessor = g.json["accessors"][index]
    if "sparse" in accessor or "bufferView" not in accessor:
        sys.exit(f"split_triangles: accessor {index} is sparse, which is not read")
    view = g.json["bufferViews"][accessor["bufferView"]]
    kind, width = np.dtype(TYPES[accessor["componentType"]]), WIDTHS[accessor["type"]]
    start = view.get("byteOffset", 0) + accessor.get("byteOffset", 0)
    stride = view.get("byteStride", kind.itemsize * width)
    rows = np.ndarray((accessor["count"], width), kind, g.bytes, start, (stride, kind.itemsize))
    return rows / np.iinfo(kind).max if accessor.get("normalized") else rows.copy()


def node_matrices(g):
    """[nodes, 4, 4] from each node to the scene, at rest."""
    nodes = g.json["nodes"]
    out, parent = [None] * len(nodes), {c: n for n, node in enumerate(nodes) for c in node.get("children", [])}

    def local(node):
        if "matrix" in node:
            return np.array(node["matrix"], float).reshape(4, 4).T
        x, y, z, w = node.get("rotation", [0, 0, 0, 1])
        m = np.eye(4)
        m[:3, :3] = np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                              [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                              [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]])
        m[:3, :3] *= node.get("scale", [1, 1, 1])
        m[:3, 3] = node.get("translation", [0, 0, 0])
        return m

    def world(n):
        if out[n] is None:
            out[n] = world(parent[n]) @ local(nodes[n]) if n in parent else local(nodes[n])
        return out[n]

    return [world(n) for n in range(len(nodes))]


class Part:
    """A primitive: its triangles, its attributes a vertex, and where its vertices are at rest."""

    def __init__(self, g, primitive, node, matrices):
        self.primitive = primitive
        self.values = {name: read_accessor(g, a).astype(float) for name, a in primitive["attributes"].items()}
        for t, target in enumerate(primitive.get("targets", [])):
            self.values.update({(t, name): read_accessor(g, a).astype(float) for name, a in target.items()})
        count = len(self.values["POSITION"])
        self.triangles = (read_accessor(g, primitive["indices"]).ravel() if "indices" in primitive
                          else np.arange(count)).reshape(-1, 3).astype(int)
        self.joints, self.weights = (np.concatenate([self.values.pop(n) for n in sorted(
            (n for n in self.values if isinstance(n, str) and n.startswith(kind)))] or [np.zeros((count, 0))], 1)
            for kind in ("JOINTS_", "WEIGHTS_"))
        self.weights /= np.maximum(self.weights.sum(1, keepdims=True), 1e-9)
        places = np.concatenate([self.values["POSITION"], np.ones((count, 1))], 1)
        if "skin" in node and self.joints.shape[1]:
            skin = g.json["skins"][node["skin"]]
            bind = (read_accessor(g, skin["inverseBindMatrices"]).reshape(-1, 4, 4).transpose(0, 2, 1)
                    if "inverseBindMatrices" in skin else [np.eye(4)] * len(skin["joints"]))
            bones = np.array([matrices[j] @ b for j, b in zip(skin["joints"], bind, strict=True)])
            blend = np.einsum("vk,vkij->vij", self.weights, bones[self.joints.astype(int)])
            self.rest = np.einsum("vij,vj->vi", blend, places)[:, :3]
        else:
            self.rest = (places @ matrices[node["number"]].T)[:, :3]

    def mean_influences(self, a, b):
        """The joints and weights between vertices a and b, the largest first."""
        joints = np.concatenate([self.joints[a], self.joints[b]], 1)
        weights = np.concatenate([self.weights[a], self.weights[b]], 1) / 2
        for k in range(joints.shape[1]):  # equal joints become one
            for earlier in range(k):
                same = (joints[:, k] == joints[:, earlier]) & (weights[:, k] > 0)
                weights[same, earlier] += weights[same, k]
                weights[same, k] = 0
        first = np.lexsort((joints, -weights), axis=1)[:, :MAX_INFLUENCES]
        joints, weights = np.take_along_axis(joints, first, 1), np.take_along_axis(weights, first, 1)
        return np.where(weights > 0, joints, 0), weights / np.maximum(weights.sum(1, keepdims=True), 1e-9)

    def add_middles(self, edges):
        a, b = edges.T
        for name, values in self.values.items():
            self.values[name] = np.concatenate([values, (values[a] + values[b]) / 2])
        self.rest = np.concatenate([self.rest, (self.rest[a] + self.rest[b]) / 2])
        if self.joints.shape[1] == 0:
            self.joints, self.weights = (np.zeros((len(self.rest), 0)) for _ in range(2))
            return
        rows = self.mean_influences(a, b)
        width = max(self.joints.shape[1], rows[0].shape[1])
        self.joints, self.weights = (
            np.concatenate([np.pad(old, ((0, 0), (0, width - old.shape[1]))),
                            np.pad(new, ((0, 0), (0, width - new.shape[1])))])
            for old, new in zip((self.joints, self.weights), rows, strict=True))

    def split(self, longest):
        """Splits every edge longer than this once. Returns whether there was one."""
        corners = np.stack([self.triangles, np.roll(self.triangles, -1, 1)], 2)  # [T, 3, 2] of the edges
        far = np.linalg.norm(self.rest[corners[..., 0]] - self.rest[corners[..., 1]], axis=2) > longest
        if not far.any():
            return False
        edges, number = np.unique(np.sort(corners[far], 1), axis=0, return_inverse=True)
        middles = np.full(self.triangles.shape, -1)
        middles[far] = len(self.rest) + number.ravel()
        self.add_middles(edges)
        # Turned round until the first edge is split, and of two split ones the last is whole.
        turn = np.where(far.sum(1) == 2, (np.argmin(far, 1) + 1) % 3, np.argmax(far, 1))[:, None]
        order = (np.arange(3) + turn) % 3
        (a, b, c), (ab, bc, ca) = (np.take_along_axis(x, order, 1).T for x in (self.triangles, middles))
        n = far.sum(1)
        near = np.linalg.norm(self.rest[a] - self.rest[bc], axis=1) < np.linalg.norm(self.rest[ab] - self.rest[c], axis=1)
        pieces = [(n == 0, (a, b, c)), (n == 1, (a, ab, c)), (n == 1, (ab, b, c)), (n >= 2, (ab, b, bc)),
                  ((n == 2) & near, (a, ab, bc)), ((n == 2) & near, (a, bc, c)),
                  ((n == 2) & ~near, (a, ab, c)), ((n == 2) & ~near, (ab, bc, c)),
                  (n == 3, (a, ab, ca)), (n == 3, (ab, bc, ca)), (n == 3, (ca, bc, c))]
        self.triangles = np.concatenate([np.stack(corner, 1)[which] for which, corner in pieces])
        return True

    def write(self, g):
        def unit(values):
            return values / np.maximum(np.linalg.norm(values[:, :3], axis=1, keepdims=True), 1e-9)

        out, targets = {}, [{} for _ in self.primitive.get("targets", [])]
        for name, values in self.values.items():
            if name == "NORMAL":
                values = unit(values)
            if name == "TANGENT":
                values = np.concatenate([unit(values[:, :3]), np.where(values[:, 3:] < 0, -1, 1)], 1)
            into, key = (out, name) if isinstance(name, str) else (targets[name[0]], name[1])
            into[key] = g.accessor(values.astype(np.float32))
        for s in range(0, self.joints.shape[1], 4):
            width = ((0, 0), (0, max(0, s + 4 - self.joints.shape[1])))
            out[f"JOINTS_{s // 4}"] = g.accessor(np.pad(self.joints[:, s:s + 4], width).astype(np.uint16))
            out[f"WEIGHTS_{s // 4}"] = g.accessor(np.pad(self.weights[:, s:s + 4], width).astype(np.float32))
        self.primitive["attributes"] = out
        if targets:
            self.primitive["targets"] = targets
        self.primitive["indices"] = g.accessor(self.triangles.ravel().astype(np.uint32))


def split_file(options):
    """Reads, splits and writes. Returns what became of it."""
    g = read_glb(options.input)
    matrices, parts, seen = node_matrices(g), [], set()
    for number, node in enumerate(g.json["nodes"]):
        if "mesh" not in node or node["mesh"] in seen:
            continue
        seen.add(node["mesh"])
        parts += [Part(g, primitive, {**node, "number": number}, matrices)
                  for primitive in g.json["meshes"][node["mesh"]]["primitives"] if primitive.get("mode", 4) == 4]
    places = np.concatenate([part.rest for part in parts])
    longest = options.share * np.linalg.norm(places.max(0) - places.min(0))
    if not (np.isfinite(places).all() and longest > 0):
        raise ValueError("its vertices are all at one place, or not finite")
    before = sum(len(part.triangles) for part in parts)
    for part in parts:
        for _ in range(MAX_PASSES):
            if not part.split(longest):
                break
        part.write(g)
    g.save(options.output)
    return (f"{before} triangles became {sum(len(part.triangles) for part in parts)}, "
            f"{len(places)} vertices {sum(len(part.rest) for part in parts)}")


def main():
    parser = ArgumentParser(__doc__)
    parser.add_argument("input", type=pathlib.Path)
    parser.add_argument("output", type=pathlib.Path)
    parser.add_argument("--share", type=float, default=0.03, help="of the diagonal, 0.002 to 1")
    options = parser.parse_args()
    if not 0.002 <= options.share <= 1:
        parser.error("--share must be 0.002 to 1")
    try:
        print(split_file(options))
    except (ValueError, KeyError, IndexError, TypeError, AttributeError, RecursionError, struct.error) as error:
        sys.exit(f"split_triangles: {options.input}: damaged, or not read: {error!r}")


if __name__ == "__main__":
    main()
