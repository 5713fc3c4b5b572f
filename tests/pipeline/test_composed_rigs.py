"""Composed models of odd rigs: one bone, 200 bones, bones that scale or mirror, flat parts; damaged fields are refused.

usage: test_composed_rigs.py BIN
"""
import json
import os
import pathlib
import sys
import tempfile

import h5py
import numpy as np

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
sys.path.insert(0, str(ROOT / "scripts"))
from samples.gltf import Gltf, primitive  # noqa: E402
from samples.shapes import translation_to, tube, turn  # noqa: E402

from programs import must, refused

BIN = sys.argv[1]
BAKE, FIT, PACK, PLAYER = (os.path.join(BIN, "penumbra-" + name) for name in ("bake", "fit", "pack", "player"))


def chain(path, bones, rings, scale=None, mirrored=None):
    """A tube along y of `bones` joints that curls up. One joint may grow and shrink, and one may mirror x."""
    g = Gltf()
    points, triangles = tube(1.0, 0.02 if bones > 20 else 0.08, rings, 8)
    length = 1 / bones
    joints, parent = [], None
    for b in range(bones):
        fields = {"translation": [0, length if b else 0, 0]}
        if b == mirrored:
            fields["scale"] = [-1, 1, 1]
        parent = g.node(f"bone{b}", parent, **fields)
        joints.append(parent)
    bind = translation_to([[0, length * b, 0] for b in range(bones)])
    if mirrored is not None:
        for b in range(mirrored, bones):  # rest is where the joints stand, mirrored
            bind[b] = np.diag([-1, 1, 1, 1]) @ bind[b]
    at = np.minimum((points[:, 1] / length).astype(int), bones - 1)
    bone = np.zeros((len(points), 4), np.uint8)
    bone[:, 0] = at
    weights = np.zeros((len(points), 4), np.float32)
    weights[:, 0] = 1
    skin = g.skin(joints, bind)
    g.node("tube", mesh=g.mesh(primitive(g, points, triangles, bone, weights)), skin=skin)
    t = np.linspace(0, 1, 9)
    for name, most in (("curl", 250), ("bend", 120)):
        wave = np.sin(np.pi * t)
        channels = [(joint, "rotation", t, turn("z", most / bones * wave)) for joint in joints]
        if scale is not None:
            channels.append((joints[scale], "scale", t, 1 + 0.5 * np.stack([wave] * 3, 1)))
        g.clip(name, *channels)
    g.save(path)


def figures(folder, name, features):
    """Bakes, fits, packs and checks a rig as a user does. Returns the figures of the fit and of the check."""
    rig, vis, fields, model, asset, report = (
        os.path.join(folder, name + end) for end in (".glb", ".vis.h5", ".fields.h5", ".model.h5", ".pnb", ".json"))
    must(BAKE, "visibility", rig, "-o", vis, "--fps", 8, "--rays", 64, "--local")
    must(BAKE, "fields", rig, "-o", fields, "--rays", 64)
    must(FIT, "visibility", vis, "-o", model, "--fields", fields, "--holdout", "bend", "--report", report,
         "--features", features)
    fit = json.load(open(report))["figures"]
    must(PACK, "asset", model, "-o", asset, "--precision", "i8")
    must(PACK, "check", asset, vis, "--report", report)
    check = json.load(open(report))["figures"]
    prediction = os.path.join(folder, name + ".pred.vis.h5")
    must(FIT, "predict", model, vis, "-o", prediction)
    with h5py.File(prediction) as f:
        assert np.isfinite(f["visibility/coefficients"][:]).all(), name
    must(PLAYER, "render", asset, "-o", os.path.join(folder, name + ".png"), "--channel", "ao", "--size", "64x64")
    for made in (fit["held_out"], check["held_out"]):
        assert np.isfinite(made["rms_v"]), (name, made)
    return fit, check


def part_count(folder, name):
    with h5py.File(os.path.join(folder, name + ".fields.h5")) as f:
        return len(f["parts/joint"])


def check_rigs(folder):
    rigs = {"one": dict(bones=1, rings=20), "many": dict(bones=200, rings=400), "scaled": dict(bones=8, rings=40, scale=3),
            "mirrored": dict(bones=8, rings=40, mirrored=3), "plain": dict(bones=8, rings=40)}
    rms = {}
    for name, shape in rigs.items():
        chain(os.path.join(folder, name + ".glb"), **shape)
        fit, check = figures(folder, name, "relative-bones" if shape["bones"] > 1 else "joint-angles")
        rms[name] = fit["held_out"]["rms_v"]
        print(f"{name}: {part_count(folder, name)} parts, rms V {rms[name]:.4f}, packed {check['held_out']['rms_v']:.4f}")
        # The asset comes to what the model comes to.
        assert abs(check["held_out"]["rms_v"] - rms[name]) < 0.1 * rms[name] + 0.003, (name, check["held_out"])
    assert part_count(folder, "one") == 1
    # A single bone has no others to be relative to. The default suits it, and the message says what to do.
    lone = [FIT, "visibility", os.path.join(folder, "one.vis.h5"), "-o", os.path.join(folder, "lone.model.h5")]
    must(*lone)
    assert "features joint-angles" in " ".join(must(BAKE, "info", lone[-1]).split())
    refused(3, "take joint-angles", *lone, "--features", "relative-bones")
    assert rms["mirrored"] < 1.5 * rms["plain"], rms
    assert rms["scaled"] < 2 * rms["plain"], rms


def check_flat_part(folder):
    """A card, or a disc that marks a footstep, has no volume, and it is a part as any other."""
    rig, fields = os.path.join(folder, "card.glb"), os.path.join(folder, "card.fields.h5")
    g = Gltf()
    hand = g.node("hand")
    card = g.node("card", hand, translation=[0, 1, 0])
    for node, (points, triangles) in ((hand, tube(1.0, 0.1, 5, 8)), (card, flat_disc(0.2))):
        bone = np.zeros((len(points), 4), np.uint8)
        bone[:, 0] = node == card
        weights = np.eye(1, 4, dtype=np.float32).repeat(len(points), 0)
        skin = g.skin([hand, card], translation_to([[0, 0, 0], [0, 1, 0]]))
        g.node(f"mesh{node}", mesh=g.mesh(primitive(g, points, triangles, bone, weights)), skin=skin)
    t = np.linspace(0, 1, 5)
    g.clip("turn", (card, "rotation", t, turn("z", 90 * t)))
    g.save(rig)
    must(BAKE, "fields", rig, "-o", fields, "--rays", 64)
    assert part_count(folder, "card") == 2


def flat_disc(radius):
    angle = 2 * np.pi * np.arange(8) / 8
    rim = radius * np.stack([np.sin(angle), 0 * angle, np.cos(angle)], 1)
    return np.concatenate([[[0, 0, 0]], rim]), np.array([[0, 1 + i, 1 + (i + 1) % 8] for i in range(8)], np.uint16)


def check_damage(folder):
    vis, fields, out = (os.path.join(folder, name) for name in ("plain.vis.h5", "plain.fields.h5", "no.model.h5"))
    whole = open(fields, "rb").read()
    bad = os.path.join(folder, "bad.fields.h5")
    fit = [FIT, "visibility", vis, "-o", out, "--fields", bad]
    for place in ("parts/scale", "parts/centre", "parts/radius", "parts/distance_scale"):
        for number in (np.nan, np.inf):
            open(bad, "wb").write(whole)
            with h5py.File(bad, "r+") as f:
                f[place][(0,) * f[place].ndim] = number
            refused(3, "/" + place, *fit)
    for share in (0, 0.1, 0.5, 0.99):
        open(bad, "wb").write(whole[: int(share * len(whole))])
        refused(3, "bad.fields.h5", *fit)
    refused(3, "another character", *fit[:-1], os.path.join(folder, "many.fields.h5"))
    assert not os.path.exists(out)


with tempfile.TemporaryDirectory() as folder:
    check_rigs(folder)
    check_flat_part(folder)
    check_damage(folder)
print("composed models of odd rigs: ok")
