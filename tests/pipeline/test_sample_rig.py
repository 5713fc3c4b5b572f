"""The whole pipeline on the rig of scripts/get_samples ($PENUMBRA_SAMPLE_ENV), coarsely: bake, both feature sets, predict, pack,
check, and the picture of the packed truth beside brute force. Prints the figures.

test_sample_rig.py BIN_FOLDER"""
import json
import os
import pathlib
import subprocess
import sys
import tempfile

import h5py
import numpy as np
from PIL import Image

BIN = pathlib.Path(sys.argv[1])
CAMERA = ["--size", "200x200", "--camera", "yaw=35,pitch=12"]


def sample():
    """The variables of sample.env."""
    script = 'source "$0"; printf "%s\\n" "$TRAIN_CLIPS" "$HOLDOUT_CLIP" "${RIG[@]}"'
    lines = subprocess.run(["bash", "-c", script, os.environ["PENUMBRA_SAMPLE_ENV"]], check=True, capture_output=True,
                           text=True).stdout.splitlines()
    return lines[0], lines[1], lines[2:]


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


def main():
    if "PENUMBRA_SAMPLE_ENV" not in os.environ:
        print("PENUMBRA_SAMPLE_ENV is not set (scripts/test sets it): nothing to run on")
        return
    train, held_out, rig = sample()
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        vis, truth = folder / "s.vis.h5", folder / "s.truth.pnb"
        run("penumbra-bake", "visibility", *rig, "-o", vis, "--clips", f"{train},{held_out}", "--fps", 5, "--rays", 256)
        run("penumbra-pack", "truth", vis, "-o", truth, "--clips", held_out)
        for features, convention in (("joint-angles", "A4"), ("relative-bones", "D5")):
            model, asset, check = (folder / f"s.{ext}" for ext in ("model.h5", "pnb", "json"))
            run("penumbra-fit", "visibility", vis, "-o", model, "--features", features, "--convention", convention,
                "--holdout", held_out)
            run("penumbra-fit", "predict", model, vis, "-o", folder / "p.vis.h5")
            run("penumbra-pack", "asset", model, "-o", asset, "--precision", "i8")
            run("penumbra-pack", "check", asset, vis, "--predictions", folder / "p.vis.h5", "--report", check)
            errors = json.loads(check.read_text())["figures"]
            print(features, convention, *(f"{k} {errors[k]['relative_error']:.3f}" for k in ("training", "held_out")))
            # Measured with 256 rays on the samples of the three sources: training .32 to .51, held out .78 to 1.02.
            assert errors["training"]["relative_error"] < 0.8 and errors["held_out"]["relative_error"] < 1.3
        show = ["--channel", "ao", *CAMERA]
        run("penumbra-player", "render", asset, "--clip", held_out, "--frame", 0, "--truth", truth, "--source", "truth",
            "-o", folder / "player.png", *show)
        first = first_frame(vis, held_out)
        run("penumbra-bake", "reference", vis, "--frame", first, "-o", folder / "reference.png", *show)
        difference = rmse(folder / "player.png", folder / "reference.png")
        print(f"ambient occlusion, packed truth against brute force: RMSE {difference:.1f} of 255")
        assert difference < 16


main()
