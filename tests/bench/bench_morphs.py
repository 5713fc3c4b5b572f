"""Held-out error of a face with morph targets against the same rig without them.

usage: bench_morphs.py BIN [--rays N] [--fps N]

Bakes the synthetic face (samples/face.glb) and its copy without targets, holds one clip out, and fits additive and
composed models. With $PENUMBRA_FACE = FILE.glb (a skinned face with morph targets, of which nothing is stored here) it
also gives that rig four clips, in which head and neck turn and the weights of all targets come and go, and does the
same. The bound is composed with targets <= 1.1 x composed without, by relative error of the clip that is held out.
"""
import argparse
import json
import os
import struct
import subprocess
import tempfile
import time

import numpy as np

CLIPS, SECONDS, KEYS = 4, 4.0, 41


def read_glb(path):
    data = open(path, "rb").read()
    size = struct.unpack("<I", data[12:16])[0]
    return json.loads(data[20 : 20 + size]), data[28 + size :]


def write_glb(path, document, binary):
    binary += b"\0" * (-len(binary) % 4)
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    with open(path, "wb") as f:
        f.write(struct.pack("<4sII", b"glTF", 2, 28 + len(text) + len(binary)))
        f.write(struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(binary), b"BIN\0") + binary)


def weights_of(targets, seed):
    """Returns weights [KEYS, targets]: each target has a pulse now and then, some five at a time."""
    state = np.random.RandomState(seed)
    t = np.linspace(0, SECONDS, KEYS)[:, None]
    wave = np.sin(2 * np.pi * (state.uniform(0.2, 0.8, targets) * t + state.uniform(0, 1, targets)))
    height = 1 - min(0.9, 5 / targets)
    return np.clip((wave - height) / (1 - height), 0, 1) ** 0.7


def turn(axis, degrees):
    half = np.radians(degrees) / 2
    q = np.zeros((len(half), 4))
    q[:, axis], q[:, 3] = np.sin(half), np.cos(half)
    return q


def product(a, b):
    v = a[:, 3:] * b[:, :3] + b[:, 3:] * a[:, :3] + np.cross(a[:, :3], b[:, :3])
    return np.concatenate([v, (a[:, 3] * b[:, 3] - (a[:, :3] * b[:, :3]).sum(1))[:, None]], 1)


def animate(source, path, morphs):
    """Writes a copy with CLIPS clips, with the targets and their weights or without both."""
    document, binary = read_glb(source)
    binary = binary[: document["buffers"][0]["byteLength"]]
    binary += b"\0" * (-len(binary) % 4)

    def accessor(values, kind):
        nonlocal binary
        values = np.ascontiguousarray(values, np.float32)
        document["bufferViews"].append({"buffer": 0, "byteOffset": len(binary), "byteLength": values.nbytes})
        entry = {"bufferView": len(document["bufferViews"]) - 1, "componentType": 5126, "type": kind}
        entry["count"] = values.size // {"SCALAR": 1, "VEC4": 4}[kind]
        if kind == "SCALAR":
            entry.update(min=[float(values.min())], max=[float(values.max())])
        document["accessors"].append(entry)
        binary += values.tobytes()
        return len(document["accessors"]) - 1

    meshes = document["meshes"]
    names = sorted({n for m in meshes for n in m.get("extras", {}).get("targetNames", [])})
    turned = [n for n, node in enumerate(document["nodes"]) if node.get("name", "").lower().split("_")[-1] in ("head", "neck")]
    assert turned and names, "no joint is called head or neck, or no target has a name"
    document["animations"] = []
    times = accessor(np.linspace(0, SECONDS, KEYS), "SCALAR")
    for clip in range(CLIPS):
        samplers, channels = [], []

        def channel(node, what, output):
            samplers.append({"input": times, "output": output})
            channels.append({"sampler": len(samplers) - 1, "target": {"node": node, "path": what}})

        t = np.linspace(0, SECONDS, KEYS)
        for node in turned:
            rest = np.tile(document["nodes"][node].get("rotation", [0, 0, 0, 1]), (KEYS, 1))
            nod = product(turn(0, 10 * np.sin(1.3 * t + 0.7 * clip)), turn(1, 18 * np.sin(0.8 * t + 1.4 * clip)))
            channel(node, "rotation", accessor(product(rest, nod), "VEC4"))
        weights = weights_of(len(names), clip)
        for node, entry in enumerate(document["nodes"]):
            of_mesh = meshes[entry["mesh"]].get("extras", {}).get("targetNames", []) if "mesh" in entry else []
            if morphs and of_mesh:
                columns = weights[:, [names.index(n) for n in of_mesh]]
                channel(node, "weights", accessor(columns, "SCALAR"))
        document["animations"].append({"name": "clip%d" % clip, "samplers": samplers, "channels": channels})
    for mesh in [] if morphs else meshes:
        mesh.pop("weights", None)
        for primitive in mesh["primitives"]:
            primitive.pop("targets", None)
    document["buffers"][0]["byteLength"] = len(binary)
    write_glb(path, document, binary)


class Bench:
    def __init__(self, options, folder):
        self.options, self.folder = options, folder

    def run(self, tool, *words):
        program = os.path.join(self.options.bin, "penumbra-" + tool)
        start = time.perf_counter()
        result = subprocess.run([program, *map(str, words)], capture_output=True, text=True)
        assert result.returncode == 0, (tool, words, result.stderr)
        return time.perf_counter() - start

    def measure(self, rig, holdout):
        """Returns a row: vertices, weights, held-out errors of both models, bytes a vertex and seconds."""
        at = lambda name: os.path.join(self.folder, name)
        vis, fields = at("x.vis.h5"), at("x.fields.h5")
        rays, fps = self.options.rays, self.options.fps
        row = {"bake": self.run("bake", "visibility", rig, "--local", "--rays", rays, "--fps", fps, "-o", vis)}
        self.run("bake", "fields", rig, "-o", fields)
        for kind, words in (("additive", []), ("composed", ["--model", "composed", "--fields", fields])):
            model, report = at(kind + ".model.h5"), at(kind + ".json")
            seconds = self.run("fit", "visibility", vis, "--holdout", holdout, *words, "-o", model, "--report", report)
            figures = json.load(open(report))["figures"]["held_out"]
            asset = at(kind + ".pnb")
            self.run("pack", "asset", model, "-o", asset)
            row[kind] = {**figures, "fit": seconds, "bytes": os.path.getsize(asset)}
        self.run("bake", "info", vis, "--report", at("info.json"))
        info = json.load(open(at("info.json")))["figures"]
        row["vertices"], row["weights"] = info["mesh"]["vertices"], len(info.get("inputs", []))
        return row


def show(name, rows):
    for label, row in rows.items():
        for kind in ("additive", "composed"):
            e = row[kind]
            print(
                "%-12s %-8s %-9s %6d vertices %4d weights  held out %.4f  rms V %.4f  E %.4f  %6.0f bytes a vertex, "
                "bake %.1f s, fit %.1f s" % (name, label, kind, row["vertices"], row["weights"], e["relative_error"],
                e["rms_v"], e["ambient_error"], e["bytes"] / row["vertices"], row["bake"], e["fit"]), flush=True
            )  # fmt: skip
    ratio = rows["morphs"]["composed"]["relative_error"] / rows["without"]["composed"]["relative_error"]
    print("%-12s composed with targets / without: %.3f (bound 1.1)" % (name, ratio), flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("bin")
    parser.add_argument("--rays", type=int, default=256)
    parser.add_argument("--fps", type=int, default=10)
    options = parser.parse_args()
    samples = os.path.join(options.bin, "..", "samples")
    with tempfile.TemporaryDirectory() as folder:
        bench = Bench(options, folder)
        faces = {"morphs": os.path.join(samples, "face.glb"), "without": os.path.join(samples, "still_face.glb")}
        show("face", {label: bench.measure(rig, "quarrel") for label, rig in faces.items()})
        if real := os.environ.get("PENUMBRA_FACE"):
            rows = {}
            for label in ("morphs", "without"):
                rig = os.path.join(folder, label + ".glb")
                animate(real, rig, label == "morphs")
                rows[label] = bench.measure(rig, "clip3")
            show(os.path.basename(real), rows)


main()
