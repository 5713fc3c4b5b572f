"""Alpha of materials from the file to pictures: a floor below a card, of which half the light passes.

usage: test_alpha.py BIN
"""
import json
import os
import pathlib
import sys
import tempfile

import h5py
import numpy as np
from PIL import Image

from programs import digest, good, run_tool

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent.parent / "scripts"))
from samples.gltf import Gltf, primitive

WORDS = ["--fps", 2, "--rays", 256]


def grid(side, n, height):
    """Points [(n + 1)^2, 3] and triangles of a square of side 2 `side`, facing up."""
    u, v = np.meshgrid(np.linspace(-side, side, n + 1), np.linspace(-side, side, n + 1))
    points = np.stack([u.ravel(), np.full(u.size, height), v.ravel()], 1)
    at = np.arange((n + 1) * (n + 1)).reshape(n + 1, n + 1)
    a, b, c, d = at[:-1, :-1].ravel(), at[:-1, 1:].ravel(), at[1:, 1:].ravel(), at[1:, :-1].ravel()
    return points, np.concatenate([np.stack([a, c, b], 1), np.stack([a, d, c], 1)])


def save_card(path, **material):
    """Writes a rig of one joint that turns: a floor at 0 and a card at .2 with this material."""
    g = Gltf()
    joint = g.node("root")
    skin = g.skin([joint])

    def part(number, n, height):
        points, triangles = grid(1, n, height)
        joints, weights = np.zeros((len(points), 4), np.uint8), np.tile([1.0, 0, 0, 0], (len(points), 1))
        return {**primitive(g, points, triangles, joints, weights), "material": number}

    parts = part(0, 12, 0), part(1, 8, 0.2)
    texture = g.accessor(np.zeros((81, 2), np.float32))
    parts[1]["attributes"]["TEXCOORD_0"] = texture
    g.node("set", mesh=g.mesh(*parts), skin=skin)
    turned = [0, np.sin(0.35), 0, np.cos(0.35)]
    g.clip("turn", (joint, "rotation", [0, 1], [[0, 0, 0, 1], turned]))
    g.json["materials"] = [{"name": "floor"}, {"name": "card", **material}]
    g.json["images"] = [{"uri": "none.png"}]
    g.json["textures"] = [{"source": 0}]
    g.save(path)


def faded(alpha):
    return {"alphaMode": "BLEND", "pbrMetallicRoughness": {"baseColorFactor": [1, 1, 1, alpha]}}


def ambient(path):
    """Returns E of the floor's middle in the first frame, and the number of vertices."""
    with h5py.File(path) as f:
        b, n = f["visibility/coefficients"][0, :, 1:4], f["frames/normals"][0]
        rest = f["mesh/rest_positions"][:]
    e = (b * np.stack([-n[:, 1], n[:, 2], -n[:, 0]], 1)).sum(1) / (np.pi * np.sqrt(3 / (4 * np.pi)))
    return e[(abs(rest[:, 1]) < 1e-6) & (abs(rest[:, [0, 2]]).max(1) < 0.5)].mean(), len(rest)


def bake(path, out, *words, code=0):
    result = run_tool("bake", "visibility", path, "-o", out, *WORDS, *words)
    assert result.returncode == code, (path, words, result.returncode, result.stderr)
    return result


def check_light(folder):
    """E runs from that of a solid card to 1 with alpha, and the bytes depend on neither threads nor shards."""
    seen = []
    for alpha in (1, 0.5, 0):
        save_card(folder / f"{alpha}.glb", **faded(alpha))
        bake(folder / f"{alpha}.glb", folder / f"{alpha}.vis.h5")
        seen.append(ambient(folder / f"{alpha}.vis.h5")[0])
    assert seen[0] < 0.07 and abs(seen[1] - (1 + seen[0]) / 2) < 0.02 and seen[2] > 0.999, seen
    with h5py.File(folder / "1.vis.h5") as f:
        assert "opacity_triangles" not in f["mesh"]  # nothing of it is clear
    for threads in (1, 3):
        bake(folder / "0.5.glb", folder / "t.vis.h5", "--threads", threads)
        assert digest(folder / "t.vis.h5") == digest(folder / "0.5.vis.h5"), threads
    for number, frames in enumerate(("0:1", "1:3")):
        bake(folder / "0.5.glb", folder / f"shard{number}.vis.h5", "--frames", frames)
    good("bake", "merge", folder / "shard0.vis.h5", folder / "shard1.vis.h5", "-o", folder / "m.vis.h5")
    with h5py.File(folder / "m.vis.h5") as merged, h5py.File(folder / "0.5.vis.h5") as whole:
        for name in ("visibility/coefficients", "mesh/opacity_values", "mesh/opacity_triangles"):
            assert np.array_equal(merged[name][:], whole[name][:]), name


def check_sides(folder):
    """A double-sided card has backs, which --one-sided leaves out and --two-sided gives the floor, too."""
    save_card(folder / "sides.glb", doubleSided=True)
    for words, vertices in ([], 169 + 2 * 81), (["--one-sided"], 169 + 81), (["--two-sided"], 2 * (169 + 81)):
        bake(folder / "sides.glb", folder / "sides.vis.h5", *words)
        assert ambient(folder / "sides.vis.h5")[1] == vertices, words
    bake(folder / "sides.glb", folder / "x.vis.h5", "--one-sided", "--two-sided", code=1)
    # The parts stop the same light, so fields fit the bake whichever sides it has.
    good("bake", "fields", folder / "sides.glb", "--rays", 32, "--cells", 4, "-o", folder / "x.fields.h5")
    with h5py.File(folder / "x.fields.h5") as f:
        sums = {f.attrs["mesh_sha256"]}
    good("bake", "fields", folder / "sides.glb", "--one-sided", "--rays", 32, "--cells", 4, "-o", folder / "y.fields.h5")
    with h5py.File(folder / "y.fields.h5") as f:
        sums.add(f.attrs["mesh_sha256"])
    assert len(sums) == 1, sums


def check_notes(folder):
    """A picture that cannot be read is told, and refused with --strict."""
    texture = {"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}
    save_card(folder / "lost.glb", alphaMode="MASK", **texture)
    told = bake(folder / "lost.glb", folder / "lost.vis.h5", "--report", folder / "r.json").stderr
    assert "none.png" in told and "alpha" in told, told
    assert "none.png" in json.dumps(json.loads((folder / "r.json").read_text())), "not in the report"
    os.remove(folder / "lost.vis.h5")
    assert "none.png" in bake(folder / "lost.glb", folder / "lost.vis.h5", "--strict", code=5).stderr
    assert not (folder / "lost.vis.h5").exists()


def check_pictures(folder):
    """A sun through the half clear card lights half of the floor in pictures and in the reference."""
    good("fit", "brdf", "--analytic", "lambert", "-o", folder / "b.brdf.h5")
    good("fit", "light", "--analytic", "sky:elevation=80,turbidity=3", "--lobes", 3, "-o", folder / "s.light.h5")
    means = {}
    for alpha in (1, 0.5, 0):
        good("fit", "visibility", folder / f"{alpha}.vis.h5", "--model", "linear", "--features",
             "joint-angles", "-o", folder / "x.model.h5")
        good("pack", "asset", folder / "x.model.h5", "--brdf", folder / "b.brdf.h5", "--light", folder / "s.light.h5",
             "-o", folder / "x.pnb")
        view = ["--size", "96x96", "--camera", "yaw=0,pitch=-60", "--exposure", 1]
        good("player", "render", folder / "x.pnb", "-o", folder / "p.png", "--frame", 0, *view)
        means[alpha] = np.asarray(Image.open(folder / "p.png").convert("RGB"), float).mean()
        good("bake", "reference", folder / f"{alpha}.vis.h5", "--frame", 0, "--channel", "ao", "--samples", 16,
             *view[:4], "-o", folder / "r.png")
        means["reference", alpha] = np.asarray(Image.open(folder / "r.png").convert("RGB"), float).mean()
    for key in (lambda a: a), (lambda a: ("reference", a)):
        assert means[key(1)] < means[key(0.5)] < means[key(0)], means


def check_backs_seen(folder):
    """From below, the floor has no back and lets the eye through to the back of the card, in all pictures alike."""
    bake(folder / "sides.glb", folder / "sides.vis.h5")
    good("fit", "visibility", folder / "sides.vis.h5", "--model", "linear", "--features", "joint-angles", "-o",
         folder / "s.model.h5")
    good("pack", "asset", folder / "s.model.h5", "--brdf", folder / "b.brdf.h5", "--light", folder / "s.light.h5", "-o",
         folder / "s.pnb")
    camera = "yaw=0,pitch=-70"
    scene = {"version": 1, "characters": [{"asset": "s.pnb"}], "camera": camera}
    (folder / "scene.json").write_text(json.dumps(scene))
    view = ["--size", "96x96", "--channel", "normals"]
    pictures = {"player": ["player", "render", folder / "s.pnb", "--frame", 0, "--camera", camera],
                "reference": ["bake", "reference", folder / "sides.vis.h5", "--frame", 0, "--samples", 4,
                              "--camera", camera],
                "scene": ["bake", "reference", "--scene", folder / "scene.json", "--samples", 4]}
    for name, command in pictures.items():
        good(*command, *view, "-o", folder / "n.png")
        picture = np.asarray(Image.open(folder / "n.png").convert("RGBA"), float)
        # A normal that points down has the code 0 in green, one that points up 255.
        up = picture[..., 1][picture[..., 3] == 255]
        assert len(up) > 1000 and up.max() < 64, (name, len(up), up.max())


with tempfile.TemporaryDirectory() as name:
    for check in (check_light, check_sides, check_notes, check_pictures, check_backs_seen):
        check(pathlib.Path(name))
