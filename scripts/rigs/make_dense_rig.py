#!/usr/bin/python3
"""Writes a skinned grid of many triangles as a GLB, to measure what reading a dense character takes.

  scripts/rigs/make_dense_rig.py OUT.glb [--triangles 2000000]

Positions, normals, four joints and weights a vertex, indices of 32 bits. Needs numpy."""
import json
import pathlib
import struct
import sys

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent))
from usage import ArgumentParser

parser = ArgumentParser(__doc__)
parser.add_argument("out")
parser.add_argument("--triangles", type=int, default=2000000)
arguments = parser.parse_args()
side = int((arguments.triangles / 2)**0.5) + 1
x, y = np.meshgrid(np.linspace(0, 1, side), np.linspace(0, 2, side))
x, y = x.reshape(-1), y.reshape(-1)
z = 0.05 * np.sin(9 * x) * np.sin(7 * y)
normals = np.stack([-0.45 * np.cos(9 * x) * np.sin(7 * y), -0.35 * np.sin(9 * x) * np.cos(7 * y), np.ones_like(x)], 1)
normals /= np.linalg.norm(normals, axis=1, keepdims=True)
corner = (np.arange(side - 1)[:, None] * side + np.arange(side - 1)).reshape(-1)
indices = np.stack([corner, corner + 1, corner + side + 1, corner, corner + side + 1, corner + side], 1).reshape(-1)
weights = np.stack([(4 - y), y, np.full_like(y, 0.5), np.full_like(y, 0.25)], 1)
weights /= weights.sum(1, keepdims=True)
blob, views, accessors = b"", [], []


def add(array, kind, component, **more):
    global blob
    views.append({"buffer": 0, "byteOffset": len(blob), "byteLength": array.nbytes})
    accessors.append({"bufferView": len(views) - 1, "componentType": component, "type": kind,
                      "count": len(array), **more})
    blob += array.tobytes() + b"\0" * (-array.nbytes % 4)
    return len(accessors) - 1


positions = np.stack([x, y, z], 1).astype(np.float32)
attributes = {"POSITION": add(positions, "VEC3", 5126, min=positions.min(0).tolist(), max=positions.max(0).tolist()),
              "NORMAL": add(normals.astype(np.float32), "VEC3", 5126),
              "JOINTS_0": add(np.tile(np.arange(4, dtype=np.uint16), (len(x), 1)), "VEC4", 5123),
              "WEIGHTS_0": add(weights.astype(np.float32), "VEC4", 5126)}
primitive = {"attributes": attributes, "indices": add(indices.astype(np.uint32), "SCALAR", 5125)}
gltf = {"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0, 1]}],
        "nodes": [{"mesh": 0, "skin": 0, "name": "grid"}, {"name": "a", "children": [2]},
                  {"name": "b", "children": [3]}, {"name": "c", "children": [4]}, {"name": "d"}],
        "skins": [{"joints": [1, 2, 3, 4]}], "meshes": [{"primitives": [primitive]}],
        "bufferViews": views, "accessors": accessors, "buffers": [{"byteLength": len(blob)}]}
text = json.dumps(gltf).encode()
text += b" " * (-len(text) % 4)
with open(arguments.out, "wb") as out:
    out.write(struct.pack("<4sII", b"glTF", 2, 28 + len(text) + len(blob)))
    out.write(struct.pack("<II", len(text), 0x4E4F534A) + text + struct.pack("<II", len(blob), 0x004E4942) + blob)
print(f"{len(x)} vertices, {len(indices) // 3} triangles, {28 + len(text) + len(blob)} bytes")
