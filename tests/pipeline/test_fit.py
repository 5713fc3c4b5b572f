"""penumbra-fit visibility and predict as a user runs them, on a bake that is made here."""
import json
import os
import pathlib
import subprocess
import sys
import tempfile

import h5py
import numpy as np

from ribbon_bake import bake_file

BIN = pathlib.Path(sys.argv[1])


def run(*arguments, code=0, says=""):
    done = subprocess.run([BIN / "penumbra-fit", *map(str, arguments)], capture_output=True, text=True)
    message = f"{' '.join(map(str, arguments))}\n{done.stdout}{done.stderr}"
    assert done.returncode == code, f"exit code {done.returncode}, not {code}: {message}"
    assert says in done.stdout + done.stderr, f"'{says}' not in: {message}"
    if code:
        assert done.stderr.count("\n") == 1, f"not one line: {message}"
    return done.stdout


def check_fit_and_predict(folder):
    bake, model, prediction, report = (folder / n for n in ("a.vis.h5", "a.model.h5", "p.vis.h5", "r.json"))
    bake_file(bake)
    fit = ["visibility", bake, "-o", model, "--convention", "A3", "--clusters", 4, "--holdout", "clip1"]
    printed = run(*fit, "--report", report, "--depfile", folder / "d")
    figures = json.loads(report.read_text())["figures"]
    assert figures["clusters"] == 4 and figures["clips"]["clip1"]["held_out"], figures
    for clip in figures["clips"].values():
        assert f"{clip['relative_error']:.4f}" in printed, "the table and the report differ"
    assert figures["held_out"]["relative_error"] < 0.1, figures["held_out"]
    assert str(bake) in (folder / "d").read_text()
    first = model.read_bytes()
    for threads in (1, 3):
        run(*fit, "--threads", threads, "-q")
        assert model.read_bytes() == first, "another run, other bytes"

    run("predict", model, bake, "-o", prediction)
    with h5py.File(bake) as truth, h5py.File(prediction) as predicted:
        assert predicted.attrs["quantity"] == "hemisphere_visibility"
        t, p = truth["visibility/coefficients"][:], predicted["visibility/coefficients"][:]
        assert np.array_equal(truth["frames/bones"][:], predicted["frames/bones"][:])
        rms = np.sqrt(((t - p)[12:24] ** 2).sum(2).mean() / (4 * np.pi))
    assert abs(rms - figures["held_out"]["rms_v"]) < 1e-3 * rms, (rms, figures["held_out"])


def check_errors(folder):
    bake, model, other = folder / "a.vis.h5", folder / "e.model.h5", folder / "other.vis.h5"
    run("visibility", bake, "-o", model, "--convention", "A3", "--holdout", "dance", code=1, says="clip0, clip1, clip2")
    run("visibility", bake, "-o", model, "--convention", "A3", "--clusters", "0", code=1, says="--clusters")
    run("visibility", bake, "-o", model, "--convention", "A3", "--clusters", "999", code=1, says="40 vertices")
    run("visibility", bake, "-o", model, "--convention", "A3", "--input-variance", "1.5", code=1, says="(0, 1]")
    dry = ("visibility", "--convention", "A3", "-o", model, "--dry-run")
    run(*dry, "--holdout", "clip1", bake, says="would fit 36 frames")  # a list takes one word
    run(*dry, "--holdout", ",", bake, code=1, says="--holdout")
    run(*dry, "--holdout", "nope", bake, code=1, says="clip0, clip1, clip2")
    run(*dry, "--holdout", "clip0,clip1,clip2", bake, code=1, says="no clip is left")
    run(*dry, "--clusters", "1000000", bake, code=1, says="40 vertices")
    run("visibility", bake, "-o", model, "--convention", "E3", code=1, says="--convention")
    run("visibility", bake, "-o", model, code=1, says="order 5")  # the default D5 of an order 3 file
    run("visibility", bake, "-o", model, "--wiggle", "3", code=1, says="--wiggle")
    run("visibility", bake, "-o", model, "--model", "magic", code=1, says="--model")
    run("visibility", folder / "none.h5", "-o", model, code=2, says="none.h5")
    run("visibility", bake, "-o", folder / "no/such/e.model.h5", code=2, says="no/such")
    (folder / "empty.h5").write_bytes(b"")
    run("visibility", folder / "empty.h5", "-o", model, code=3, says="empty.h5")
    other.write_bytes(bake.read_bytes())
    with h5py.File(other, "a") as f:
        del f["skin"]
        del f["frames/bones"]
    run("visibility", other, "-o", model, "--convention", "A3", "--features", "joint-angles", code=1, says="dihedral-angles")
    bake_file(other)
    with h5py.File(other, "a") as f:
        f["skin/joint_names"][:] = np.array(["root", "tail"], object)
    run("predict", folder / "a.model.h5", other, "-o", folder / "e.vis.h5", code=3, says="/skin/joint_names")
    left = [p.name for p in folder.iterdir() if p.name.startswith("e.")]
    assert not left, f"left behind: {left}"


with tempfile.TemporaryDirectory() as name:
    os.environ.pop("PENUMBRA_THREADS", None)
    check_fit_and_predict(pathlib.Path(name))
    check_errors(pathlib.Path(name))
print("fit and predict: errors, files, determinism and refusals as documented")
