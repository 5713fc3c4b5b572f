"""penumbra-bake as a user runs it: whole files or none, one-line errors with the right exit code, signals.

usage: test_bake.py BIN
"""
import json
import os
import signal
import struct
import subprocess
import sys
import tempfile
import time

import h5py
import numpy as np

import processor_time

BIN = sys.argv[1]
BAKE = os.path.join(BIN, "penumbra-bake")
SAMPLES = os.path.join(BIN, "..", "samples")
MAN = os.path.join(SAMPLES, "capsule_man.glb")


def run(*words, **more):
    return subprocess.run([BAKE, *map(str, words)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, **more)


def bake(out, *words, rig=MAN):
    result = run("visibility", rig, "-o", out, *words)
    assert result.returncode == 0, (words, result.stderr)
    return result


def read_glb(path):
    with open(path, "rb") as f:
        data = f.read()
    size = struct.unpack_from("<I", data, 12)[0]
    return json.loads(data[20 : 20 + size]), data[20 + size + 8 :]


def write_glb(path, scene, binary):
    text = json.dumps(scene).encode()
    text += b" " * (-len(text) % 4)
    binary += b"\0" * (-len(binary) % 4)
    with open(path, "wb") as f:
        f.write(struct.pack("<4sIIII", b"glTF", 2, 28 + len(text) + len(binary), len(text), 0x4E4F534A))
        f.write(text + struct.pack("<II", len(binary), 0x004E4942) + binary)


def write_triangles(path, positions, indices):
    """Makes a rigid mesh without animation."""
    binary = np.asarray(positions, "<f4").tobytes() + np.asarray(indices, "<u2").tobytes()
    low, high = np.min(positions, 0).tolist(), np.max(positions, 0).tolist()
    views = [
        {"buffer": 0, "byteOffset": 0, "byteLength": 12 * len(positions)},
        {"buffer": 0, "byteOffset": 12 * len(positions), "byteLength": 2 * len(indices)},
    ]
    accessors = [
        {"bufferView": 0, "componentType": 5126, "count": len(positions), "type": "VEC3", "min": low, "max": high},
        {"bufferView": 1, "componentType": 5123, "count": len(indices), "type": "SCALAR"},
    ]
    scene = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"name": "thing", "mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "buffers": [{"byteLength": len(binary)}],
        "bufferViews": views,
        "accessors": accessors,
    }
    write_glb(path, scene, binary)


def check_file(folder):
    out = os.path.join(folder, "man.vis.h5")
    words = ["--clips", "walk,wave", "--fps", "2", "--rays", "256", "--order", "4"]
    report, depfile = os.path.join(folder, "report.json"), os.path.join(folder, "man.d")
    bake(out, *words, "--report", report, "--depfile", depfile)
    with h5py.File(out) as f:
        assert f.attrs["format"] == "penumbra.visibility" and f.attrs["quantity"] == "hemisphere_visibility"
        assert f.attrs["sh_convention"] == "real-orthonormal-cs" and f.attrs["sh_order"] == 4
        assert f.attrs["rays"] == 256 and f.attrs["frame"] == "model"
        provenance = json.loads(f.attrs["provenance"])
        assert provenance["inputs"][0]["name"] == "capsule_man.glb", provenance
        b, n = f["visibility/coefficients"][:], f["frames/normals"][:]
        assert b.shape == (14, n.shape[1], 16)
        # Ambient visibility comes from band 1: y_1 = sqrt(3/4pi) (-y, z, -x), so the integral of V s ds = sqrt(4pi/3)
        # (-b3, -b1, b2).
        moment = np.sqrt(4 * np.pi / 3) * np.stack([-b[..., 3], -b[..., 1], b[..., 2]], -1)
        ambient = (moment * n).sum(-1) / np.pi
        # With 256 rays it is 1 to within the noise of the set, about 1%.
        assert ambient.min() > -1e-6 and 0.98 < ambient.max() < 1.02, (ambient.min(), ambient.max())
        assert 0.5 < ambient.mean() < 0.95, ambient.mean()
    figures = json.load(open(report))["figures"]
    assert figures["frames"] == 14 and figures["rays_traced"] > 0 and figures["bytes"] == os.path.getsize(out), figures
    rule = open(depfile).read()
    assert rule.startswith(out + ":") and "capsule_man.glb" in rule, rule
    first = open(out, "rb").read()
    for threads in ("1", "2", "8"):
        bake(out, *words, "--threads", threads)
        assert open(out, "rb").read() == first, f"{threads} threads give other bytes"
    return out


def check_dry_run(folder):
    out = os.path.join(folder, "dry.vis.h5")
    text = bake(out, "--fps", "2", "--rays", "256", "--dry-run").stdout
    assert "frames" in text and "vertices" in text and "Mray" in text and "MB" in text, text
    assert not os.path.exists(out)
    for words, name in (
        ([MAN, "--seed", "-1"], "--seed must be 0..9223372036854775807, not -1"),
        ([MAN, "--clips", "moonwalk"], "moonwalk"),
        ([MAN, MAN], "given twice"),
    ):
        result = run("visibility", *words, "-o", out, "--dry-run")
        assert result.returncode == 1 and name in result.stderr, (words, result)
    # A list takes one word, so that the rig may follow it.
    few = ["-o", out, "--dry-run", "--fps", "2", "--rays", "16"]
    assert run("visibility", "--clips", "walk", MAN, *few).returncode == 0
    lists = (["--clips", "walk,squat"], ["--clips", "walk", "--clips", "squat"])
    plans = {run("visibility", *words, MAN, *few).stdout.split("\n")[0] for words in lists}
    assert len(plans) == 1 and "frames" in plans.pop(), plans  # the third line is measured


def check_failures(folder):
    """Each error has its exit code and one line on stderr that names what is wrong. No file is left, and an old
    output stays."""
    place = lambda name: os.path.join(folder, name)
    open(place("empty.glb"), "wb").close()
    whole = open(MAN, "rb").read()
    for keep in (10, 20, 1000, len(whole) // 2, len(whole) - 1):
        open(place(f"cut{keep}.glb"), "wb").write(whole[:keep])
    write_triangles(place("one_vertex.glb"), [[0, 0, 0]], [0, 0, 0])
    write_triangles(place("no_area.glb"), [[0, 0, 0], [1, 0, 0], [2, 0, 0]], [0, 1, 2])
    scene, binary = read_glb(MAN)
    scene["animations"][0]["channels"] = scene["animations"][0]["samplers"] = []
    write_glb(place("no_keys.glb"), scene, binary)

    cases = [
        ([place("empty.glb")], 3, "empty.glb"),
        *[([place(f"cut{keep}.glb")], 3, f"cut{keep}.glb") for keep in (10, 20, 1000, len(whole) // 2, len(whole) - 1)],
        ([place("one_vertex.glb")], 3, "one_vertex.glb"),
        ([place("no_area.glb")], 3, "no_area.glb"),
        ([place("missing.glb")], 2, "missing.glb"),
        ([folder], 2, folder),
        ([MAN, "--clips", "moonwalk"], 1, "moonwalk"),
        ([MAN, "--clips", "walk,walk"], 1, "walk"),
        ([MAN, "--clips", ","], 1, "--clips"),
        ([MAN, "--clips", "walk,"], 1, "--clips"),
        ([MAN, "--clips", ""], 1, "--clips"),
        ([MAN, os.path.join(SAMPLES, ".", "capsule_man.glb")], 1, "given twice"),
        ([MAN, "--frames", "0:100000"], 1, "--frames"),
        ([MAN, "--frames", "3:3"], 1, "--frames"),
        ([MAN, "--order", "9"], 1, "--order"),
        ([MAN, "--rays", "3"], 1, "--rays"),
        ([MAN, "--bias", "nan"], 1, "--bias"),
        ([MAN, "--fps", "-1"], 1, "--fps"),
        ([MAN, "--precision", "f64"], 1, "--precision"),
        ([MAN, "--two-faced"], 1, "--two-faced"),
        ([MAN, "--threads", "0"], 1, "--threads"),
        ([], 1, "rig"),
    ]
    out = place("out.vis.h5")
    result = run("visibility", place("no_keys.glb"), "-o", out, "--rays", "16")
    assert result.returncode == 0 and "no_keys.glb: clip 'wave': has no channel" in result.stderr, result.stderr
    os.remove(out)
    before = set(os.listdir(folder))
    for words, code, name in cases:
        for old in (None, b"an old file"):
            if old:
                open(out, "wb").write(old)
            result = run("visibility", *words, "-o", out, "--rays" if "--rays" not in words else "--seed", "16")
            assert result.returncode == code, (words, result.returncode, result.stderr)
            lines = result.stderr.splitlines()
            assert len(lines) == 1 and name in lines[0], (words, result.stderr)
            assert result.stdout == "", (words, result.stdout)
            if old:
                assert open(out, "rb").read() == old, words
                os.remove(out)
            assert set(os.listdir(folder)) == before, (words, set(os.listdir(folder)) - before)
    for target, code in ((place("nowhere/out.vis.h5"), 2), (place("empty.glb") + "/out.vis.h5", 2), ("/proc/out.vis.h5", 2)):
        result = run("visibility", MAN, "-o", target, "--rays", "16")
        assert result.returncode == code and len(result.stderr.splitlines()) == 1, (target, result)
    open(out, "wb").write(b"an old file")
    result = run("visibility", MAN, "-o", out, "--no-clobber")
    assert result.returncode == 2 and open(out, "rb").read() == b"an old file", result
    os.remove(out)


def check_full_disk(folder):
    """A file size limit with SIGXFSZ ignored makes writes fail as a full disk does."""
    import resource

    def limit():
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (300_000, 300_000))

    out = os.path.join(folder, "full.vis.h5")
    words = ["visibility", MAN, "-o", out, "--fps", "4", "--rays", "16"]
    result = run(*words, preexec_fn=limit, restore_signals=False)
    assert result.returncode == 2, result
    assert len(result.stderr.splitlines()) == 1, result.stderr
    assert not [name for name in os.listdir(folder) if name.startswith("full")], os.listdir(folder)


def check_signals(folder):
    for number in (signal.SIGTERM, signal.SIGINT):
        out = os.path.join(folder, "stopped.vis.h5")
        process = subprocess.Popen(
            [BAKE, "visibility", MAN, "-o", out, "--rays", "65536", "--fps", "10"],
            stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
        )
        while not any(name.startswith("stopped") for name in os.listdir(folder)) and process.poll() is None:
            time.sleep(0.01)
        while processor_time.of_running(process.pid) < 0.3 and process.poll() is None:  # it traces
            time.sleep(0.01)
        errors, seconds = processor_time.stop(process, number)
        assert process.returncode == 4 and len(errors.splitlines()) == 1, (process.returncode, errors)
        assert seconds < 1, seconds
        assert not [name for name in os.listdir(folder) if name.startswith("stopped")], os.listdir(folder)
        print(f"signal {int(number)}: stopped after {seconds:.2f} s")


def check_notes(folder):
    """A deviation of a reader from its file is one warning line, is listed by --report and info, and is an error with
    --strict."""
    place = lambda name: os.path.join(folder, name)
    scene, binary = read_glb(MAN)
    scene["materials"] = [{"name": "lens", "extensions": {"KHR_materials_transmission": {"transmissionFactor": 1}}}]
    for mesh in scene["meshes"]:
        for primitive in mesh["primitives"]:
            primitive["material"] = 0
    rig, out, report = place("lens.glb"), place("lens.vis.h5"), place("report.json")
    write_glb(rig, scene, binary)
    text = "KHR_materials_transmission: material 'lens': it stops light as if it was opaque"
    strict = run("visibility", rig, "-o", out, "--rays", "16", "--fps", "1", "--strict")
    assert strict.returncode == 5 and text in strict.stderr and not os.path.exists(out), strict
    result = run("visibility", rig, "-o", out, "--rays", "16", "--fps", "1", "-q", "--report", report)
    assert result.returncode == 0 and len(result.stderr.splitlines()) == 1 and text in result.stderr, result
    notes = json.load(open(report))["figures"]["notes"]
    assert len(notes) == 1 and "lens.glb: node '" in notes[0] and notes[0].endswith(text), notes
    assert text in run("info", out).stdout
    about = run("info", rig)
    assert text in about.stdout and scene["animations"][0]["name"] in about.stdout, about
    for verb, name in (("fields", "x.fields.h5"), ("poses", "x.poses.h5")):
        more = ["--choose", "2"] if verb == "poses" else ["--rays", "16", "--cells", "4"]
        assert run(verb, rig, "-o", place(name), "--strict", *more).returncode == 5 and not os.path.exists(place(name))


def check_reference(folder, baked):
    place = lambda name: os.path.join(folder, name)
    words = ["reference", baked, "--size", "32x24", "--samples", "16"]
    for channel in ("shaded", "ao", "normals"):
        for extension in ("png", "exr"):
            out = place(f"{channel}.{extension}")
            result = run(*words, "--frame", 3, "--channel", channel, "-o", out)
            assert result.returncode == 0, result.stderr
            magic = open(out, "rb").read(4)
            assert magic == (b"\x89PNG" if extension == "png" else b"\x76\x2f\x31\x01"), magic
    same = [open(place("shaded.png"), "rb").read()]
    for threads in (1, 8):
        assert run(*words, "--frame", 3, "-o", place("again.png"), "--threads", threads).returncode == 0
        same.append(open(place("again.png"), "rb").read())
    assert same[0] == same[1] == same[2]
    os.remove(place("again.png"))
    cases = [
        (["--frame", 14], 1, "--frame"),
        (["--frame", -1], 1, "--frame must be 0.."),
        (["--frame", 0, "--brdf", "velvet"], 1, "velvet"),
        (["--frame", 0, "--brdf", "ggx:alpha=7"], 1, "alpha"),
        (["--frame", 0, "--camera", "zoom=3"], 1, "zoom"),
        (["--frame", 0, "--size", "0x7"], 1, "--size"),
        (["--frame", 0, "--aa", "0"], 1, "--aa"),
        (["--frame", 0, "--light", place("missing.exr")], 2, "missing.exr"),
        (["--frame", 0, "--light", MAN], 3, "capsule_man.glb"),
        (["--frame", 0, "--light-order", 4], 1, "--light-order"),
        (["--frame", 0, "--light", MAN, "--light-order", 9], 1, "--light-order must be"),
        (["--frame", 0, "--exposure", "0"], 1, "--exposure"),
        (["--frame", 0, "--background", "1/2"], 1, "--background"),
    ]
    for more, code, name in cases:
        result = run("reference", baked, *more, "-o", place("bad.png"))
        assert result.returncode == code and len(result.stderr.splitlines()) == 1, (more, result)
        assert name in result.stderr, (more, result.stderr)
        assert not os.path.exists(place("bad.png")), more
    result = run("reference", MAN, "--frame", 0, "-o", place("bad.png"))
    assert result.returncode == 3 and "capsule_man.glb" in result.stderr, result
    assert run("reference", baked, "--frame", 0, "-o", place("bad.jpg")).returncode == 1


def main():
    for check in (check_dry_run, check_failures, check_notes, check_full_disk, check_signals):
        with tempfile.TemporaryDirectory() as folder:
            check(folder)
            print(f"{check.__name__}: ok")
    with tempfile.TemporaryDirectory() as folder:
        baked = check_file(folder)
        print("check_file: ok")
        check_reference(folder, baked)
        print("check_reference: ok")


main()
