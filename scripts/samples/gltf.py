"""A glTF 2.0 writer: as much of the format as the samples need."""
import json
import struct

import numpy as np

COMPONENTS = {"int8": 5120, "uint8": 5121, "int16": 5122, "uint16": 5123, "uint32": 5125, "float32": 5126}
SHAPES = {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4", 16: "MAT4"}


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
        """Adds `base` (or None: zeros) with `values` at `rows`."""
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
            columns = inverse_bind.transpose(0, 2, 1).reshape(-1, 16)
            skin["inverseBindMatrices"] = self.accessor(columns.astype(np.float32))
        self.json["skins"].append(skin)
        return len(self.json["skins"]) - 1

    def clip(self, name, *channels):
        """Adds a clip. channels: (node, path, times, values[, interpolation])"""
        samplers, targets = [], []
        for node, path, times, values, *mode in channels:
            values = np.asarray(values)
            normalized = values.dtype != np.float32 and values.dtype != np.float64
            values = values if normalized else values.astype(np.float32)
            keys = self.accessor(np.asarray(times, np.float32))
            sampler = {"input": keys, "output": self.accessor(values, normalized)}
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


def primitive(g, points, triangles, joints=None, weights=None, dtype=np.float32):
    attributes = {"POSITION": g.accessor(points.astype(np.float32))}
    for n in range(0 if joints is None else joints.shape[1] // 4):
        columns = slice(4 * n, 4 * n + 4)
        w = np.round(weights[:, columns] * np.iinfo(dtype).max) if dtype != np.float32 else weights[:, columns]
        attributes["JOINTS_%d" % n] = g.accessor(joints[:, columns].astype(np.uint8))
        attributes["WEIGHTS_%d" % n] = g.accessor(w.astype(dtype), dtype != np.float32)
    return {"attributes": attributes, "indices": g.accessor(np.asarray(triangles, np.uint16).reshape(-1))}
