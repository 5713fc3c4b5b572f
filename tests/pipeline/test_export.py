"""Exports of occlusion, read back by a reader of glTF of its own: what a plain player shows is what was baked.

usage: test_export.py BIN
"""
import json
import os
import shutil
import struct
import sys
import tempfile

import h5py
import numpy as np
import gltf_reference
from gltf_reference import interpolate
from PIL import Image
from programs import must, refused

BIN = sys.argv[1]
BAKE, FIT, PACK = (os.path.join(BIN, "penumbra-" + name) for name in ("bake", "fit", "pack"))
SAMPLES = os.path.join(BIN, "..", "samples")


class Glb(gltf_reference.Glb):
    """Reads packed elements at once: exports have many."""

    def elements(self, view, offset, count, component, width):
        dtype = np.dtype(gltf_reference.TYPES[component])
        if "byteStride" in self.json["bufferViews"][view]:
            return super().elements(view, offset, count, component, width)
        start = self.json["bufferViews"][view].get("byteOffset", 0) + offset
        return np.frombuffer(self.bin, dtype, count * width, start).reshape(count, width).astype(float)


def sample(name):
    return os.path.join(SAMPLES, name + ".glb")


def write_glb(path, document, binary):
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    binary += b"\0" * (-len(binary) % 4)
    with open(path, "wb") as out:
        out.write(struct.pack("<III", 0x46546C67, 2, 28 + len(text) + len(binary)))
        out.write(struct.pack("<II", len(text), 0x4E4F534A) + text + struct.pack("<II", len(binary), 0x4E4942) + binary)


def baked(folder, name, *options):
    """Bakes a rig. Returns the file, its clips and times, and ambient visibility [frames, source vertices]."""
    vis = os.path.join(folder, "baked.vis.h5")
    must(BAKE, "visibility", name, "-o", vis, "--rays", "32", *options)
    with h5py.File(vis) as f:
        b, n = f["visibility/coefficients"][:].astype(float), f["frames/normals"][:].astype(float)
        # y_1 = sqrt(3 / 4 pi) (-y, z, -x): the integral of V s is band 1 over that root.
        visible = np.stack([-b[..., 3], -b[..., 1], b[..., 2]], -1) / np.sqrt(3 / (4 * np.pi))
        ambient = ((visible * n).sum(-1) / np.pi).clip(0, 1)[:, f["mesh/source_vertex"][:]]
        return vis, [f["clips/names"][i].decode() for i in f["frames/clip"][:]], f["frames/time"][:], ambient


def primitives(glb):
    """Yields node, primitive and range of source vertices, as Penumbra counts them."""
    first = 0
    for n in glb.drawn():
        if "mesh" in glb.nodes[n]:
            for p in glb.json["meshes"][glb.nodes[n]["mesh"]]["primitives"]:
                if p.get("mode", 4) < 4:
                    continue
                count = glb.json["accessors"][p["attributes"]["POSITION"]]["count"]
                yield n, p, slice(first, first + count)
                first += count


def weights_at(glb, clip, node, time):
    """The morph weights of a node, as section 3.11 of glTF 2.0 asks."""
    mesh = glb.json["meshes"][glb.nodes[node]["mesh"]]
    none = [0.0] * len(mesh["primitives"][0].get("targets", []))
    rest = glb.nodes[node].get("weights", mesh.get("weights", none))
    animation = next(a for a in glb.json["animations"] if a["name"] == clip)
    for channel in animation["channels"]:
        if channel["target"] == {"node": node, "path": "weights"}:
            sampler = animation["samplers"][channel["sampler"]]
            times = glb.accessor(sampler["input"])[:, 0]
            mode = sampler.get("interpolation", "LINEAR")
            values = glb.accessor(sampler["output"]).reshape(len(times) * (3 if mode == "CUBICSPLINE" else 1), -1)
            assert values.shape[1] == len(rest) and (np.diff(times) > 0).all()
            return interpolate(times, values, mode, time, False)
    return np.array(rest, float)


def shown(glb, primitive, weights, attribute):
    out = glb.accessor(primitive["attributes"][attribute])
    assert len(primitive.get("targets", [])) == len(weights)
    for weight, target in zip(weights, primitive.get("targets", [])):
        if attribute in target:
            out = out + weight * glb.accessor(target[attribute])
    return out


def only_appended(before, after):
    """Everything that the file had is there, in its place."""
    a, b = Glb(before), Glb(after)
    size = a.json["buffers"][0]["byteLength"]
    assert a.bin[:size] == b.bin[:size]
    for key, value in a.json.items():
        if key in ("meshes", "buffers", "asset", "animations", "nodes"):
            continue
        assert (b.json[key][: len(value)] if isinstance(value, list) else b.json[key]) == value, key
    assert list(a.json) == list(b.json)[: len(a.json)]


def check_play(folder):
    """A face whose clips drive morph weights of its own keeps them, and its colours follow the bake."""
    vis, clips, times, ambient = baked(folder, sample("face"), "--fps", "4")
    out = os.path.join(folder, "face.ao.glb")
    print(must(PACK, "export", vis, sample("face"), "-o", out, "--as", "play", "--components", "0"), end="")
    only_appended(sample("face"), out)
    before, after = Glb(sample("face")), Glb(out)
    for f, (clip, time) in enumerate(zip(clips, times)):
        for node, primitive, rows in primitives(after):
            weights = weights_at(after, clip, node, time)
            color = shown(after, primitive, weights, "COLOR_0")
            # Floats: 4e-7 was measured.
            assert np.abs(color[:, 0] - ambient[f, rows]).max() < 3e-6 and np.ptp(color, 1).max() == 0
    random = np.random.default_rng(1)
    for clip in set(clips):
        for time in random.uniform(-0.2, 1.2, 40) * times.max():
            for (node, a, _), (_, b, _) in zip(primitives(before), primitives(after)):
                old, new = weights_at(before, clip, node, time), weights_at(after, clip, node, time)
                assert np.abs(new[: len(old)] - old).max(initial=0) < 1e-6
                assert np.array_equal(shown(before, a, old, "POSITION"), shown(after, b, np.r_[old, 0 * new[len(old) :]], "POSITION"))
    names = after.json["meshes"][0]["extras"]["targetNames"]
    own = len(before.json["meshes"][0]["extras"]["targetNames"])
    assert names[:own] == before.json["meshes"][0]["extras"]["targetNames"] and names[own] == "penumbra_ao_0"
    assert len(after.json["meshes"][0]["weights"]) == len(names)

    # The export has just as many components as the error bound needs, and not one more.
    report = os.path.join(folder, "report.json")
    must(PACK, "export", vis, sample("face"), "-o", out, "--as", "play", "--max-error", ".005", "--report", report)
    figures = json.load(open(report))["figures"]
    count = figures["components"]
    after = Glb(out)
    error = []
    for f, (clip, time) in enumerate(zip(clips, times)):
        for node, primitive, rows in primitives(after):
            error.append(shown(after, primitive, weights_at(after, clip, node, time), "COLOR_0")[:, 0] - ambient[f, rows])
    assert 0 < count < figures["all_components"] and figures["rms_error"] <= 0.005
    assert np.abs(np.concatenate(error)).max() < figures["max_error"] + 1e-6
    must(PACK, "export", vis, sample("face"), "-o", out, "--as", "play", "--components", count - 1, "--report", report)
    assert json.load(open(report))["figures"]["rms_error"] > 0.005
    return vis


def add_array(document, binary, array, component, kind, **more):
    """Adds an accessor with a buffer view of its own, and returns its number."""
    binary.extend(b"\0" * (-len(binary) % 4))
    document["bufferViews"].append({"buffer": 0, "byteOffset": len(binary), "byteLength": array.nbytes})
    binary.extend(array.tobytes())
    document["buffers"][0]["byteLength"] = len(binary)
    view = len(document["bufferViews"]) - 1
    document["accessors"].append({"bufferView": view, "componentType": component, "count": len(array), "type": kind} | more)
    return len(document["accessors"]) - 1


def many_things(path):
    """A rig with all that an export must take care of: two nodes of one mesh, quantised positions, colours of its own
    with alpha, a gap between texture coordinates, an extension that nobody knows, a primitive of lines."""
    glb = Glb(sample("quantized"))
    document, binary = glb.json, bytearray(glb.bin[: glb.json["buffers"][0]["byteLength"]])
    mesh = document["nodes"][next(n for n in glb.drawn() if "mesh" in glb.nodes[n])]["mesh"]
    primitive = document["meshes"][mesh]["primitives"][0]
    count = document["accessors"][primitive["attributes"]["POSITION"]]["count"]

    def add(*array, **more):
        return add_array(document, binary, *array, **more)

    colors = np.random.default_rng(2).integers(0, 256, (count, 4)).astype(np.uint8)
    primitive["attributes"]["COLOR_0"] = add(colors, 5121, "VEC4", normalized=True)
    uv = np.linspace(0, 1, 2 * count, dtype=np.float32).reshape(count, 2)
    primitive["attributes"]["TEXCOORD_0"] = add(uv, 5126, "VEC2")
    primitive["attributes"]["TEXCOORD_2"] = add(uv[::-1].copy(), 5126, "VEC2")
    still = add(np.array([[0, 0, 0], [3, 0, 0], [0, 3, 0], [9, 0, 0], [9, 3, 0], [6, 0, 0]], np.float32), 5126, "VEC3")
    document["accessors"][still] |= {"min": [0, 0, 0], "max": [9, 3, 0]}
    lines = {"attributes": {"POSITION": still}, "mode": 1}
    document["meshes"].append({"primitives": [{"attributes": {"POSITION": still}}, lines], "extras": {"mine": [1.0, 2]}})
    roots = document["scenes"][document.get("scene", 0)]["nodes"]
    for x in (5, -20):
        document["nodes"].append({"mesh": len(document["meshes"]) - 1, "translation": [x, 0, 0], "name": "sail \u00e4"})
        roots.append(len(document["nodes"]) - 1)
    document["extensionsUsed"] = document.get("extensionsUsed", []) + ["ACME_unheard"]
    document["nodes"][0].setdefault("extensions", {})["ACME_unheard"] = {"z": 1, "a": [1e-7, {"b": None}]}
    write_glb(path, document, bytes(binary))


def colored_face(path):
    """A face whose vertices have colours, which some of its morph targets change."""
    glb = Glb(sample("face"))
    document, binary = glb.json, bytearray(glb.bin[: glb.json["buffers"][0]["byteLength"]])
    random = np.random.default_rng(4)
    for primitive in document["meshes"][0]["primitives"]:
        count = document["accessors"][primitive["attributes"]["POSITION"]]["count"]
        numbers = lambda low, high: random.uniform(low, high, (count, 3)).astype(np.float32)
        primitive["attributes"]["COLOR_0"] = add_array(document, binary, numbers(0.3, 0.6), 5126, "VEC3")
        for target in primitive["targets"][::2]:
            target["COLOR_0"] = add_array(document, binary, numbers(-0.1, 0.1), 5126, "VEC3")
    write_glb(path, document, bytes(binary))


def meshopt(data, stride):
    """Encodes vertices as mode ATTRIBUTES of EXT_meshopt_compression, version 0, without saving anything: each byte is
    stored as its difference from that of the vertex before, in groups of 16 literal bytes."""
    rows = np.frombuffer(data, np.uint8).reshape(-1, stride)
    block = min(8192 // stride, 256) & ~15
    before, out = rows[0], bytearray([0xA0])
    for first in range(0, len(rows), block):
        part = rows[first : first + block]
        deltas = np.diff(part, axis=0, prepend=before[None]).astype(np.int8)
        before = part[-1]
        zigzag = (deltas << 1 ^ deltas >> 7).astype(np.uint8)
        groups = -(-len(part) // 16)
        for k in range(stride):
            out += b"\xff" * (groups // 4) + bytes([(1 << 2 * (groups % 4)) - 1] if groups % 4 else [])
            out += zigzag[:, k].tobytes() + b"\0" * (16 * groups - len(part))
    return bytes(out + b"\0" * (32 - stride) + rows[0].tobytes())


def compress(document, binary, accessor):
    """Moves the vertices of an accessor with a view of its own into a view that is compressed."""
    a = document["accessors"][accessor]
    view = document["bufferViews"][a["bufferView"]]
    stride = view.get("byteStride", view["byteLength"] // a["count"])
    data = binary[view.get("byteOffset", 0) : view.get("byteOffset", 0) + view["byteLength"]]
    encoded = meshopt(data, stride)
    binary.extend(b"\0" * (-len(binary) % 4))
    view["extensions"] = {"EXT_meshopt_compression": {"buffer": 0, "byteOffset": len(binary), "byteLength": len(encoded),
                          "byteStride": stride, "count": a["count"], "mode": "ATTRIBUTES"}}  # fmt: skip
    view["buffer"], view["byteOffset"] = 1, 0
    binary.extend(encoded)
    document["buffers"][0]["byteLength"] = len(binary)


def compressed_flock(path):
    """A quantised character among instances of a quantised patch. Vertices of both are compressed."""
    glb = Glb(sample("quantized"))
    document, binary = glb.json, bytearray(glb.bin[: glb.json["buffers"][0]["byteLength"]])
    add = lambda *array, **more: add_array(document, binary, *array, **more)
    x, z = np.meshgrid(np.arange(5), np.arange(5))
    places = np.zeros((25, 4), np.int16)
    places[:, 0], places[:, 2] = x.ravel() * 8000 - 16000, z.ravel() * 8000 - 16000
    corners = [[i, i + 5, i + 1, i + 1, i + 5, i + 6] for i in range(20) if i % 5 < 4]
    position = add(places, 5122, "VEC3", normalized=True, min=[-16000, 0, -16000], max=[16000, 0, 16000])
    document["bufferViews"][-1] |= {"byteStride": 8, "target": 34962}
    indices = add(np.array(corners, np.uint16).ravel(), 5123, "SCALAR")
    moved = add(np.array([[0, -0.05, 0], [0, 0.9, 0.3], [9, 0, 0]], np.float32), 5126, "VEC3")
    document["meshes"].append({"primitives": [{"attributes": {"POSITION": position}, "indices": indices}]})
    document["nodes"].append({"mesh": len(document["meshes"]) - 1, "name": "flock",
                              "extensions": {"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": moved}}}})  # fmt: skip
    document["scenes"][document.get("scene", 0)]["nodes"].append(len(document["nodes"]) - 1)
    character = next(n for n in glb.drawn() if "mesh" in glb.nodes[n])
    own = document["meshes"][document["nodes"][character]["mesh"]]["primitives"][0]["attributes"]
    compress(document, binary, position)
    compress(document, binary, own["POSITION"])
    size = max(view["byteLength"] for view in document["bufferViews"])
    document["buffers"].append({"byteLength": size, "extensions": {"EXT_meshopt_compression": {"fallback": True}}})
    document["extensionsRequired"] += ["EXT_meshopt_compression", "EXT_mesh_gpu_instancing"]
    document["extensionsUsed"] = list(document["extensionsRequired"])
    write_glb(path, document, bytes(binary))


def check_compressed(folder):
    """Instances, quantised numbers and compressed vertices of one file come through: a patch has the mean of what its
    instances see, and the file moves as before."""
    rig, out = os.path.join(folder, "flock.glb"), os.path.join(folder, "flock.ao.glb")
    compressed_flock(rig)
    vis, _, _, ambient = baked(folder, rig, "--fps", "3")
    with h5py.File(vis) as f:
        positions = f["frames/positions"][:][:, f["mesh/source_vertex"][:]]
    x, z = np.meshgrid(np.arange(5) * 8000 - 16000, np.arange(5) * 8000 - 16000)
    patch = np.stack([x.ravel(), 0 * x.ravel(), z.ravel()], 1) / 32767
    assert np.abs(positions[0, -25:] - patch - [9, 0, 0]).max() < 1e-5
    report = os.path.join(folder, "report.json")
    for kind in ("static", "play"):
        must(PACK, "export", vis, rig, "-o", out, "--as", kind, "--report", report)
        notes = json.load(open(report))["figures"].get("notes", [])
        assert any("EXT_mesh_gpu_instancing" in note for note in notes), notes
        only_appended(rig, out)
        glb, mean, found, first = Glb(out), ambient.mean(0), 0, 0
        for n in glb.drawn():
            if "mesh" not in glb.nodes[n]:
                continue
            (primitive,) = glb.json["meshes"][glb.nodes[n]["mesh"]]["primitives"]
            count = glb.json["accessors"][primitive["attributes"]["POSITION"]]["count"]
            times = 3 if "extensions" in glb.nodes[n] else 1
            wanted = mean[first : first + times * count].reshape(times, count)
            color = glb.accessor(primitive["attributes"]["COLOR_0"])
            assert np.abs(color[:, 0] - wanted.mean(0)).max() < 2e-6, (kind, n)
            assert times == 1 or np.ptp(wanted, 0).max() > 0.2  # the instances see unlike things
            first, found = first + times * count, found + times
        assert found == 5 and first == len(mean), (found, first)
        again = os.path.join(folder, "again.vis.h5")
        must(BAKE, "visibility", out, "-o", again, "--rays", "16", "--fps", "3")
        with h5py.File(again) as f:
            assert np.array_equal(f["frames/positions"][:][:, f["mesh/source_vertex"][:]], positions)


def check_color_morphs(folder):
    """Colours that morph targets of the file add are darkened: exactly by a mean, and with the error that is told
    where the occlusion follows the clips."""
    rig, out = os.path.join(folder, "colored.glb"), os.path.join(folder, "colored.ao.glb")
    colored_face(rig)
    vis, clips, times, ambient = baked(folder, rig, "--fps", "4")
    must(PACK, "export", vis, rig, "-o", out)
    weights = np.random.default_rng(5).uniform(0, 1, len(Glb(rig).json["meshes"][0]["primitives"][0]["targets"]))
    for (_, a, rows), (_, b, _) in zip(primitives(Glb(rig)), primitives(Glb(out))):
        wanted = shown(Glb(rig), a, weights, "COLOR_0") * ambient[:, rows].mean(0)[:, None]
        found = shown(Glb(out), b, weights, "COLOR_0")
        # Floats: 3e-7 was measured.
        assert np.abs(found[:, :3] - wanted).max() < 2e-6 and (found[:, 3] == 1).all()
    report = os.path.join(folder, "report.json")
    must(PACK, "export", vis, rig, "-o", out, "--as", "play", "--components", "0", "--report", report)
    before, after = Glb(rig), Glb(out)
    own = len(weights)
    for f, (clip, time) in enumerate(zip(clips, times)):
        for (_, a, rows), (node, b, _) in zip(primitives(before), primitives(after)):
            played = np.r_[weights, weights_at(after, clip, node, time)[own:]]
            base = before.accessor(a["attributes"]["COLOR_0"])
            added = shown(before, a, weights, "COLOR_0") - base
            mean = ambient[:, rows].mean(0)[:, None]
            assert np.abs(shown(after, b, played, "COLOR_0") - base * ambient[f, rows][:, None] - added * mean).max() < 3e-6
    errors = []
    for _, a, rows in primitives(before):
        spread = (ambient[:, rows] ** 2).mean(0) - ambient[:, rows].mean(0) ** 2
        for target in a["targets"][::2]:
            errors.append(np.sqrt((before.accessor(target["COLOR_0"]) ** 2 * spread[:, None]).mean()))
    note = next(n for n in json.load(open(report))["figures"]["notes"] if "morph targets of COLOR_0" in n)
    told = float(note.split("by up to ")[1].split()[0])
    assert abs(told - max(errors)) < 0.06 * max(errors) and told > 1e-3, (told, errors)


def check_reading_again(folder):
    """The occlusion of an export is no colour of the surface for those who bake the exported file."""
    rig, plain = os.path.join(folder, "colored.glb"), sample("face")
    out, albedo = os.path.join(folder, "again.glb"), os.path.join(folder, "albedo.vis.h5")
    bake = ["--rays", "16", "--fps", "1", "-o", albedo, "--quantity", "transfer", "--bounces", "1"]

    def albedo_of(path):
        must(BAKE, "visibility", path, *bake)
        with h5py.File(albedo) as f:
            return f["mesh/albedo"][:][f["mesh/source_vertex"][:]]

    vis, own = baked(folder, rig, "--fps", "1")[0], albedo_of(rig)
    assert np.ptp(own) > 0.1
    for options in (["--as", "static"], ["--no-color"], ["--as", "play", "--components", "2"]):
        must(PACK, "export", vis, rig, "-o", out, *options)
        assert np.array_equal(albedo_of(out), own), options
    # Without colours of its own the file has none afterwards, either.
    refused(1, "has no base colour", BAKE, "visibility", plain, *bake)
    must(PACK, "export", baked(folder, plain, "--fps", "1")[0], plain, "-o", out)
    refused(1, "has no base colour", BAKE, "visibility", out, *bake)


def check_static(folder):
    """Vertex attributes beside those of a file that has colours and coordinates of its own."""
    rig = os.path.join(folder, "viele Dinge \u00e4\u6f22.glb")
    many_things(rig)
    vis, _, _, ambient = baked(folder, rig, "--fps", "3")
    out, plain = os.path.join(folder, "aus gabe.glb"), os.path.join(folder, "plain.glb")
    must(PACK, "export", vis, rig, "-o", out)
    must(PACK, "export", vis, rig, "-o", plain, "--no-color")
    only_appended(rig, out)
    before, after, alone = Glb(rig), Glb(out), Glb(plain)
    mean = ambient.mean(0)
    meshes = set()
    for (n, a, rows), (m, b, _), (_, c, _) in zip(primitives(before), primitives(after), primitives(alone)):
        meshes.add(after.nodes[m]["mesh"])
        own = before.accessor(a["attributes"]["COLOR_0"]) if "COLOR_0" in a["attributes"] else np.ones((1, 4))
        assert np.abs(after.accessor(b["attributes"]["COLOR_0"]) - own * np.c_[mean[rows], mean[rows], mean[rows], np.ones(len(mean[rows]))]).max() < 2e-6
        assert np.abs(after.accessor(b["attributes"]["_OCCLUSION"])[:, 0] - mean[rows]).max() < 1e-6
        bent, custom = after.accessor(b["attributes"]["_BENT_NORMAL"]), after.accessor(b["attributes"]["_CUSTOM0"])
        assert np.abs(np.linalg.norm(bent, axis=1) - 1).max() < 1e-6 and np.array_equal(custom[:, :3], bent)
        first = after.json["asset"]["extras"]["penumbra_export"]["texcoord"]
        assert first == 3 and [k for k in b["attributes"] if k.startswith("TEXCOORD_")].__len__() == 5
        for name in a["attributes"]:
            assert name == "COLOR_0" or a["attributes"][name] == b["attributes"][name], name
        uv = np.c_[after.accessor(b["attributes"]["TEXCOORD_3"]), after.accessor(b["attributes"]["TEXCOORD_4"])]
        assert np.array_equal(uv, custom)
        assert set(c["attributes"]) - set(a["attributes"]) == {"_OCCLUSION"} and dict(a["attributes"]).items() <= c["attributes"].items()
    assert len(meshes) == len(list(primitives(after))) == 4, meshes  # the nodes that shared a mesh have one each
    assert after.json["nodes"][0]["extensions"]["ACME_unheard"] == before.json["nodes"][0]["extensions"]["ACME_unheard"]
    must(PACK, "export", vis, rig, "-o", out, "--as", "play", "--components", "2")
    for m in Glb(out).json["meshes"]:
        assert len({len(p.get("targets", [])) for p in m["primitives"]}) == 1
    return rig, vis


def check_table(folder, rig, vis, ambient_file):
    """The texel that a vertex finds has its value in every frame."""
    out = os.path.join(folder, "t.ao.png")
    must(PACK, "export", vis, rig, "-o", out)
    about = json.load(open(os.path.join(folder, "t.ao.json")))
    ambient = np.load(ambient_file)
    picture = np.asarray(Image.open(out))
    assert picture.shape == (about["height"], about["width"]) and about["frames"] == len(ambient)
    glb = Glb(os.path.join(folder, "t.ao.glb"))
    for _, p, rows in primitives(glb):
        uv = glb.accessor(p["attributes"]["TEXCOORD_%d" % about["texcoord"]])
        for f in range(about["frames"]):
            y = ((uv[:, 1] + f * about["rows_a_frame"] / about["height"]) * about["height"]).astype(int)
            x = (uv[:, 0] * about["width"]).astype(int)
            assert np.abs(picture[y, x] / 255 - ambient[f, rows]).max() <= 0.5001 / 255
    must(PACK, "export", vis, rig, "-o", os.path.join(folder, "b.png"), "--bent", "--rate", "2")
    bent = np.asarray(Image.open(os.path.join(folder, "b.png"))).astype(float)
    assert bent.shape[2] == 4
    lengths = np.linalg.norm(bent[..., :3] / 127.5 - 1, axis=2)
    assert np.abs(lengths[: about["rows_a_frame"]].ravel()[: about["vertices"]] - 1).max() < 0.02
    must(PACK, "export", vis, "-o", os.path.join(folder, "h.exr"))


def check_model(folder):
    """From an asset the model speaks, for any clip of the .glb, and it says about what the bake does."""
    rig = sample("capsule_man")
    vis, clips, times, ambient = baked(folder, rig, "--fps", "5")
    model, asset = os.path.join(folder, "m.model.h5"), os.path.join(folder, "m.pnb")
    must(FIT, "visibility", vis, "-o", model)
    must(PACK, "asset", model, "-o", asset)
    out = os.path.join(folder, "m.npy")
    must(PACK, "export", asset, rig, "-o", out, "--rate", "5")
    of_model = np.load(out)
    assert of_model.shape == ambient.shape and of_model.dtype == np.float32
    assert np.abs(of_model - ambient).mean() < 0.05, np.abs(of_model - ambient).mean()
    must(PACK, "export", asset, "-o", out)
    assert np.abs(np.load(out) - of_model).max() < 1e-5  # its own frames are the same ones
    must(PACK, "export", asset, rig, "-o", os.path.join(folder, "m.glb"), "--as", "play", "--clips", clips[0])
    refused(3, "no joint", PACK, "export", asset, sample("bend"), "-o", os.path.join(folder, "n.npy"))


def check_bounces(folder):
    """Light that bounces makes the ambient light brighter and coloured, and colours stay below 1."""
    rig, vis, out = sample("capsule_man"), os.path.join(folder, "t.vis.h5"), os.path.join(folder, "t.glb")
    must(BAKE, "visibility", rig, "-o", vis, "--rays", "16", "--fps", "1", "--quantity", "transfer", "--bounces", "1",
         "--albedo", ".8/.4/.2")  # fmt: skip
    must(PACK, "export", vis, rig, "-o", out, "--bounced")
    with h5py.File(vis) as f:
        # Irradiance of coefficient 0 under light of radiance 1, over pi.
        indirect = (f["visibility/indirect"][..., 0].astype(float) * np.sqrt(4 / np.pi)).mean(0)[f["mesh/source_vertex"][:]]
    glb = Glb(out)
    for _, primitive, rows in primitives(glb):
        color, bounced = (glb.accessor(primitive["attributes"][name]) for name in ("COLOR_0", "_BOUNCED"))
        ambient = glb.accessor(primitive["attributes"]["_OCCLUSION"])
        assert np.abs(color[:, :3] - bounced.clip(0, 1)).max() < 1e-6
        assert np.abs(bounced - ambient - indirect[rows]).max() < 1e-5 and indirect[:, 0].mean() > 0.04
    refused(1, "--bounced", PACK, "export", os.path.join(folder, "baked.vis.h5"), "-o", os.path.join(folder, "b.png"), "--bounced")


def check_bad_input(folder, rig, vis):
    """Nothing is written where the .glb is not the character."""
    out = os.path.join(folder, "no.glb")
    refused(3, "vertices", PACK, "export", vis, sample("bend"), "-o", out)
    refused(1, "needs the .glb", PACK, "export", vis, "-o", out)
    refused(1, "does not write", PACK, "export", vis, rig, "-o", out, "--as", "npy")
    refused(1, "no clip", PACK, "export", vis, rig, "-o", out, "--clips", "nowhere")
    done = os.path.join(folder, "done.glb")
    must(PACK, "export", vis, rig, "-o", done)
    refused(3, "is an export already", PACK, "export", vis, done, "-o", out)
    mine, again = os.path.join(folder, "mine.glb"), os.path.join(folder, "again.glb")
    glb = Glb(rig)
    glb.json["asset"]["extras"] = "mine"
    write_glb(mine, glb.json, glb.bin)
    must(PACK, "export", vis, mine, "-o", again)
    assert Glb(again).json["asset"]["extras"] == "mine"
    refused(3, "is an export already", PACK, "export", vis, again, "-o", out)
    # A bound that the mean meets leaves nothing to move, and no empty lists, which are no glTF.
    still = must(PACK, "export", vis, rig, "-o", again, "--as", "play", "--max-error", "1")
    assert not any("targets" in p for mesh in Glb(again).json["meshes"] for p in mesh["primitives"]), still
    glb = Glb(rig)
    glb.json["extensionsRequired"] = ["KHR_draco_mesh_compression"]
    draco = os.path.join(folder, "draco.glb")
    write_glb(draco, glb.json, glb.bin)
    refused(5, "decode it first", PACK, "export", vis, draco, "-o", out)
    data = open(rig, "rb").read()
    with open(draco, "wb") as file:
        file.write(data[: len(data) // 2])
    refused(3, "cut short", PACK, "export", vis, draco, "-o", out)
    assert not os.path.exists(out)


def check_other_order(folder, rig, vis, ambient_file):
    """The same vertices in another order are found by their places."""
    glb = Glb(rig)
    primitive = glb.json["meshes"][0]["primitives"][0]
    count = glb.json["accessors"][primitive["attributes"]["POSITION"]]["count"]
    order = np.random.default_rng(3).permutation(count)
    data = bytearray(glb.bin)
    for name, index in list(primitive["attributes"].items()):
        a = glb.json["accessors"][index]
        view = glb.json["bufferViews"][a["bufferView"]]
        size = {5120: 1, 5121: 1, 5122: 2, 5123: 2, 5126: 4}[a["componentType"]] * {"VEC2": 2, "VEC3": 3, "VEC4": 4}[a["type"]]
        start, stride = view.get("byteOffset", 0) + a.get("byteOffset", 0), view.get("byteStride", size)
        rows = [glb.bin[start + i * stride : start + i * stride + size] for i in range(count)]
        for i, old in enumerate(order):
            data[start + i * stride : start + i * stride + size] = rows[old]
    indices = glb.json["accessors"][primitive["indices"]]
    view = glb.json["bufferViews"][indices["bufferView"]]
    kind = {5121: np.uint8, 5123: np.uint16, 5125: np.uint32}[indices["componentType"]]
    start = view.get("byteOffset", 0) + indices.get("byteOffset", 0)
    corners = np.frombuffer(glb.bin, kind, indices["count"], start)
    inverse = np.argsort(order).astype(kind)
    data[start : start + corners.nbytes] = inverse[corners].tobytes()
    path = os.path.join(folder, "shuffled.glb")
    write_glb(path, glb.json, bytes(data))
    out = os.path.join(folder, "shuffled.npy")
    must(PACK, "export", vis, path, "-o", out)
    ambient, shuffled = np.load(ambient_file), np.load(out)
    assert np.abs(shuffled[:, :count] - ambient[:, order]).max() < 1e-6 and np.ptp(ambient) > 0.2


def check_distance(folder):
    """Occluders beyond the distance count no more, and what cannot know it refuses the bake."""
    whole, near = baked(folder, sample("capsule_man"), "--fps", "1")[3], baked(folder, sample("capsule_man"), "--fps", "1", "--distance", "0.15")
    far = baked(folder, sample("capsule_man"), "--fps", "1", "--distance", "1000")[3]
    assert (near[3] >= whole - 0.2).all() and near[3].mean() > whole.mean() + 0.02
    assert np.abs(far - whole).max() < 0.05
    vis = near[0]
    must(BAKE, "visibility", sample("capsule_man"), "-o", vis, "--rays", "32", "--fps", "1", "--distance", "0.15")
    assert "0.15" in next(line for line in must(BAKE, "info", vis).splitlines() if line.startswith("distance"))
    with h5py.File(vis) as f:
        assert abs(f.attrs["distance"] - 0.15) < 1e-6 and json.loads(f.attrs["provenance"])["options"]["distance"] == 0.15
    refused(5, "--distance", BAKE, "reference", vis, "--frame", "0", "-o", os.path.join(folder, "r.png"))
    refused(1, "--distance", BAKE, "visibility", sample("bend"), "-o", vis, "--distance", "1", "--local")


def main():
    with tempfile.TemporaryDirectory() as folder:
        check_play(folder)
        rig, vis = check_static(folder)
        npy = os.path.join(folder, "a.npy")
        must(PACK, "export", vis, "-o", npy)
        check_table(folder, rig, vis, npy)
        check_other_order(folder, rig, vis, npy)
        check_bad_input(folder, rig, vis)
        check_compressed(folder)
        check_color_morphs(folder)
        check_reading_again(folder)
        check_model(folder)
        check_bounces(folder)
        check_distance(folder)
        assert not [name for name in os.listdir(folder) if ".part" in name]
    print("exports are what was baked")


main()
