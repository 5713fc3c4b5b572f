"""penumbra-fit transfer: the linear models of transfer against numpy, the same bytes for any number of threads,
predictions in the layout of a bake, and one clear line for what cannot be fitted.

usage: test_transfer_fit.py BIN
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
FIT, BAKE = os.path.join(BIN, "penumbra-fit"), os.path.join(BIN, "penumbra-bake")
SAMPLES = os.path.join(BIN, "..", "samples")
MAN = os.path.join(SAMPLES, "capsule_man.glb")
HELD = "wave"
PCA = ["--components", "6,20"]


def run(tool, *words, code=0):
    result = subprocess.run([tool, *map(str, words)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    assert result.returncode == code, (words, result)
    return result


def fit(source, out, *words):
    report = out + ".json"
    run(FIT, "transfer", source, "-o", out, "-q", "--report", report, *words)
    return json.load(open(report))["figures"]


def digest(path):
    return hashlib.sha256(open(path, "rb").read()).hexdigest()


def read(path):
    """Returns poses [F, P], transfer [F, V, n] and whether each frame is trained on."""
    with h5py.File(path) as f:
        names = [name.decode() if isinstance(name, bytes) else name for name in f["clips/names"][()]]
        trained = f["frames/clip"][()] != names.index(HELD)
        return f["frames/pose"][()].astype(float), f["visibility/coefficients"][()].astype(float), trained


def ridge(a, b, alpha):
    """Weights and bias of a ridge regression with an intercept that has no prior."""
    mean = a.mean(0)
    x = np.linalg.solve((a - mean).T @ (a - mean) + alpha**2 * np.eye(a.shape[1]), (a - mean).T @ (b - b.mean(0)))
    return x, b.mean(0) - mean @ x


def relative(predicted, truth, trained):
    mean = truth[trained].mean(0)
    return [np.sqrt(((predicted - truth)[part]**2).sum() / ((truth - mean)[part]**2).sum()) for part in (trained, ~trained)]


def leave_one_out(a, b, alpha):
    squares = 0
    for i in range(len(a)):
        rest = np.arange(len(a)) != i
        x, bias = ridge(a[rest], b[rest], alpha)
        squares += ((a[i] @ x + bias - b[i])**2).sum()
    return np.sqrt(squares / ((b - b.mean(0))**2).sum())


def check_linear(place):
    pose, transfer, trained = read(place("t.vis.h5"))
    figures = fit(place("t.vis.h5"), place("l.transfer.h5"), "--model", "linear", "--holdout", HELD)
    moving = np.ptp(pose[trained], axis=0) > 1e-5
    a, b = pose[trained][:, moving], transfer[trained].reshape(trained.sum(), -1)
    assert figures["angles"] == moving.sum() and figures["constant_angles"] == (~moving).sum(), figures
    with h5py.File(place("l.transfer.h5")) as f:
        weights, alpha = f["transfer/weights"][()].astype(float), f.attrs["alpha"]
        assert (f["transfer/angles"][()] == np.flatnonzero(moving)).all()
    x, bias = ridge(a, b, alpha)
    ours = np.moveaxis(weights, 0, -1).reshape(weights.shape[1], -1)  # [A + 1, V n]
    scale = np.abs(a @ x).max()
    assert np.abs(a @ ours[:-1] + ours[-1] - a @ x - bias).max() < 2e-4 * scale
    assert abs(leave_one_out(a, b, alpha) / figures["leave_one_out_relative_error"] - 1) < 1e-3
    # No other prior of a coarse grid leaves less out.
    largest = figures["largest_singular_value"]
    others = [leave_one_out(a, b, largest * 10**e) for e in np.arange(-5, 1.6, 1.25)]
    assert min(others) > figures["leave_one_out_relative_error"] * 0.999, (others, figures)
    predicted = (pose[:, moving] @ ours[:-1] + ours[-1]).reshape(transfer.shape)
    for found, part in zip(relative(predicted, transfer, trained), ("train", "held_out")):
        assert abs(found / figures[part]["relative_error"] - 1) < 1e-3, (found, figures)
    free = fit(place("t.vis.h5"), place("f.transfer.h5"), "--model", "linear", "--holdout", HELD, "--prior", "0")
    assert free["alpha"] == 0 and free["train"]["relative_error"] <= figures["train"]["relative_error"] + 1e-6
    blocks = fit(place("t.vis.h5"), place("b.transfer.h5"), "--model", "linear", "--holdout", HELD, "--cross-validation", "blocks")
    assert blocks["blocked_relative_error"] <= figures["blocked_relative_error"] + 1e-9


def check_pca(place):
    pose, transfer, trained = read(place("t.vis.h5"))
    figures = fit(place("t.vis.h5"), place("p.transfer.h5"), *PCA, "--holdout", HELD)
    vertices, n = transfer.shape[1:]
    angles = figures["angles"]
    assert n == 36 and figures["paper_bytes"] == 4 * (vertices * 20 + 36 * 7 * 20 + angles * 6), figures
    assert figures["bytes"] == figures["paper_bytes"] + 4 * vertices and figures["paper_mesh_bytes"] == 4 * 36 * vertices
    # The rows that Nowrouzezahrai 2007 stacks: the numbers of all vertices, for each coefficient of each training pose.
    rows = np.moveaxis(transfer[trained], 2, 0).reshape(-1, vertices)
    energies = np.linalg.svd(rows - rows.mean(0), compute_uv=False)**2
    assert abs(energies[:20].sum() / energies.sum() - figures["vertex_variance"]) < 2e-5
    with h5py.File(place("p.transfer.h5")) as f:
        basis, mean, weights = (f["transfer/" + name][()].astype(float) for name in ("basis", "mean", "weights"))
        pose_basis, which = f["transfer/pose_basis"][()].astype(float), f["transfer/angles"][()]
    assert np.abs(basis @ basis.T - np.eye(20)).max() < 1e-4 and np.abs(mean - rows.mean(0)).max() < 1e-5
    scores = pose[:, which] @ pose_basis
    predicted = np.stack([(scores @ weights[c, :-1] + weights[c, -1]) @ basis + mean for c in range(36)], -1)
    for found, part in zip(relative(predicted, transfer, trained), ("train", "held_out")):
        assert abs(found / figures[part]["relative_error"] - 1) < 1e-3, (found, figures)
    run(FIT, "predict", place("p.transfer.h5"), place("t.vis.h5"), "-o", place("p.vis.h5"), "-q")
    with h5py.File(place("p.vis.h5")) as f:
        assert f.attrs["quantity"] == "diffuse_transfer" and f.attrs["sh_order"] == 6
        assert np.abs(f["visibility/coefficients"][()] - predicted).max() < 1e-4 * max(np.abs(predicted).max(), 1)
    info = run(BAKE, "info", place("p.transfer.h5")).stdout
    assert "penumbra.transfer" in info and "outputs" in info, info
    for threads in (1, 8):
        fit(place("t.vis.h5"), place("s.transfer.h5"), *PCA, "--holdout", HELD, "--threads", threads)
        assert digest(place("s.transfer.h5")) == digest(place("p.transfer.h5")), threads


def check_visibility(place):
    """Visibility of order 7 has the transfer of order 6 in it."""
    ours = fit(place("t.vis.h5"), place("x.transfer.h5"), *PCA)
    same = fit(place("v.vis.h5"), place("y.transfer.h5"), *PCA)
    assert abs(ours["train"]["transfer_error"] / same["train"]["transfer_error"] - 1) < 1e-4, (ours, same)


def refuse(words, part, code):
    result = run(FIT, *words, code=code)
    assert part in result.stderr and len(result.stderr.splitlines()) == 1, (words, result.stderr)


def check_refusals(place):
    transfer, out = place("t.vis.h5"), ["-o", place("none.transfer.h5")]
    for words, part in ((["--components", "8"], "--components must be two numbers"),
                        (["--components", "0,22"], "--components must be two numbers"),
                        (["--components", "8,22x"], "--components must be two numbers"),
                        (["--components", "39,22"], "joint angles that change"),
                        (["--components", "4,1431"], "1430 vertices"),
                        (["--components", "4,22", "--model", "linear"], "only --model pca has them"),
                        (["--prior", "-1"], "--prior must be auto or a number of 0 or more"),
                        (["--prior", "nan"], "--prior must be auto"),
                        (["--order", "7"], "--order: 7 needs diffuse_transfer of order 7"),
                        (["--holdout", "nobody"], "no clip 'nobody'")):
        refuse(["transfer", transfer, *out, *words], part, 1)
    refuse(["transfer", place("few.vis.h5"), *out], "training frames, and 8 components of the angles", 1)
    refuse(["transfer", place("low.vis.h5"), *out], "needs hemisphere_visibility of order 7", 1)
    refuse(["transfer", place("sheet.vis.h5"), *out], "need the joint angles of a skeleton", 3)
    still = place("still.vis.h5")
    with open(transfer, "rb") as source, open(still, "wb") as target:
        target.write(source.read())
    with h5py.File(still, "r+") as f:
        f["frames/pose"][...] = 0.5
    refuse(["transfer", still, *out], "all joint angles are constant", 3)
    run(FIT, "transfer", transfer, *out, *PCA, "--dry-run")
    fit(transfer, place("m.transfer.h5"), *PCA)
    refuse(["predict", place("m.transfer.h5"), place("other.vis.h5"), "-o", place("none.vis.h5")], "another character", 3)
    refuse(["predict", place("t.vis.h5"), transfer, "-o", place("none.vis.h5")], "format", 3)
    assert not os.path.exists(out[1]) and not os.path.exists(place("none.vis.h5"))


def main():
    with tempfile.TemporaryDirectory() as folder:
        place = lambda name: os.path.join(folder, name)
        small = ["-q", "--rays", "64"]
        transfer = ["--quantity", "transfer", "--order", "6"]
        run(BAKE, "visibility", MAN, "-o", place("t.vis.h5"), *small, "--fps", 6, *transfer)
        run(BAKE, "visibility", MAN, "-o", place("v.vis.h5"), *small, "--fps", 6, "--order", 7)
        run(BAKE, "visibility", MAN, "-o", place("few.vis.h5"), *small, "--fps", 2, "--clips", "squat", *transfer)
        run(BAKE, "visibility", MAN, "-o", place("low.vis.h5"), *small, "--fps", 2, "--order", 6)
        run(BAKE, "visibility", os.path.join(SAMPLES, "sheet.npz"), "-o", place("sheet.vis.h5"), *small, "--fps", 4, *transfer)
        run(BAKE, "visibility", os.path.join(SAMPLES, "two_skins.glb"), "-o", place("other.vis.h5"), *small, "--fps", 2, *transfer)
        for check in (check_linear, check_pca, check_visibility, check_refusals):
            check(place)
            print(check.__name__, "ok")


main()
