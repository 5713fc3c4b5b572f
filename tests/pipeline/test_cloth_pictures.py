"""Pictures of a sheet that lies flat: the camera that is told nothing sees it from above, in penumbra-player and
penumbra-bake reference alike, so that their pictures lie over each other; an upright one is seen as before; the figures
against the truth are those of penumbra-pack check.

usage: test_cloth_pictures.py BIN
"""
import csv
import json
import os
import subprocess
import sys
import tempfile

import numpy as np
from PIL import Image

BIN = os.path.abspath(sys.argv[1])
FRAMES, SIDE = 12, 15
LIT = ["--brdf", "lambert.brdf.h5", "--light", "sky.light.h5"]


def good(tool, *words):
    result = subprocess.run([os.path.join(BIN, "penumbra-" + tool), *map(str, words)], stdout=subprocess.PIPE,
                            stderr=subprocess.PIPE, text=True)
    assert result.returncode == 0, (tool, words, result.stderr)


def write_sheet(path, upright):
    """Makes a sheet of 2 x 2 m, flat at rest, then with waves of 5 cm; upright, it hangs by an edge."""
    u, v = np.meshgrid(np.linspace(-1, 1, SIDE), np.linspace(-1, 1, SIDE), indexing="ij")
    time = np.arange(FRAMES)[:, None, None]
    wave = 0.05 * np.sin(4 * u + 2 * v + 0.5 * time) * (time > 0)
    flat = [np.broadcast_to(u, wave.shape), np.broadcast_to(v, wave.shape)]
    positions = np.stack([flat[0], flat[1], wave] if upright else [flat[0], wave, -flat[1]], -1)
    corner = (np.arange(SIDE - 1)[:, None] * SIDE + np.arange(SIDE - 1)).ravel()
    faces = np.concatenate([np.stack([corner, corner + SIDE, corner + 1], 1),
                            np.stack([corner + 1, corner + SIDE, corner + SIDE + 1], 1)])
    np.savez(path, verts=positions.reshape(FRAMES, -1, 3).astype("f4"), faces=faces.astype("i4"), fps=np.float32(10))


def make(name, upright):
    write_sheet(name + ".npz", upright)
    baked = name + ".vis.h5"
    good("bake", "visibility", name + ".npz", "-o", baked, "--two-sided", "--rays", 64, "--order", 3, "--blocks", 3)
    good("fit", "visibility", baked, "-o", name + ".model.h5", "--model", "linear", "--parts", 4, "--convention", "A3",
         "--holdout", name + "#3")
    good("pack", "asset", name + ".model.h5", *LIT, "-o", name + ".pnb")
    good("pack", "truth", baked, "-o", name + ".truth.pnb")


def read(path):
    return np.asarray(Image.open(path).convert("RGBA"), float)


def pictures(name, *camera):
    """Returns the first held-out frame's normals, of the player and of the reference."""
    look = ["--size", "96x96", "--channel", "normals", *camera]
    good("player", "render", name + ".pnb", "-o", "p.png", "--clip", name + "#3", "--frame", 0, *look)
    good("bake", "reference", name + ".vis.h5", "-o", "r.png", "--frame", 2 * FRAMES // 3, *look)
    return read("p.png"), read("r.png")


def check_cameras():
    """A sheet of 2 x 2 in a sphere of radius sqrt 2, seen from 35 degrees above, covers 4 sin 35 of 8.8 m2, 26% of
    the picture; upright it covers 45%."""
    level = ["--camera", "pitch=0"]
    for name, camera, least, most in (("flat", [], 0.22, 0.32), ("flat", level, 0, 0.06), ("hung", [], 0.42, 0.5),
                                      ("hung", level, 0.42, 0.5)):
        player, reference = pictures(name, *camera)
        covered, expected = player[..., 3] > 127, reference[..., 3] > 127
        share = covered.mean()
        differ = (covered != expected).mean()
        print(f"{name} {camera}: {100 * share:.1f}% covered, masks differ on {100 * differ:.2f}%")
        assert least <= share <= most, (name, camera, share)
        assert differ < 0.01, (name, camera)
    assert (pictures("hung")[0] == pictures("hung", "--camera", "pitch=0")[0]).all()


def check_sequence():
    """A sequence has one camera, also from above. Its mean error is that of the check."""
    good("player", "render", "flat.pnb", "-o", "s_%02d.png", "--size", "64x64", "--clip", "flat#3")
    good("player", "measure", "flat.pnb", "--truth", "flat.truth.pnb", "--csv", "s.csv", "--clip", "flat#3")
    masks = [read(name)[..., 3] > 127 for name in sorted(os.listdir(".")) if name.startswith("s_")]
    assert len(masks) == FRAMES // 3 and min(mask.mean() for mask in masks) > 0.2, [mask.mean() for mask in masks]
    with open("s.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    good("pack", "check", "flat.pnb", "flat.vis.h5", "--report", "check.json")
    with open("check.json") as file:
        figures = json.load(file)["figures"]
    clip = next(c for c in figures["clips"] if c["name"] == "flat#3")
    mean = np.mean([float(row["ambient_error_mean"]) for row in rows])
    # The player's frames are those of the asset, whose positions have 16 bits; measured 2.2e-5.
    assert abs(mean - clip["ambient_error"]) < 1e-4, (mean, clip)


def check_words():
    """Sizes and backgrounds that either program reads, both read: signs, white space, zeros, hexadecimal, too small a
    number."""
    draw = (["player", "render", "flat.pnb"], ["bake", "reference", "flat.vis.h5", "--frame", 0])
    for program, *words in draw:
        for size in ("64x48", "+64x 48", "00000064x48"):
            good(program, *words, "-o", "w.png", "--dry-run", "--size", size)
        for colour in ("transparent", "0.5/1/.2", " 0.5/+1/0x1p-2", "1e-50/0/0"):
            good(program, *words, "-o", "w.png", "--dry-run", "--background", colour)


def check_kinds():
    """penumbra-bake info names the kinds of an asset by the words that the fit took, whatever they are."""
    for model, features in (("linear", "dihedral-angles"), ("additive", "dihedral-angles"), ("quadratic", "relative-bones")):
        good("fit", "visibility", "flat.vis.h5", "-o", "kind.model.h5", "--model", model, "--features", features, "--parts", 4,
             "--convention", "A3", "--holdout", "flat#3")
        good("pack", "asset", "kind.model.h5", *LIT, "-o", "kind.pnb")
        for path, of_model in (("kind.model.h5", lambda figures: figures), ("kind.pnb", lambda figures: figures["model"])):
            good("bake", "info", path, "--report", "info.json")
            with open("info.json") as file:
                found = of_model(json.load(file)["figures"])
            assert (found["model"], found["features"]) == (model, features), (path, model, features, found)


with tempfile.TemporaryDirectory() as folder:
    os.chdir(folder)
    good("fit", "brdf", "--analytic", "lambert", "-o", "lambert.brdf.h5")
    good("fit", "light", "--analytic", "sky:elevation=40", "-o", "sky.light.h5")
    make("flat", False)
    make("hung", True)
    check_cameras()
    check_sequence()
    check_words()
    check_kinds()
print("ok")
