"""penumbra-fit visibility --model zh-lobes, as a user runs it: the file beside numpy, predictions with the errors that
`compare` shows, the same bytes for any number of threads, and one clear line from whoever does not take it.

usage: test_lobes.py BIN
"""
import hashlib
import json
import os
import subprocess
import sys
import tempfile

import h5py
import numpy as np

BIN = os.path.abspath(sys.argv[1])
SAMPLES = os.path.join(BIN, "..", "samples")
MAN = os.path.join(SAMPLES, "capsule_man.glb")
HELD = "wave"


def run(tool, *words, code=0):
    result = subprocess.run([os.path.join(BIN, "penumbra-" + tool), *map(str, words)], stdout=subprocess.PIPE,
                            stderr=subprocess.PIPE, text=True)
    assert result.returncode == code, (words, result)
    return result


def digest(path):
    with open(path, "rb") as f:
        return hashlib.sha256(f.read()).hexdigest()


def fit(place, name, *words):
    run("fit", "visibility", place("v.vis.h5"), "--model", "zh-lobes", "--holdout", HELD, "--clusters", 4, "-q", "-o",
        place(name), "--report", place("r.json"), *words)
    with open(place("r.json")) as f:
        return json.load(f)["figures"]


def moments(path):
    with h5py.File(path) as f:
        clip = list(f["clips/names"].asstr()[()]).index(HELD)
        return f["visibility/coefficients"][()].astype(float), f["frames/clip"][()] == clip


def spread(predicted, truth):
    """Mean and deviation over frames of |v^ - v| / |v|; no frame of reference matters."""
    errors = np.sqrt(((predicted - truth)**2).sum((1, 2)) / (truth**2).sum((1, 2)))
    return errors.mean(), errors.std()


def compared(place):
    """The errors of 1 and 2 lobes that `compare` shows, of the vertices that it samples."""
    run("fit", "compare", place("v.vis.h5"), "--holdout", HELD, "--models", "zh-lobes", "--lobes", "1,2", "--clusters", 4,
        "--output-variances", "0.9", "--conventions", "A2", "-q", "-o", place("c.html"))
    with open(place("c.json")) as f:
        figure = next(f for f in json.load(f)["figures"] if f["id"] == "lobes")
    series = figure["plots"][0]["series"][0]
    return {1: (series["y"][2], series["deviation"][2]), 2: (series["y"][3], series["deviation"][3])}


def check_errors(place):
    truth, held = moments(place("v.vis.h5"))
    vertices = truth.shape[1]
    sample = np.arange(0, vertices, -(-vertices // 64))
    of_compare = compared(place)
    for lobes in (1, 2):
        figures = fit(place, "m.lobes.h5", "--lobes", lobes)
        run("fit", "predict", place("m.lobes.h5"), place("v.vis.h5"), "-q", "-o", place("p.vis.h5"))
        predicted, _ = moments(place("p.vis.h5"))
        whole = spread(predicted[held], truth[held][..., :16])
        told = figures["held_out_spread"]
        assert np.allclose(whole, (told["mean"], told["deviation"]), atol=1e-5), (whole, told)
        part = spread(predicted[held][:, sample], truth[held][:, sample, :16])
        assert np.allclose(part, of_compare[lobes], atol=1e-5), (part, of_compare)
        print(f"{lobes} lobes: held out {whole[0]:.3f} +- {whole[1]:.3f}, the sample {part[0]:.3f} +- {part[1]:.3f}")


def check_file(place):
    """The datasets are what formats/README.md says: evaluated here, they give the prediction."""
    figures = fit(place, "m.lobes.h5")
    run("fit", "predict", place("m.lobes.h5"), place("v.vis.h5"), "-q", "-o", place("p.vis.h5"))
    with h5py.File(place("m.lobes.h5")) as f:
        assert f.attrs["format"] == "penumbra.lobes" and f.attrs["sh_order"] == 4
        mean, basis, axes, weights = (f["lobes/" + n][()].astype(float) for n in ("pose_mean", "pose_basis", "axes", "weights"))
    assert axes.shape[1] == 2 and weights.shape == (axes.shape[0], len(basis) + 1, 2, 6)
    assert figures["bytes"] == 4 * (weights.size + axes.size + basis.size + mean.size), figures
    with h5py.File(place("v.vis.h5")) as f:
        pose = f["frames/pose"][5].astype(float)
    numbers = np.einsum("i,vick->vck", np.append(basis @ (pose - mean), 1), weights)
    predicted = moments(place("p.vis.h5"))[0][5]
    # The moment of band 0 is the sum of the lobes' first coefficients, in any frame.
    assert np.abs(numbers[:, :, 2].sum(1) - predicted[:, 0]).max() < 1e-5
    # Two lobes about axes s, t have |v_l|^2 = z^2 + w^2 + 2 z w P_l(s.t) in band l.
    e = np.where(np.abs(axes[..., :1]) < 0.6, [1.0, 0, 0], [0, 1.0, 0])
    x = np.cross(e, axes)
    x /= np.linalg.norm(x, axis=-1, keepdims=True)
    y = np.cross(axes, x)
    u, v = numbers[..., 0:1], numbers[..., 1:2]
    angle = np.maximum(np.hypot(u, v), 1e-30)
    s = axes * np.cos(angle) + (x * u + y * v) * np.sin(angle) / angle
    cosine = (s[:, 0] * s[:, 1]).sum(-1)
    for l, legendre in ((1, cosine), (2, 1.5 * cosine**2 - 0.5)):
        z, w = numbers[:, 0, 2 + l], numbers[:, 1, 2 + l]
        energy = (predicted[:, l * l:(l + 1)**2]**2).sum(1)
        assert np.abs(z * z + w * w + 2 * z * w * legendre - energy).max() < 1e-4, l
    info = run("bake", "info", place("m.lobes.h5")).stdout
    assert "penumbra.lobes" in info and "ridge" in info, info
    for threads in (1, 8):
        fit(place, "s.lobes.h5", "--threads", threads)
        assert digest(place("s.lobes.h5")) == digest(place("m.lobes.h5")), threads
    run("pack", "truth", place("p.vis.h5"), "-q", "-o", place("p.truth.pnb"))


def refuse(words, part, code):
    result = run(*words, code=code)
    assert part in result.stderr and len(result.stderr.splitlines()) == 1, (words, result.stderr)


def check_refusals(place):
    lobes = ["fit", "visibility", place("v.vis.h5"), "--model", "zh-lobes", "-o", place("none.lobes.h5")]
    for words, part in ((["--lobes", 0], "--lobes"), (["--lobes", 4], "--lobes must be 1..3"), (["--lobes", "two"], "--lobes"),
                        (["--features", "relative-bones"], "reads only joint-angles"),
                        (["--convention", "A4"], "takes B2 to B8"), (["--convention", "B1"], "takes B2 to B8"),
                        (["--convention", "D5"], "takes B2 to B8"), (["--convention", "B6"], "the file has order 5"),
                        (["--output-variance", "0.9"], "--output-variance cannot be combined"),
                        (["--parts", 3], "--parts cannot be combined"), (["--local-model", "linear"], "--local-model cannot be combined"),
                        (["--input-variance", "nan"], "--input-variance must lie in (0, 1]"),
                        (["--holdout", "nobody"], "no clip 'nobody'"),
                        (["--clusters", 5000], "--clusters: 5000 is more than")):
        refuse([*lobes, *words], part, 1)
    refuse(["fit", "visibility", place("v.vis.h5"), "--lobes", 2, "-o", place("none.model.h5")], "only --model zh-lobes", 1)
    refuse([*lobes[:2], place("sheet.vis.h5"), *lobes[3:]], "has no skeleton", 1)
    refuse(["fit", "predict", place("m.lobes.h5"), place("other.vis.h5"), "-o", place("none.vis.h5")], "another character", 3)
    for words in (["pack", "asset", place("m.lobes.h5"), "-o", place("none.pnb")],
                  ["fit", "blockers", place("m.lobes.h5"), "-o", place("none.blockers.h5")],
                  ["fit", "indirect", place("m.lobes.h5"), place("v.vis.h5"), "-o", place("none.model.h5")]):
        refuse(words, "reference model of zonal lobes", 5)
    assert not any(name.startswith("none") for name in os.listdir(place("")))
    run(*lobes, "--features", "joint-angles", "--dry-run")


def main():
    with tempfile.TemporaryDirectory() as folder:
        place = lambda name: os.path.join(folder, name)
        small = ["-q", "--rays", 64, "--order", 5]
        run("bake", "visibility", MAN, "-o", place("v.vis.h5"), *small, "--fps", 3)
        run("bake", "visibility", os.path.join(SAMPLES, "sheet.npz"), "-o", place("sheet.vis.h5"), *small, "--fps", 2)
        run("bake", "visibility", os.path.join(SAMPLES, "two_skins.glb"), "-o", place("other.vis.h5"), *small, "--fps", 2)
        for check in (check_errors, check_file, check_refusals):
            check(place)
            print(check.__name__, "ok")


main()
