#!/usr/bin/python3
"""Makes a denser or a coarser copy of a skinned glTF character, to measure what density costs.

  scripts/rigs/change_density.py RIG.glb OUT.glb --subdivide N     N steps of Loop subdivision
  scripts/rigs/change_density.py RIG.glb OUT.glb --vertices N      edges collapse until N vertices are left

All meshes of the first skin become one primitive without texture coordinates. Weights are subdivided as positions are,
and the four largest stay. Collapses are those of Garland and Heckbert 1997 onto one of the two vertices. RIG.glb must have one buffer, and neither sparse nor compressed accessors. Needs numpy."""
import heapq
import json
import pathlib
import struct
import sys

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent))
from usage import ArgumentParser

TYPES = {5121: np.uint8, 5123: np.uint16, 5125: np.uint32, 5126: np.float32}
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}


def read_glb(path):
    data = open(path, "rb").read()
    length = struct.unpack_from("<I", data, 12)[0]
    return json.loads(data[20:20 + length]), data[20 + length + 8:]


def read_accessor(gltf, blob, index):
    accessor = gltf["accessors"][index]
    view = gltf["bufferViews"][accessor["bufferView"]]
    kind, width = np.dtype(TYPES[accessor["componentType"]]), WIDTHS[accessor["type"]]
    begin = view.get("byteOffset", 0) + accessor.get("byteOffset", 0)
    stride = view.get("byteStride", kind.itemsize * width)
    rows = np.lib.stride_tricks.as_strided(np.frombuffer(blob, np.uint8, offset=begin)[:1],
                                           (accessor["count"], kind.itemsize * width), (stride, 1))
    values = rows.copy().view(kind).astype(np.float64)
    if accessor.get("normalized"):
        values /= np.iinfo(kind).max
    return values


def read_mesh(gltf, blob, joints):
    """Positions [V,3], dense weights [V,joints], triangles [T,3] of all meshes of skin 0, welded."""
    positions, weights, triangles, count = [], [], [], 0
    for node in gltf["nodes"]:
        if node.get("skin") != 0 or "mesh" not in node:
            continue
        for primitive in gltf["meshes"][node["mesh"]]["primitives"]:
            attributes = primitive["attributes"]
            positions.append(read_accessor(gltf, blob, attributes["POSITION"]))
            dense = np.zeros((len(positions[-1]), joints))
            sets = sum(name.startswith("JOINTS_") for name in attributes)
            for n in range(sets):
                indices = read_accessor(gltf, blob, attributes[f"JOINTS_{n}"]).astype(int)
                values = read_accessor(gltf, blob, attributes[f"WEIGHTS_{n}"])
                for k in range(4):
                    np.add.at(dense, (np.arange(len(dense)), indices[:, k]), values[:, k])
            weights.append(dense / dense.sum(1, keepdims=True))
            triangles.append(read_accessor(gltf, blob, primitive["indices"]).astype(int).reshape(-1, 3) + count)
            count += len(positions[-1])
    positions, weights, triangles = np.vstack(positions), np.vstack(weights), np.vstack(triangles)
    key = np.hstack([np.round(positions, 6), np.round(weights, 4)])
    _, first, which = np.unique(key, axis=0, return_index=True, return_inverse=True)
    return clean(positions[first], weights[first], which.reshape(-1)[triangles])


def clean(positions, weights, triangles):
    a, b, c = triangles.T
    triangles = triangles[(a != b) & (b != c) & (c != a)]
    used, triangles = np.unique(triangles, return_inverse=True)
    return positions[used], weights[used], triangles.reshape(-1, 3)


def subdivide(positions, weights, triangles):
    """One step of Loop subdivision (Loop 1987), with Warren's weights; edges of one triangle or of more than two are
    boundaries."""
    values = np.hstack([positions, weights])
    corners = np.concatenate([triangles[:, [1, 2]], triangles[:, [2, 0]], triangles[:, [0, 1]]])
    opposite = triangles.T.reshape(-1)
    edges, which, count = np.unique(np.sort(corners, 1), axis=0, return_inverse=True, return_counts=True)
    which = which.reshape(-1)
    inner = count == 2
    middle = (values[edges[:, 0]] + values[edges[:, 1]]) / 2
    across = np.zeros_like(middle)
    np.add.at(across, which, values[opposite])
    middle[inner] = middle[inner] * 0.75 + across[inner] / 8
    ends = np.concatenate([edges, edges[:, ::-1]])
    twice = np.concatenate([inner, inner])
    degree = np.bincount(ends[twice, 0], minlength=len(values))
    rim = np.bincount(ends[~twice, 0], minlength=len(values))
    beta = np.where(degree == 3, 3 / 16, 3 / (8 * np.maximum(degree, 1)))
    ring, rim_ring = np.zeros_like(values), np.zeros_like(values)
    np.add.at(ring, ends[twice, 0], values[ends[twice, 1]])
    np.add.at(rim_ring, ends[~twice, 0], values[ends[~twice, 1]])
    moved = values * (1 - degree * beta)[:, None] + ring * beta[:, None]
    moved = np.where((rim == 2)[:, None], values * 0.75 + rim_ring / 8, np.where((rim > 0)[:, None], values, moved))
    a, b, c = triangles.T
    ab, bc, ca = (len(values) + which[2 * len(triangles):], len(values) + which[:len(triangles)],
                  len(values) + which[len(triangles):2 * len(triangles)])
    faces = np.vstack([np.stack(t, 1) for t in ((a, ab, ca), (b, bc, ab), (c, ca, bc), (ab, bc, ca))])
    out = np.vstack([moved, middle])
    return out[:, :3], out[:, 3:], faces


def decimate(positions, weights, triangles, wanted):
    """Half-edge collapses of least quadric error; boundaries stay, and no triangle turns over."""
    triangles = [list(t) for t in triangles]
    around = [set() for _ in positions]
    quadrics = np.zeros((len(positions), 4, 4))
    for i, t in enumerate(triangles):
        normal = np.cross(positions[t[1]] - positions[t[0]], positions[t[2]] - positions[t[0]])
        area = np.linalg.norm(normal)
        plane = np.append(normal, -normal @ positions[t[0]]) / max(area, 1e-30)
        for v in t:
            around[v].add(i)
            quadrics[v] += area * np.outer(plane, plane)
    edges = {(min(t[i], t[i - 1]), max(t[i], t[i - 1])) for t in triangles for i in range(3)}
    faces = lambda u, v: around[u] & around[v]
    rim = {v for u, w in edges if len(faces(u, w)) != 2 for v in (u, w)}
    ring = lambda v: {w for i in around[v] for w in triangles[i]} - {v}

    def cost(u, v):
        p = np.append(positions[v], 1)
        return p @ (quadrics[u] + quadrics[v]) @ p + 1e-9 * np.sum((positions[u] - positions[v])**2)

    def turns(u, v):
        for i in around[u] - around[v]:
            a, b, c = (positions[w] for w in triangles[i])
            d, e, f = (positions[v if w == u else w] for w in triangles[i])
            before, after = np.cross(b - a, c - a), np.cross(e - d, f - d)
            if before @ after <= 0.2 * np.linalg.norm(before) * np.linalg.norm(after):
                return True
        return False

    heap = [(cost(u, v), u, v) for a, b in edges for u, v in ((a, b), (b, a)) if u not in rim]
    heapq.heapify(heap)
    left, gone = len(positions), set()
    while left > wanted and heap:
        error, u, v = heapq.heappop(heap)
        if u in gone or v in gone or v not in ring(u) or cost(u, v) > error * (1 + 1e-12):
            if u not in gone and v not in gone and v in ring(u):
                heapq.heappush(heap, (cost(u, v), u, v))
            continue
        if len(ring(u) & ring(v)) != 2 or turns(u, v):
            continue
        for i in faces(u, v):
            for w in triangles[i]:
                around[w].discard(i)
            triangles[i] = None
        for i in around[u]:
            triangles[i][triangles[i].index(u)] = v
        around[v] |= around[u]
        quadrics[v] += quadrics[u]
        gone.add(u)
        left -= 1
        for w in ring(v):
            for a, b in ((w, v), (v, w)):
                if a not in rim:
                    heapq.heappush(heap, (cost(a, b), a, b))
    return clean(positions, weights, np.array([t for t in triangles if t]))


def normals_of(positions, triangles):
    a, b, c = (positions[triangles[:, i]] for i in range(3))
    area = np.cross(b - a, c - a)
    normals = np.zeros_like(positions)
    for i in range(3):
        np.add.at(normals, triangles[:, i], area)
    return normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-30)


def write_glb(path, gltf, blob, positions, weights, triangles):
    joints = np.argsort(-weights, axis=1, kind="stable")[:, :4]
    values = np.take_along_axis(weights, joints, 1)
    values = np.maximum(values, 0) / np.maximum(values, 0).sum(1, keepdims=True)
    if values.shape[1] < 4:
        pad = ((0, 0), (0, 4 - values.shape[1]))
        joints, values = np.pad(joints, pad), np.pad(values, pad)
    blob = bytes(blob) + b"\0" * (-len(blob) % 4)

    def add(array, kind, component, **more):
        nonlocal blob
        gltf["bufferViews"].append({"buffer": 0, "byteOffset": len(blob), "byteLength": array.nbytes})
        gltf["accessors"].append({"bufferView": len(gltf["bufferViews"]) - 1, "componentType": component,
                                  "count": len(array), "type": kind, **more})
        blob += array.tobytes() + b"\0" * (-array.nbytes % 4)
        return len(gltf["accessors"]) - 1

    positions = positions.astype(np.float32)
    attributes = {
        "POSITION": add(positions, "VEC3", 5126, min=positions.min(0).tolist(), max=positions.max(0).tolist()),
        "NORMAL": add(normals_of(positions.astype(float), triangles).astype(np.float32), "VEC3", 5126),
        "JOINTS_0": add(joints.astype(np.uint16), "VEC4", 5123),
        "WEIGHTS_0": add(values.astype(np.float32), "VEC4", 5126)}
    primitive = {"attributes": attributes, "indices": add(triangles.astype(np.uint32).reshape(-1), "SCALAR", 5125)}
    first = next(n for n in gltf["nodes"] if n.get("skin") == 0 and "mesh" in n)
    for node in gltf["nodes"]:
        if node is not first:
            node.pop("mesh", None)
            node.pop("skin", None)
    gltf["meshes"] = [{"primitives": [primitive]}]
    first["mesh"] = 0
    for key in ("materials", "textures", "images", "samplers"):
        gltf.pop(key, None)
    gltf["buffers"][0]["byteLength"] = len(blob)
    text = json.dumps(gltf).encode()
    text += b" " * (-len(text) % 4)
    with open(path, "wb") as out:
        out.write(struct.pack("<4sII", b"glTF", 2, 28 + len(text) + len(blob)))
        out.write(struct.pack("<II", len(text), 0x4E4F534A) + text)
        out.write(struct.pack("<II", len(blob), 0x004E4942) + blob)


def main():
    parser = ArgumentParser(__doc__)
    parser.add_argument("rig")
    parser.add_argument("out")
    way = parser.add_mutually_exclusive_group(required=True)
    way.add_argument("--subdivide", type=int)
    way.add_argument("--vertices", type=int)
    arguments = parser.parse_args()
    gltf, blob = read_glb(arguments.rig)
    mesh = read_mesh(gltf, blob, len(gltf["skins"][0]["joints"]))
    if arguments.vertices:
        mesh = decimate(*mesh, arguments.vertices)
    for _ in range(arguments.subdivide or 0):
        mesh = subdivide(*mesh)
    write_glb(arguments.out, gltf, blob, *mesh)
    print(f"{len(mesh[0])} vertices, {len(mesh[2])} triangles")


if __name__ == "__main__":
    main()
