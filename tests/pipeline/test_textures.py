"""Textures of materials from the file to pictures: a tilted sheet with a picture of four colours, beside the reference.

usage: test_textures.py BIN
"""
import io
import json
import pathlib
import subprocess
import sys
import tempfile

import numpy as np
from PIL import Image

from programs import digest, good, run_tool

SCRIPTS = pathlib.Path(__file__).resolve().parent.parent.parent / "scripts"
sys.path.insert(0, str(SCRIPTS))
from samples.gltf import Gltf, primitive

VIEW = ["--size", "96x96", "--camera", "yaw=0,pitch=60", "--frame", 0]


def picture(pixels):
    out = io.BytesIO()
    Image.fromarray(np.asarray(pixels, np.uint8)).save(out, "PNG")
    return out.getvalue()


COLORS = picture(np.kron([[[250, 40, 40], [40, 250, 40]], [[40, 40, 250], [250, 250, 40]]], np.ones((16, 16, 1))))
# Rough 0.9 on the left and 0.3 on the right, metal below.
METAL = picture(np.kron([[[0, 230, 0], [0, 77, 0]], [[0, 230, 255], [0, 77, 255]]], np.ones((16, 16, 1))))
# Leans by 30 degrees to the left and to the right.
BUMPS = picture(np.kron([[[64, 128, 238], [191, 128, 238]]], np.ones((16, 16, 1))))
GLOW = picture(np.kron([[[255, 255, 255], [0, 0, 0]]], np.ones((16, 16, 1))))


def leaning(degrees):
    """A normal map that leans to the right."""
    turn = np.radians(degrees)
    return picture(np.full((16, 16, 3), np.round(127.5 + 127.5 * np.array([np.sin(turn), 0, np.cos(turn)]))))


def save_sheet(path, images, material, seam=False, n=12, beside=False, width=1, tangent=None):
    """Writes a rig of one joint: a sheet of depth 2 in n x n squares, whose picture lies mirrored behind a seam.

    All vertices have this tangent, if any.
    """
    g = Gltf()
    joint = g.node("root")
    skin = g.skin([joint])
    u, v = np.meshgrid(np.linspace(0, 1, n + 1), np.linspace(0, 1, n + 1))
    at = np.arange((n + 1) ** 2).reshape(n + 1, n + 1)
    a, b, c, d = at[:-1, :-1].ravel(), at[:-1, 1:].ravel(), at[1:, 1:].ravel(), at[1:, :-1].ravel()
    triangles = np.concatenate([np.stack([a, c, b], 1), np.stack([a, d, c], 1)])
    points, uv = np.stack([width * (2 * u.ravel() - 1), 0 * u.ravel(), 2 * v.ravel() - 1], 1), np.stack([u.ravel(), v.ravel()], 1)
    if seam:  # the right half has vertices of its own, at the same places
        right = points[triangles].mean(1)[:, 0] > 0
        triangles = np.where(right[:, None], triangles + len(points), triangles)
        points, uv = np.concatenate([points, points]), np.concatenate([uv, [1, 0] - uv * [1, -1]])
    joints, weights = np.zeros((len(points), 4), np.uint8), np.tile([1.0, 0, 0, 0], (len(points), 1))
    part = {**primitive(g, points, triangles, joints, weights), "material": 0}
    part["attributes"]["TEXCOORD_0"] = g.accessor(np.asarray(uv, np.float32))
    if tangent:
        part["attributes"]["TANGENT"] = g.accessor(np.tile(np.float32(tangent), (len(points), 1)))
    mesh = g.mesh(part)
    g.node("set", mesh=mesh, skin=skin)
    if beside:
        g.node("other", mesh=mesh)
    g.clip("turn", (joint, "rotation", [0, 1], [[0, 0, 0, 1], [0, 0, np.sin(0.1), np.cos(0.1)]]))
    g.json["materials"] = [material]
    g.json["images"], g.json["textures"] = [], []
    for number, image in enumerate(images):
        name = f"{path.stem}{number}.png"
        (path.parent / name).write_bytes(image)
        g.json["images"].append({"uri": name})
        g.json["textures"].append({"source": number})
    g.save(path)


def make_model(folder, name, *words):
    good("bake", "visibility", folder / f"{name}.glb", "-o", folder / f"{name}.vis.h5", "--fps", 2, "--rays", 64, *words)
    good("fit", "visibility", folder / f"{name}.vis.h5", "--model", "linear", "--features", "joint-angles",
         "-o", folder / f"{name}.model.h5")


def pack(folder, name, out, *words, code=0):
    result = run_tool("pack", "asset", folder / f"{name}.model.h5", "--light", folder / "l.light.h5", "-o", out, *words)
    assert result.returncode == code, (words, result.returncode, result.stderr)
    return result


def shot(folder, asset, *words):
    good("player", "render", asset, "-o", folder / "p.png", *VIEW, "--exposure", 0.8, *words)
    return np.asarray(Image.open(folder / "p.png").convert("RGBA"), float)


def truth(folder, name, light="uniform"):
    good("bake", "reference", folder / f"{name}.vis.h5", "--materials-of", folder / f"{name}.glb", "--light", light,
         "--samples", 256, "--aa", 4, "--exposure", 0.8, *VIEW, "-o", folder / "r.png")
    return np.asarray(Image.open(folder / "r.png").convert("RGBA"), float)


def compare(folder, name, asset, bound):
    """The mean difference of covered pixels from the reference, in 255ths of the display."""
    a, b = shot(folder, asset), truth(folder, name)
    both = (a[..., 3] > 250) & (b[..., 3] > 250)
    assert both.sum() > 1500, both.sum()
    error = abs(a - b)[both][:, :3].mean()
    assert error < bound, (name, error)
    return a


def check_scene(folder, material):
    """A sheet with two sides in a scene, beside the reference; with another material its pictures are gone."""
    save_sheet(folder / "both.glb", [COLORS], {**material, "doubleSided": True})
    make_model(folder, "both")
    good("fit", "brdf", "--analytic", "lambert", "-o", folder / "lambert.brdf.h5")
    pack(folder, "both", folder / "both.pnb", "--materials-of", folder / "both.glb", "--textures", "embed",
         "--brdf", folder / "lambert.brdf.h5")
    colorful = []
    for look in ({}, {"material": "lambert"}):
        scene = {"version": 1, "characters": [{"asset": "both.pnb", **look}]}
        (folder / "s.json").write_text(json.dumps(scene))
        view = ["--scene", folder / "s.json", "--size", "64x64", "--camera", "yaw=0,pitch=60", "--exposure", 0.8]
        good("player", "render", *view, "-o", folder / "p.png")
        good("bake", "reference", *view, "--samples", 64, "-o", folder / "r.png")
        a, b = (np.asarray(Image.open(folder / name).convert("RGBA"), float) for name in ("p.png", "r.png"))
        both = (a[..., 3] > 250) & (b[..., 3] > 250)
        assert both.sum() > 300 and abs(a - b)[both][:, :3].mean() < 5, (look, both.sum(), abs(a - b)[both].mean())
        colorful.append(np.ptp(b[both][:, :3], axis=1).mean())
    assert colorful[0] > 100 and colorful[1] < 5, colorful


def radiance(image):
    """The mean linear radiance of what is covered."""
    seen = image[image[..., 3] > 250][:, :3] / 255
    assert len(seen) > 300
    return np.where(seen <= 0.04045, seen / 12.92, ((seen + 0.055) / 1.055) ** 2.4).mean() / 0.8


def check_normals(folder):
    """White, rough and without shine: radiance is irradiance by pi."""
    white = {"pbrMetallicRoughness": {"metallicFactor": 0, "roughnessFactor": 1}, "normalTexture": {"index": 0},
             "extensions": {"KHR_materials_specular": {"specularFactor": 0}}}

    def made(degrees, **sheet):
        save_sheet(folder / "lean.glb", [leaning(degrees)], white, n=2, **sheet)
        make_model(folder, "lean")
        pack(folder, "lean", folder / "lean.pnb", "--materials-of", folder / "lean.glb", "--textures", "embed",
             "--light", folder / "sun.light.h5")

    sun = "directional:direction=%g/1/%g,irradiance=3.14159265"
    good("fit", "light", "--analytic", sun % (1, 0), "--factor", "--name", "sun", "-o", folder / "sun.light.h5")
    for degrees in (15, 30, 45, 60):
        made(degrees)
        free = (1 + np.cos(np.radians(degrees))) / 2  # the sky ends at the sheet
        for image in (shot(folder, folder / "lean.pnb"), truth(folder, "lean")):
            assert abs(radiance(image) - free) < 0.012, (degrees, radiance(image), free)
    # The sun stands at 45 degrees to the right. A sheet twice as wide as deep leans by the same angle.
    for degrees in (0, 45):
        made(degrees, width=2)
        for image in (shot(folder, folder / "lean.pnb", "--light", "sun"), truth(folder, "lean", sun % (1, 0))):
            assert abs(radiance(image) - np.cos(np.radians(45 - degrees))) < 0.015, (degrees, radiance(image))
    # A tangent of the file: the map's right is the back of the sheet.
    made(45, tangent=[0, 0, -1, 1])
    for toward, expected in ((0, np.sqrt(0.5)), (-1, 1), (1, 0)):
        seen = radiance(truth(folder, "lean", sun % (0, toward)))
        assert abs(seen - expected) < 0.015, (toward, seen)
    assert abs(radiance(shot(folder, folder / "lean.pnb", "--light", "sun")) - 0.5) < 0.015


def check_parts(folder, material):
    """Who reads the rig again for its pictures takes the parts that the bake took. A glow without a picture counts once.

    The sheet has two triangles; split_triangles makes more of them.
    """
    save_sheet(folder / "two.glb", [COLORS], {**material, "emissiveFactor": [0.1, 0.2, 0.05]}, n=1, beside=True)
    split = subprocess.run(["/usr/bin/python3", SCRIPTS / "rigs" / "split_triangles.py", folder / "two.glb", folder / "parts.glb",
                            "--share", "0.12"], check=True, capture_output=True, text=True).stdout
    assert split.startswith("2 triangles became ") and int(split.split()[3].rstrip(",")) >= 128, split
    make_model(folder, "parts", "--nodes", "set")
    pack(folder, "parts", folder / "parts.pnb", "--materials-of", folder / "parts.glb", "--textures", "embed")
    compare(folder, "parts", folder / "parts.pnb", 5)


def check_lost_pictures(folder, material):
    """A picture that cannot be read is named and left out, and the others are as they were. --strict refuses it."""
    save_sheet(folder / "lost.glb", [COLORS, METAL, BUMPS, GLOW], {**material, "emissiveFactor": [1, 1, 1]})
    make_model(folder, "lost")
    words = ["--materials-of", folder / "lost.glb", "--textures"]
    whole = pack(folder, "lost", folder / "whole.pnb", *words, "embed", "--strict").stderr
    assert whole == "", whole
    seen = shot(folder, folder / "whole.pnb")
    (folder / "lost0.png").write_bytes(COLORS[:60])  # the colours are cut short
    (folder / "lost3.png").unlink()  # that of glow and occlusion is gone
    for storage in ("embed", "link"):
        packed = pack(folder, "lost", folder / "less.pnb", *words, storage)
        told = packed.stderr
        assert "emissive (not read), base color (not read), metallic-roughness, normal, occl" in packed.stdout, packed.stdout
        assert told.count("warning") == 2 and "images[0]" in told and "images[3]" in told, told
        assert told.count("stand alone") == 2, told
        less = shot(folder, folder / "less.pnb")
        covered = (less[..., 3] > 250) & (seen[..., 3] > 250)
        # Neither colours nor a glow, but bumps and shine.
        assert np.ptp(less[covered][:, :3], axis=1).max() < 4 and np.ptp(less[covered][:, 0]) > 20
    refused = pack(folder, "lost", folder / "refused.pnb", *words, "embed", "--strict", code=5)
    assert "images[0]" in refused.stderr and not (folder / "refused.pnb").exists(), refused.stderr
    # The reference does the same.
    words = ["bake", "reference", folder / "lost.vis.h5", "--materials-of", folder / "lost.glb", "--samples", 4, *VIEW]
    drawn = run_tool(*words, "-o", folder / "r.png")
    assert drawn.returncode == 0 and drawn.stderr.count("stand alone") == 2, drawn.stderr
    refused = run_tool(*words, "--strict", "-o", folder / "refused.png")
    assert refused.returncode == 5 and "images[0]" in refused.stderr, refused.stderr
    assert not (folder / "refused.png").exists()


def check(folder):
    good("fit", "light", "--analytic", "uniform", "-o", folder / "l.light.h5")
    base = {"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}, "metallicFactor": 0, "roughnessFactor": 0.6}}
    save_sheet(folder / "flat.glb", [COLORS], base)
    make_model(folder, "flat")
    rig = ["--materials-of", folder / "flat.glb"]
    pack(folder, "flat", folder / "none.pnb", *rig)
    pack(folder, "flat", folder / "none2.pnb", *rig, "--textures", "none")
    embedded = pack(folder, "flat", folder / "embed.pnb", *rig, "--textures", "embed")
    pack(folder, "flat", folder / "link.pnb", *rig, "--textures", "link")
    assert "base color" in embedded.stdout and "textures" in embedded.stdout, embedded.stdout
    assert digest(folder / "none.pnb") == digest(folder / "none2.pnb")
    sizes = {name: (folder / f"{name}.pnb").stat().st_size for name in ("none", "link", "embed")}
    assert sizes["none"] < sizes["link"] < sizes["embed"], sizes
    # Pictures are those of the reference, wherever the file is.
    seen = compare(folder, "flat", folder / "embed.pnb", 3)
    assert np.array_equal(seen, shot(folder, folder / "link.pnb")), "linked pictures differ"
    colors = {tuple((c > 128).astype(int)) for c in seen[seen[..., 3] > 250][:, :3]}
    assert {(1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 1, 0)} <= colors, colors
    plain = shot(folder, folder / "embed.pnb", "--textures", "off")
    assert np.ptp(plain[plain[..., 3] > 250][:, :3], axis=1).max() < 4, "pictures are off, and there is colour"
    # A seam, and all roles at once.
    save_sheet(folder / "seam.glb", [COLORS], base, seam=True)
    make_model(folder, "seam")
    pack(folder, "seam", folder / "seam.pnb", "--materials-of", folder / "seam.glb", "--textures", "embed")
    assert abs(compare(folder, "seam", folder / "seam.pnb", 3) - seen).mean() > 5
    every = {"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}, "metallicRoughnessTexture": {"index": 1}},
             "normalTexture": {"index": 2}, "emissiveTexture": {"index": 3}, "emissiveFactor": [0.2, 0.1, 0],
             "occlusionTexture": {"index": 3, "strength": 0.5}}
    save_sheet(folder / "every.glb", [COLORS, METAL, BUMPS, GLOW], every)
    make_model(folder, "every")
    pack(folder, "every", folder / "every.pnb", "--materials-of", folder / "every.glb", "--textures", "embed")
    compare(folder, "every", folder / "every.pnb", 14)
    check_normals(folder)
    check_scene(folder, base)
    check_parts(folder, base)
    check_lost_pictures(folder, every)
    # What is wrong is named, and nothing is written.
    save_sheet(folder / "other.glb", [COLORS], base, n=8)
    refused = pack(folder, "flat", folder / "x.pnb", "--materials-of", folder / "other.glb", "--textures", "embed", code=3)
    assert "mesh" in refused.stderr and not (folder / "x.pnb").exists(), refused.stderr
    (folder / "flat0.png").unlink()
    lost = run_tool("player", "render", folder / "link.pnb", "-o", folder / "x.png", *VIEW)
    assert lost.returncode == 2 and "flat0.png" in lost.stderr, lost.stderr


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as temporary:
        check(pathlib.Path(temporary))
