"""Light that bounces from bake to picture: fit indirect, pack asset, check --bounces and render --bounces, on a
skeleton and on cloth, on both paths, and one clear line for what does not fit.

usage: test_bounces.py BIN
"""
import hashlib
import json
import os
import subprocess
import sys
import tempfile

import h5py
import numpy as np
from PIL import Image

BIN = os.path.abspath(sys.argv[1])
SAMPLES = os.path.join(BIN, "..", "samples")
MAN, SHEET = os.path.join(SAMPLES, "capsule_man.glb"), os.path.join(SAMPLES, "sheet.npz")
BOUNCES = ["--quantity", "transfer", "--order", "4", "--bounces", "3", "--albedo", "0.6/0.5/0.4"]
SMALL = ["--fps", "2", "--rays", "64", "-q"]


def run(tool, *words, code=0):
    result = subprocess.run([os.path.join(BIN, "penumbra-" + tool), *map(str, words)], stdout=subprocess.PIPE,
                            stderr=subprocess.PIPE, text=True)
    assert result.returncode == code, (words, result)
    return result


def figures(tool, *words, place):
    run(tool, *words, "-q", "--report", place("report.json"))
    return json.load(open(place("report.json")))["figures"]


def digest(path):
    return hashlib.sha256(open(path, "rb").read()).hexdigest()


def pixels(path):
    return np.asarray(Image.open(path).convert("RGBA"), int)


def check_skeleton(place):
    run("bake", "visibility", MAN, "-o", place("v.vis.h5"), *SMALL)
    run("bake", "visibility", MAN, "-o", place("t.vis.h5"), *SMALL, *BOUNCES)
    run("fit", "visibility", place("v.vis.h5"), "-o", place("v.model.h5"), "-q", "--holdout", "wave")
    found = figures("fit", "indirect", place("v.model.h5"), place("t.vis.h5"), "-o", place("b.model.h5"), place=place)
    for part in ("train", "held_out"):  # better than no bounces, and in training better than the mean
        assert 0 < found[part]["share_of_direct"] < found[part]["share_of_direct_without"], found
    assert found["train"]["share_of_direct"] < found["train"]["share_of_direct_by_mean"], found
    for threads in (1, 8):
        run("fit", "indirect", place("v.model.h5"), place("t.vis.h5"), "-o", place("c.model.h5"), "-q", "--threads", threads)
        assert digest(place("c.model.h5")) == digest(place("b.model.h5")), threads
    with h5py.File(place("b.model.h5")) as f:
        axes = f["indirect/color_axes"][()]
        assert np.abs(axes @ axes.T - np.eye(3)).max() < 1e-5 and (axes[0] > 0).all()
    run("fit", "brdf", "--analytic", "lambert:color=0.6/0.5/0.4", "-o", place("l.brdf.h5"), "-q")
    run("fit", "brdf", "--analytic", "ggx:alpha=0.3", "-o", place("g.brdf.h5"), "-q")
    run("fit", "light", "--analytic", "sky:elevation=30", "--order", "4", "-o", place("s.light.h5"), "-q")
    looks = ["--brdf", place("l.brdf.h5"), "--brdf", place("g.brdf.h5"), "--light", place("s.light.h5")]
    packed = figures("pack", "asset", place("b.model.h5"), *looks, "-o", place("b.pnb"), place=place)
    assert 0 < packed["bounced"]["bytes_per_vertex"] <= 60, packed
    told = figures("bake", "info", place("b.pnb"), place=place)["bounced"]
    assert abs(told["bytes_per_vertex"] - packed["bounced"]["bytes_per_vertex"]) < 1e-6, (told, packed)
    assert told["sh_order"] == 3 and told["bounces"] == 3 and told["components"] > 0 and told["precision"] == "i8", told
    of_model = figures("bake", "info", place("b.model.h5"), place=place)["bounced"]
    assert of_model["components"] >= told["components"] and of_model["bytes"] > told["bytes"], (of_model, told)
    assert abs(of_model["share_of_direct"]["held_out"] - found["held_out"]["share_of_direct"]) < 1e-9, (of_model, found)
    run("pack", "asset", place("v.model.h5"), *looks, "-o", place("v.pnb"), "-q")
    assert "bounced" not in figures("bake", "info", place("v.pnb"), place=place)
    checked = figures("pack", "check", place("b.pnb"), place("v.vis.h5"), "--bounces", place("t.vis.h5"), place=place)
    for part, name in (("training", "train"), ("held out", "held_out")):  # packing adds to the error of the fit
        share, of_fit = checked["bounced"][part]["share_of_direct"], found[name]["share_of_direct"]
        assert 0.98 * of_fit < share < 0.9 * checked["bounced"][part]["share_without"], (checked, found)
    return packed


def render(place, asset, shown, material, path):
    out = place(f"{shown}_{material}_{path}.png")
    run("player", "render", place(asset), "--brdf", material, "--clip", "squat", "--frame", "3", "--size", "160x160", "--gl",
        "osmesa", "--path", path, "--exposure", "0.25", "-o", out, "-q", "--bounces", shown)
    return pixels(out)


def channel(place, name, path):
    run("player", "render", place("b.pnb"), "--channel", name, "--path", path, "--clip", "squat", "--frame", "3", "--size",
        "160x160", "--gl", "osmesa", "-o", place("channel.png"), "-q")
    return pixels(place("channel.png"))[..., 0]


def check_pictures(place):
    for material in ("lambert", "ggx"):
        direct, both, plain = (render(place, asset, shown, material, "cpu") for asset, shown in
                               (("b.pnb", "direct"), ("b.pnb", "both"), ("v.pnb", "both")))
        assert (direct == plain).all(), "direct light is that of an asset without bounces"
        inside = both[..., 3] > 254
        assert (both[inside] >= direct[inside] - 1).all() and both[inside].mean() > direct[inside].mean() + 0.5
        # Dark sRGB has steps of 1/13 of a linear one, so that half a linear step may be some codes.
        apart = {shown: np.abs(render(place, "b.pnb", shown, material, "cpu") - render(place, "b.pnb", shown, material, "glsl"))
                 .max() for shown in ("direct", "indirect", "both")}
        assert apart["indirect"] <= 2 and apart["both"] <= max(2, apart["direct"]), (material, apart)
    ao, on_gpu, bounced, bounced_on_gpu = (channel(place, name, path) for name in ("ao", "ao-bounced") for path in ("cpu", "glsl"))
    assert (bounced >= ao - 1).all() and bounced.mean() > ao.mean()
    apart = np.abs(bounced - bounced_on_gpu)  # where a silhouette is drawn otherwise, both channels are
    assert apart[np.abs(ao - on_gpu) <= 1].max() <= 1


def check_cloth(place):
    sheet = ["--rays", "32", "-q", "--two-sided"]
    run("bake", "visibility", SHEET, "-o", place("s.vis.h5"), *sheet)
    run("bake", "visibility", SHEET, "-o", place("st.vis.h5"), *sheet, *BOUNCES)
    run("fit", "visibility", place("s.vis.h5"), "-o", place("s.model.h5"), "-q")
    found = figures("fit", "indirect", place("s.model.h5"), place("st.vis.h5"), "-o", place("sb.model.h5"), place=place)
    assert found["train"]["share_of_direct"] <= found["train"]["share_of_direct_by_mean"], found
    run("pack", "asset", place("sb.model.h5"), "--brdf", place("l.brdf.h5"), "--light", place("s.light.h5"),
        "--bounce-bytes", "200", "-o", place("s.pnb"), "-q")
    run("pack", "check", place("s.pnb"), place("s.vis.h5"), "--bounces", place("st.vis.h5"))


def refuse(part, code, tool, *words):
    result = run(tool, *words, code=code)
    assert part in result.stderr and len(result.stderr.splitlines()) == 1, (words, result.stderr)


def check_refusals(place):
    model, out = place("v.model.h5"), ["-o", place("none.model.h5")]
    refuse("needs a bake of transfer with bounces", 3, "fit", "indirect", model, place("v.vis.h5"), *out)
    run("bake", "visibility", MAN, "-o", place("d.vis.h5"), *SMALL, "--quantity", "transfer")
    refuse("bake with 3", 3, "fit", "indirect", model, place("d.vis.h5"), *out)
    low = ["2" if word == "4" else word for word in BOUNCES]
    run("bake", "visibility", MAN, "-o", place("o.vis.h5"), *SMALL, *low)
    refuse("needs order 3", 3, "fit", "indirect", model, place("o.vis.h5"), *out)
    refuse("another character", 3, "fit", "indirect", model, place("st.vis.h5"), *out)
    run("bake", "visibility", MAN, "-o", place("f.vis.h5"), "--fps", "3", "--rays", "64", "-q", *BOUNCES)
    refuse("is not a frame of the model", 3, "fit", "indirect", model, place("f.vis.h5"), *out)
    run("bake", "visibility", MAN, "-o", place("w.vis.h5"), *SMALL, *BOUNCES, "--clips", "wave")
    refuse("no frame is left to train on", 1, "fit", "indirect", model, place("w.vis.h5"), *out)
    refuse("--output-variance", 1, "fit", "indirect", model, place("t.vis.h5"), *out, "--output-variance", "0")
    assert not os.path.exists(out[1])
    refuse("--bounce-bytes", 1, "pack", "asset", place("b.model.h5"), "--bounce-bytes", "2", "-o", place("none.pnb"))
    refuse("no light that bounces", 3, "pack", "check", place("v.pnb"), place("v.vis.h5"), "--bounces", place("t.vis.h5"))
    refuse("is not a bake of transfer with bounces", 3, "pack", "check", place("b.pnb"), place("v.vis.h5"), "--bounces",
           place("v.vis.h5"), "--dry-run")
    refuse("--bounce-bytes: needs a model with light", 1, "pack", "asset", model, "--bounce-bytes", "200", "-o", place("none.pnb"))
    picture = ["-o", place("none.png")]
    refuse("both, direct, indirect", 1, "player", "render", place("b.pnb"), "--bounces", "all", *picture)
    refuse("no light that bounces", 1, "player", "render", place("v.pnb"), "--bounces", "indirect", *picture)
    refuse("no light that bounces", 1, "player", "render", place("v.pnb"), "--channel", "ao-bounced", *picture)
    with open(place("b.model.h5"), "rb") as source, open(place("x.model.h5"), "wb") as target:
        target.write(source.read())
    with h5py.File(place("x.model.h5"), "r+") as f:
        f["indirect"].attrs["count"] = 1
    refuse("/indirect", 3, "pack", "asset", place("x.model.h5"), "-o", place("none.pnb"))


def main():
    with tempfile.TemporaryDirectory() as folder:
        place = lambda name: os.path.join(folder, name)
        check_skeleton(place)
        check_pictures(place)
        check_cloth(place)
        check_refusals(place)
    print("ok")


if __name__ == "__main__":
    main()
