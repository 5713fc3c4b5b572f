"""penumbra-fit visibility and predict as a user runs them, on a bake that is made here."""
import json
import os
import pathlib
import subprocess
import sys
import tempfile

import h5py
import numpy as np

BIN = pathlib.Path(sys.argv[1])


def bake_file(path, clips=3, frames=12):
    """Two bones of a ribbon that bends; visibility of order 3 that follows the angle, with a little noise."""
    random = np.random.default_rng(4)
    rows = 20
    y = np.repeat(np.linspace(0, 1, rows), 2)
    rest = np.stack([np.tile([-0.1, 0.1], rows), y, 0 * y], 1)
    quads = [[2 * r, 2 * r + 1, 2 * r + 2, 2 * r + 1, 2 * r + 3, 2 * r + 2] for r in range(rows - 1)]
    upper = y > 0.5
    count = clips * frames
    angle = 0.8 * np.sin(0.4 * np.arange(count)) + 0.1 * random.normal(size=count)
    bones = np.zeros((count, 2, 3, 4))
    bones[:, :, :3, :3] = np.eye(3)
    c, s = np.cos(angle), np.sin(angle)
    bones[:, 1, 1, 1] = bones[:, 1, 2, 2] = c
    bones[:, 1, 1, 2], bones[:, 1, 2, 1] = -s, s
    bones[:, 1, 1, 3], bones[:, 1, 2, 3] = 0.5 * (1 - c), -0.5 * s
    which = upper.astype(int)
    moved = bones[:, which]  # [F, V, 3, 4]
    positions = np.einsum("fvij,vj->fvi", moved[..., :3], rest) + moved[..., 3]
    normal = np.array([0, 0, 1.0])
    normals = moved[..., :3] @ normal
    moments = random.normal(size=(1, len(rest), 9)) + s[:, None, None] * random.normal(size=(1, len(rest), 9))
    with h5py.File(path, "w") as f:
        f.attrs.update(dict(format="penumbra.visibility", format_version=1, sh_convention="real-orthonormal-cs",
                            sh_order=3, quantity="hemisphere_visibility", frame="model", rays=16, seed=1, bounces=0))
        f.attrs["provenance"] = json.dumps(dict(tool="test", version="0", options={}, inputs=[]))
        f["mesh/triangles"] = np.array(quads, "u4").reshape(-1, 3)
        f["mesh/rest_positions"] = rest.astype("f4")
        f["mesh/rest_normals"] = np.tile(normal, (len(rest), 1)).astype("f4")
        f["mesh/source_vertex"] = np.arange(len(rest), dtype="u4")
        f["skin/joint_names"] = np.array(["root", "tip"], h5py.string_dtype())
        f["skin/parents"] = np.array([-1, 0], "i4")
        f["skin/joints"] = which[:, None].astype("u2")
        f["skin/weights"] = np.ones((len(rest), 1), "f4")
        f["frames/positions"], f["frames/normals"] = positions.astype("f4"), normals.astype("f4")
        f["frames/clip"] = np.repeat(np.arange(clips), frames).astype("u2")
        f["frames/time"] = np.tile(np.arange(frames) / 3.0, clips)
        f["clips/names"] = np.array([f"clip{c}" for c in range(clips)], h5py.string_dtype())
        f["frames/bones"] = bones.astype("f4")
        f["frames/pose"] = np.pad(angle[:, None], [(0, 0), (3, 2)]).astype("f4")
        f["frames/pose"].attrs["parameterisation"] = "joint_rotation_vectors"
        f["visibility/coefficients"] = moments.astype("f4")


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
    run("visibility", other, "-o", model, "--convention", "A3", code=5, says="/skin")
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
