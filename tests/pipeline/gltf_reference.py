"""An evaluation of skinned glTF of its own: reads GLB with struct, json and numpy, shares nothing with formats/."""
import json
import struct

import numpy as np

TYPES = {5120: "i1", 5121: "u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
LIMIT = {5120: 127.0, 5121: 255.0, 5122: 32767.0, 5123: 65535.0}
WIDTH = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}


class Glb:
    def __init__(self, path):
        data = open(path, "rb").read()
        size = struct.unpack_from("<I", data, 12)[0]
        self.json = json.loads(data[20 : 20 + size])
        self.bin = data[28 + size :]
        self.nodes = self.json["nodes"]
        self.parent = [-1] * len(self.nodes)
        for n, node in enumerate(self.nodes):
            for child in node.get("children", []):
                self.parent[child] = n

    def elements(self, view, offset, count, component, width):
        dtype = np.dtype(TYPES[component])
        view = self.json["bufferViews"][view]
        start = view.get("byteOffset", 0) + offset
        stride = view.get("byteStride", dtype.itemsize * width)
        rows = [np.frombuffer(self.bin, dtype, width, start + i * stride) for i in range(count)]
        return np.array(rows, np.float64)

    def accessor(self, index):
        a = self.json["accessors"][index]
        width, component = WIDTH[a["type"]], a["componentType"]
        values = np.zeros((a["count"], width))
        if "bufferView" in a:
            values = self.elements(a["bufferView"], a.get("byteOffset", 0), a["count"], component, width)
        if "sparse" in a:
            s = a["sparse"]
            i, v = s["indices"], s["values"]
            where = self.elements(i["bufferView"], i.get("byteOffset", 0), s["count"], i["componentType"], 1)
            what = self.elements(v["bufferView"], v.get("byteOffset", 0), s["count"], component, width)
            values[where[:, 0].astype(int)] = what
        if a.get("normalized"):
            values = np.maximum(values / LIMIT[component], -1)
        return values

    def drawn(self):
        """Returns the nodes of the default scene, in the order of the file."""
        if "scenes" not in self.json:
            return range(len(self.nodes))
        seen, stack = set(), list(self.json["scenes"][self.json.get("scene", 0)].get("nodes", []))
        while stack:
            n = stack.pop()
            seen.add(n)
            stack += self.nodes[n].get("children", [])
        return sorted(seen)


def matrix_of(t, q, s):
    x, y, z, w = np.asarray(q, float) / np.linalg.norm(q)
    m = np.eye(4)
    m[:3, :3] = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    ) * np.asarray(s)
    m[:3, 3] = t
    return m


def interpolate(times, values, mode, time, rotation):
    """Interpolates values [keys, n], or [keys, 3, n] for CUBICSPLINE."""
    values = values.reshape((len(times), 3, -1)) if mode == "CUBICSPLINE" else values
    key = lambda k: values[k][1] if mode == "CUBICSPLINE" else values[k]
    if time <= times[0]:
        return key(0)
    if time >= times[-1]:
        return key(len(times) - 1)
    k = int(np.searchsorted(times, time, side="right")) - 1
    d = times[k + 1] - times[k]
    u = (time - times[k]) / d
    if mode == "STEP":
        return values[k]
    if mode == "CUBICSPLINE":
        v0, b0, a1, v1 = values[k][1], values[k][2], values[k + 1][0], values[k + 1][1]
        h = np.array([2 * u**3 - 3 * u**2 + 1, u**3 - 2 * u**2 + u, 3 * u**2 - 2 * u**3, u**3 - u**2])
        return h[0] * v0 + h[1] * d * b0 + h[2] * v1 + h[3] * d * a1
    a, b = values[k], values[k + 1]
    if not rotation:
        return (1 - u) * a + u * b
    a, b = a / np.linalg.norm(a), b / np.linalg.norm(b)
    cosine = a @ b
    if cosine < 0:
        b, cosine = -b, -cosine
    if cosine > 1 - 1e-12:
        return (1 - u) * a + u * b
    angle = np.arccos(min(cosine, 1.0))
    return (np.sin((1 - u) * angle) * a + np.sin(u * angle) * b) / np.sin(angle)


class Evaluator:
    def __init__(self, path):
        self.glb = glb = Glb(path)
        self.parts = []  # (node, skin, positions [n,4], joints, weights, targets [m,n,3])
        for n in glb.drawn():
            node = glb.nodes[n]
            for primitive in glb.json["meshes"][node["mesh"]]["primitives"] if "mesh" in node else []:
                if primitive.get("mode", 4) < 4:
                    continue
                attributes = primitive["attributes"]
                p = glb.accessor(attributes["POSITION"])
                p = np.hstack([p, np.ones((len(p), 1))])
                joints = weights = None
                if "skin" in node:
                    sets = range(sum(k.startswith("JOINTS_") for k in attributes))
                    joints = np.hstack([glb.accessor(attributes["JOINTS_%d" % i]) for i in sets]).astype(int)
                    weights = np.hstack([glb.accessor(attributes["WEIGHTS_%d" % i]) for i in sets])
                    weights = weights / weights.sum(1, keepdims=True)
                zeros = np.zeros((len(p), 3))
                targets = primitive.get("targets", [])
                moves = [glb.accessor(t["POSITION"]) if "POSITION" in t else zeros for t in targets]
                self.parts.append((n, node.get("skin"), p, joints, weights, moves))
        self.binds = []
        for skin in glb.json.get("skins", []):
            count = len(skin["joints"])
            bind = np.tile(np.eye(4), (count, 1, 1))
            if "inverseBindMatrices" in skin:
                bind = glb.accessor(skin["inverseBindMatrices"])[:count].reshape(-1, 4, 4).transpose(0, 2, 1)
            self.binds.append(bind)
        self.clips = []  # (name, [(node, path, times, values, mode)])
        for i, clip in enumerate(glb.json.get("animations", [])):
            channels = []
            for channel in clip["channels"]:
                target, sampler = channel["target"], clip["samplers"][channel["sampler"]]
                if "node" not in target:
                    continue
                times, values = glb.accessor(sampler["input"])[:, 0], glb.accessor(sampler["output"])
                mode = sampler.get("interpolation", "LINEAR")
                if target["path"] == "weights":
                    values = values.reshape(len(times) * (3 if mode == "CUBICSPLINE" else 1), -1)
                channels.append((target["node"], target["path"], times, values, mode))
            if channels:
                self.clips.append((clip.get("name", "clip%d" % i), channels))

    def globals(self, clip, time):
        glb = self.glb
        local = []
        pose = {}
        for node, path, times, values, mode in self.clips[clip][1] if clip >= 0 else []:
            pose[node, path] = interpolate(times, values, mode, time, path == "rotation")
        for n, node in enumerate(glb.nodes):
            if "matrix" in node:
                local.append(np.array(node["matrix"], float).reshape(4, 4).T)
                continue
            t = pose.get((n, "translation"), node.get("translation", [0, 0, 0]))
            q = pose.get((n, "rotation"), node.get("rotation", [0, 0, 0, 1]))
            s = pose.get((n, "scale"), node.get("scale", [1, 1, 1]))
            local.append(matrix_of(t, q, s))
        out = [None] * len(local)

        def world(n):
            if out[n] is None:
                out[n] = local[n] if glb.parent[n] < 0 else world(glb.parent[n]) @ local[n]
            return out[n]

        return [world(n) for n in range(len(local))]

    def weights_of(self, node, targets, clip, time):
        for of_node, path, times, values, mode in self.clips[clip][1] if clip >= 0 else []:
            if of_node == node and path == "weights":
                return interpolate(times, values, mode, time, False)
        mesh = self.glb.json["meshes"][self.glb.nodes[node]["mesh"]]
        return self.glb.nodes[node].get("weights", mesh.get("weights", [0.0] * targets))

    def positions(self, clip, time):
        """Returns the model-space positions of all source vertices: [R, 3]."""
        world = self.globals(clip, time)
        out = []
        for node, skin, p, joints, weights, moves in self.parts:
            p = p.copy()
            for weight, move in zip(self.weights_of(node, len(moves), clip, time), moves):
                p[:, :3] += weight * move
            if skin is None:
                out.append(p @ world[node].T)
                continue
            skin_joints = self.glb.json["skins"][skin]["joints"]
            bones = np.array([world[j] for j in skin_joints]) @ self.binds[skin]
            posed = np.zeros_like(p)
            for k in range(joints.shape[1]):
                posed += weights[:, k : k + 1] * np.einsum("nab,nb->na", bones[joints[:, k]], p)
            out.append(posed)
        return np.vstack(out)[:, :3]
