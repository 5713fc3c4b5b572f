"""The whole pipeline, coarsely, on the synthetic character of scripts/samples/make_samples.py, which is the same on every machine:
bake, both feature sets, predict, pack, check, and the picture of the packed truth beside brute force.

usage: test_sample_rig.py BIN
"""
import json
import pathlib
import subprocess
import sys
import tempfile

import h5py
import numpy as np
from PIL import Image

BIN = pathlib.Path(sys.argv[1]).resolve()
# The largest errors measured are 0.306 and 0.0107 in the training frames, 0.391 and 0.0131 in the held-out frames. A model
# that always says the mean has a relative error of 1.
BOUNDS = {"training": {"relative_error": 0.36, "ambient_error": 0.0125},
          "held_out": {"relative_error": 0.46, "ambient_error": 0.0155}}
CAMERA = ["--size", "200x200", "--camera", "yaw=35,pitch=12"]


def run(program, *arguments):
    subprocess.run([BIN / program, *map(str, arguments)], check=True, stdout=subprocess.DEVNULL)


def rmse(a, b):
    a, b = (np.asarray(Image.open(p).convert("RGBA"), float) for p in (a, b))
    covered = (a[..., 3] > 254) & (b[..., 3] > 254)
    assert covered.sum() > 500, "the character covers %d pixels" % covered.sum()
    return np.sqrt(((a - b)[covered][:, :3] ** 2).mean())


def first_frame(vis, clip):
    with h5py.File(vis) as file:
        return int(np.flatnonzero(file["frames/clip"][:] == list(file["clips/names"].asstr()[:]).index(clip))[0])


def check_models(folder, vis, held_out):
    """Fits with either kind of features, packed and held against the bake. Returns the path of the last asset."""
    for features, convention in (("joint-angles", "A4"), ("relative-bones", "D5")):
        model, asset, check = (folder / f"s.{ext}" for ext in ("model.h5", "pnb", "json"))
        run("penumbra-fit", "visibility", vis, "-o", model, "--features", features, "--convention", convention,
            "--holdout", held_out)
        run("penumbra-fit", "predict", model, vis, "-o", folder / "p.vis.h5")
        run("penumbra-pack", "asset", model, "-o", asset, "--precision", "i8")
        run("penumbra-pack", "check", asset, vis, "--predictions", folder / "p.vis.h5", "--report", check)
        errors = json.loads(check.read_text())["figures"]
        for part, bounds in BOUNDS.items():
            found = {name: errors[part][name] for name in bounds}
            print(features, convention, part, *(f"{name} {value:.4f}" for name, value in found.items()))
            assert all(found[name] < most for name, most in bounds.items()), (features, part, found, bounds)
    return asset


def check_picture(folder, vis, asset, held_out):
    """Ambient occlusion of a packed frame beside brute force."""
    truth = folder / "s.truth.pnb"
    run("penumbra-pack", "truth", vis, "-o", truth, "--clips", held_out)
    show = ["--channel", "ao", *CAMERA]
    run("penumbra-player", "render", asset, "--clip", held_out, "--frame", 0, "--truth", truth, "--source", "truth",
        "-o", folder / "player.png", *show)
    first = first_frame(vis, held_out)
    run("penumbra-bake", "reference", vis, "--frame", first, "-o", folder / "reference.png", *show)
    difference = rmse(folder / "player.png", folder / "reference.png")
    print(f"ambient occlusion, packed truth against brute force: RMSE {difference:.1f} of 255")
    assert difference < 16


def main():
    """Holds out the middle third of the clip `walk`."""
    held_out = "walk#2"
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        vis = folder / "s.vis.h5"
        run("penumbra-bake", "visibility", BIN / ".." / "samples" / "capsule_man.glb", "-o", vis, "--clips", "wave,squat,walk",
            "--fps", 6, "--blocks", 3, "--rays", 128)
        asset = check_models(folder, vis, held_out)
        check_picture(folder, vis, asset, held_out)


main()
