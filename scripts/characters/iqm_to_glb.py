#!/usr/bin/python3
"""iqm_to_glb.py MODEL.iqm [CLIPS.iqm ...] -o OUT.glb [--plain]: characters of Sauerbraten (cube2-data) to glTF.

IQM version 2 is a header, text, vertex arrays, triangles, joints and frames of quantised channels; its z is up, and its
triangles are clockwise. Clip files have the joints of the model, in the same order. --plain makes one mesh of all
parts, without materials and texture coordinates: where parts meet their vertices become one shading point.
"""
import json
import math
import pathlib
import struct
import sys

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent))
from usage import ArgumentParser  # noqa: E402

HEADER = ("version", "filesize", "flags", "num_text", "ofs_text", "num_meshes", "ofs_meshes", "num_arrays",
          "num_vertices", "ofs_arrays", "num_triangles", "ofs_triangles", "ofs_adjacency", "num_joints", "ofs_joints",
          "num_poses", "ofs_poses", "num_anims", "ofs_anims", "num_frames", "num_channels", "ofs_frames")
FORMATS = {1: "u1", 7: "<f4"}  # unsigned bytes and floats are all that vertex arrays of characters have
ARRAYS = {0: ("POSITION", 3), 1: ("TEXCOORD_0", 2), 2: ("NORMAL", 3), 4: ("JOINTS_0", 4), 5: ("WEIGHTS_0", 4)}
COMPONENT = {"u1": 5121, "<f4": 5126, "<u4": 5125}


class Iqm:
    def __init__(self, path):
        self.data = pathlib.Path(path).read_bytes()
        if self.data[:16] != b"INTERQUAKEMODEL\0":
            raise SystemExit(f"iqm_to_glb: {path}: is not IQM")
        self.head = dict(zip(HEADER, struct.unpack_from(f"<{len(HEADER)}I", self.data, 16)))
        if self.head["version"] != 2:
            raise SystemExit(f"iqm_to_glb: {path}: is IQM version {self.head['version']}, not 2")

    def rows(self, what, layout):
        size = struct.calcsize(layout)
        start = self.head["ofs_" + what]
        return [struct.unpack_from(layout, self.data, start + k * size) for k in range(self.head["num_" + what])]

    def text(self, at):
        start = self.head["ofs_text"] + at
        return self.data[start:self.data.index(b"\0", start)].decode("utf-8", "replace")

    def arrays(self):
        """Name -> [vertices, width] of the vertex arrays."""
        found = {}
        for kind, _, form, width, offset in self.rows("arrays", "<5I"):
            if kind in ARRAYS:
                values = np.frombuffer(self.data, FORMATS[form], width * self.head["num_vertices"], offset)
                found[ARRAYS[kind][0]] = values.reshape(-1, width)
        return found

    def frames(self):
        """[frames, joints, 10]: translation, rotation and scale of every joint."""
        poses, count = self.rows("poses", "<iI20f"), self.head["num_frames"]
        raw = np.frombuffer(self.data, "<u2", count * self.head["num_channels"], self.head["ofs_frames"])
        raw, out, at = raw.reshape(count, -1), np.empty((count, len(poses), 10)), 0
        for joint, (_, mask, *numbers) in enumerate(poses):
            for k in range(10):
                out[:, joint, k] = numbers[k]
                if mask >> k & 1:
                    out[:, joint, k] += raw[:, at] * float(numbers[10 + k])
                    at += 1
        out[:, :, 3:7] /= np.linalg.norm(out[:, :, 3:7], axis=2, keepdims=True)
        return out


class Glb:
    def __init__(self):
        self.json = {"asset": {"version": "2.0"}, "scene": 0, "accessors": [], "bufferViews": []}
        self.bytes = bytearray()

    def accessor(self, values, kind, **more):
        values = np.ascontiguousarray(values)
        view = {"buffer": 0, "byteOffset": len(self.bytes), "byteLength": values.nbytes}
        self.bytes += values.tobytes() + bytes(-values.nbytes % 4)
        self.json["bufferViews"].append(view)
        component = COMPONENT[values.dtype.str.lstrip("|")]
        self.json["accessors"].append({"bufferView": len(self.json["bufferViews"]) - 1, "componentType": component,
                                       "count": len(values), "type": kind, **more})
        return len(self.json["accessors"]) - 1

    def write(self, path):
        self.json["buffers"] = [{"byteLength": len(self.bytes)}]
        text = json.dumps(self.json).encode()
        text += b" " * (-len(text) % 4)
        head = struct.pack("<4sIIII", b"glTF", 2, 28 + len(text) + len(self.bytes), len(text), 0x4E4F534A)
        pathlib.Path(path).write_bytes(head + text + struct.pack("<II", len(self.bytes), 0x004E4942) + self.bytes)


def matrix(translation, rotation, scale):
    x, y, z, w = rotation
    turn = np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                     [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                     [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]])
    out = np.eye(4)
    out[:3, :3], out[:3, 3] = turn * np.asarray(scale), translation
    return out


def add_joints(model, glb):
    """Nodes 1.. are the joints, node 0 turns z up to y up, the last node is the mesh."""
    nodes, world, half = [{"name": "up", "rotation": [-math.sqrt(.5), 0, 0, math.sqrt(.5)], "children": []}], [], []
    for name, parent, *numbers in model.rows("joints", "<Ii10f"):
        turn = np.array(numbers[3:7]) / np.linalg.norm(numbers[3:7])
        own = matrix(numbers[:3], turn, numbers[7:])
        world.append(own if parent < 0 else world[parent] @ own)
        half.append(np.linalg.inv(world[-1]).T.reshape(16))
        nodes.append({"name": model.text(name), "translation": numbers[:3], "rotation": turn.tolist(),
                      "scale": numbers[7:]})
        nodes[parent + 1].setdefault("children", []).append(len(nodes) - 1)
    glb.json["skins"] = [{"joints": list(range(1, len(nodes))),
                          "inverseBindMatrices": glb.accessor(np.array(half, "<f4"), "MAT4")}]
    glb.json["nodes"] = nodes + [{"name": "character", "mesh": 0, "skin": 0}]
    glb.json["scenes"] = [{"nodes": [0, len(nodes)]}]


def add_mesh(model, glb, plain):
    arrays, parts = model.arrays(), model.rows("meshes", "<6I")
    if plain:
        arrays.pop("TEXCOORD_0", None)
        parts = [(0, parts[0][1], 0, model.head["num_vertices"], 0, model.head["num_triangles"])]
    triangles = np.frombuffer(model.data, "<u4", 3 * model.head["num_triangles"], model.head["ofs_triangles"])
    triangles, primitives = triangles.reshape(-1, 3)[:, [0, 2, 1]], []
    for _, material, first, count, first_triangle, triangle_count in parts:
        attributes = {}
        for name, values in arrays.items():
            part, more = values[first:first + count], {}
            if name == "POSITION":
                more = {"min": part.min(0).tolist(), "max": part.max(0).tolist()}
            if name == "WEIGHTS_0" and part.dtype == np.uint8:
                more = {"normalized": True}
            attributes[name] = glb.accessor(part, f"VEC{values.shape[1]}", **more)
        of_mesh = triangles[first_triangle:first_triangle + triangle_count] - first
        indices = glb.accessor(of_mesh.astype("<u4").ravel(), "SCALAR")
        materials = glb.json.setdefault("materials", [])
        materials.append({"name": model.text(material) or f"material{len(materials)}"})
        primitives.append({"attributes": attributes, "indices": indices, "material": len(materials) - 1})
    glb.json["meshes"] = [{"primitives": primitives}]


def add_clips(file, glb, joints):
    if not file.head["num_anims"] or file.head["num_poses"] != joints:
        return
    frames = file.frames()
    for name, first, count, rate, _ in file.rows("anims", "<3IfI"):
        times = np.arange(count) / (rate or 25)
        time = glb.accessor(times.astype("<f4"), "SCALAR", min=[0.0], max=[float(np.float32(times[-1]))])
        clip = {"name": file.text(name), "channels": [], "samplers": []}
        for joint in range(joints):
            for path, a, b in (("translation", 0, 3), ("rotation", 3, 7), ("scale", 7, 10)):
                values = glb.accessor(frames[first:first + count, joint, a:b].astype("<f4"), f"VEC{b - a}")
                clip["channels"].append({"sampler": len(clip["samplers"]), "target": {"node": joint + 1, "path": path}})
                clip["samplers"].append({"input": time, "output": values})
        glb.json.setdefault("animations", []).append(clip)


def main():
    parser = ArgumentParser(__doc__)
    parser.add_argument("files", nargs="+")
    parser.add_argument("-o", "--output", required=True)
    parser.add_argument("--plain", action="store_true")
    arguments = parser.parse_args()
    model, glb = Iqm(arguments.files[0]), Glb()
    if not model.head["num_meshes"] or not model.head["num_joints"]:
        raise SystemExit(f"iqm_to_glb: {arguments.files[0]}: has no skinned mesh")
    add_joints(model, glb)
    add_mesh(model, glb, arguments.plain)
    for file in arguments.files:
        add_clips(Iqm(file), glb, model.head["num_joints"])
    glb.write(arguments.output)


main()
