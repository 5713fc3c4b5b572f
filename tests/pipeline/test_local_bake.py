"""penumbra-bake visibility --local: local moments beside the coefficients, the same bytes however the bake is split or
stopped, and refusals of what does not fit.

usage: test_local_bake.py BIN
"""
import json
import os
import signal
import subprocess
import sys
import tempfile
import time

import h5py
import numpy as np

from programs import digest

BIN = os.path.abspath(sys.argv[1])
BAKE = os.path.join(BIN, "penumbra-bake")
SAMPLES = os.path.join(BIN, "..", "samples")
MAN = os.path.join(SAMPLES, "capsule_man.glb")
SHEET = os.path.join(SAMPLES, "sheet.npz")
SMALL = ["--fps", "2", "--rays", "64", "--clips", "squat"]


def run(*words, code=0):
    result = subprocess.run([BAKE, *map(str, words)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    assert result.returncode == code, (words, result)
    return result


def bake(out, *words, rig=MAN, small=SMALL):
    run("visibility", rig, "-o", out, "-q", *small, *words)
    return out


def read(path):
    """Returns the coefficients, the local moments (or None) and their attributes."""
    with h5py.File(path) as f:
        local = f.get("visibility/local")
        return f["visibility/coefficients"][()], None if local is None else local[()], {} if local is None else dict(local.attrs)


def check_content(place):
    """Local moments have their shape and attributes, lie between the whole and the open hemisphere, and leave the
    coefficients as they are."""
    plain, none, _ = read(bake(place("plain.vis.h5")))
    assert none is None
    whole, local, attributes = read(bake(place("local.vis.h5"), "--local"))
    assert attributes == {"steps": 2, "order": 5} and local.shape == whole.shape == (7, 1430, 25), attributes
    assert (whole == plain).all() and (local[..., 0] >= whole[..., 0]).all()
    more = (local[..., 0] > whole[..., 0]).mean()
    assert 0.05 < more < 0.95, more
    assert local[..., 0].max() <= np.sqrt(np.pi) * 1.05  # an open hemisphere, with the error of 64 rays
    # Fewer steps leave more open, and eight steps are the whole man.
    steps = [read(bake(place("s.vis.h5"), "--local", "--local-steps", n))[1] for n in (1, 3, 8)]
    for fewer, further in zip((steps[0], local, steps[1]), (local, steps[1], steps[2])):
        assert (fewer[..., 0] >= further[..., 0]).all()
    assert (steps[2] == whole).all() and (steps[0] != local).any()
    # Order 6 adds coefficients and changes none.
    _, six, attributes = read(bake(place("six.vis.h5"), "--local", "--local-order", 6, "--precision", "f16"))
    assert attributes == {"steps": 2, "order": 6} and six.dtype == np.float16 and six.shape[2] == 36
    assert np.abs(six[..., :25] - local).max() < 2e-3, np.abs(six[..., :25] - local).max()
    options = json.loads(h5py.File(place("six.vis.h5")).attrs["provenance"])["options"]
    assert options["local"] == {"steps": 2, "order": 6}, options
    report = place("info.json")
    run("info", place("six.vis.h5"), "--report", report)
    assert json.load(open(report))["figures"]["local"] == {"steps": 2, "sh_order": 6}
    run("visibility", MAN, "-o", place("x.vis.h5"), *SMALL, "--local", "--dry-run")


def check_splits(place):
    """Threads, shards, an index and a kill change no byte and no number."""
    words = ["--local", "--local-order", 6]
    expected = digest(bake(place("whole.vis.h5"), *words))
    for threads in (2, 8):
        assert digest(bake(place("t.vis.h5"), *words, "--threads", threads)) == expected, threads
    shards = [bake(place(f"s{i}.vis.h5"), *words, "--frames", part) for i, part in enumerate(("0:7:2", "1:7:2"))]
    run("merge", *shards, "-o", place("m.vis.h5"), "-q")
    assert digest(place("m.vis.h5")) == expected
    run("merge", *shards, "-o", place("v.vis.h5"), "-q", "--virtual")
    whole, virtual = read(place("whole.vis.h5")), read(place("v.vis.h5"))
    assert (whole[0] == virtual[0]).all() and (whole[1] == virtual[1]).all() and whole[2] == virtual[2]
    run("info", place("v.vis.h5"))
    # Shards of other local moments do not merge.
    for other in ([], ["--local"], ["--local", "--local-order", 6, "--local-steps", 3]):
        bake(place("o.vis.h5"), *other, "--frames", "1:7:2")
        result = run("merge", shards[0], place("o.vis.h5"), "-o", place("n.vis.h5"), code=3)
        assert "local" in result.stderr and not os.path.exists(place("n.vis.h5")), result.stderr


def check_resume(place):
    """A bake that was killed goes on from local moments too."""
    out = place("r.vis.h5")
    small, words = ["--fps", "16", "--rays", "64", "--clips", "squat"], ["--local", "--local-order", "6"]
    expected = digest(bake(place("e.vis.h5"), *words, small=small))
    frame = 1430 * (25 + 36) * 4 + 8
    process = subprocess.Popen([BAKE, "visibility", MAN, "-o", out, "-q", *small, *words, "--resume"])
    while process.poll() is None and not (os.path.exists(out + ".journal") and os.path.getsize(out + ".journal") > 8 * frame):
        time.sleep(0.002)
    process.send_signal(signal.SIGKILL)
    assert process.wait() == -signal.SIGKILL and not os.path.exists(out)
    report = place("r.json")
    bake(out, *words, "--resume", "--report", report, small=small)
    assert json.load(open(report))["figures"]["frames_resumed"] >= 7 and digest(out) == expected


def check_without_skin(place):
    """On a point cache all triangles of the mesh are local, and the ground is not."""
    small = ["--fps", "4", "--rays", "64"]
    alone = read(bake(place("c.vis.h5"), "--local", "--two-sided", rig=SHEET, small=small))
    assert (alone[0] == alone[1]).all()
    ground = read(bake(place("g.vis.h5"), "--local", "--two-sided", "--ground=-1", rig=SHEET, small=small))
    assert (ground[1] == alone[1]).all() and (ground[0][..., 0] < alone[0][..., 0]).any()


def check_prediction(place):
    """A model of such a bake predicts the whole visibility alone."""
    bake(place("f.vis.h5"), "--local")
    fit = os.path.join(BIN, "penumbra-fit")
    for words in (["visibility", place("f.vis.h5"), "-o", place("f.model.h5"), "--model", "linear", "--clusters", 13],
                  ["predict", place("f.model.h5"), place("f.vis.h5"), "-o", place("p.vis.h5")]):
        subprocess.run([fit, *map(str, words), "-q"], check=True, stdout=subprocess.DEVNULL)
    whole, local, _ = read(place("p.vis.h5"))
    assert whole.shape[1] == 1430 and local is None


def check_refusals(place):
    for words, part in ((["--local-steps", "2"], "--local"), (["--local-order", "5"], "--local"),
                        (["--local", "--local-steps", "9"], "--local-steps must be 1..8"), (["--local", "--local-steps", "0"], "not 0"),
                        (["--local", "--local-order", "4"], "--local-order must be 5..6")):
        result = run("visibility", MAN, "-o", place("x.vis.h5"), *SMALL, *words, code=1)
        assert part in result.stderr and len(result.stderr.splitlines()) == 1, result.stderr


def main():
    with tempfile.TemporaryDirectory() as folder:
        place = lambda name: os.path.join(folder, name)
        for check in (check_content, check_splits, check_resume, check_without_skin, check_prediction, check_refusals):
            check(place)
            print(f"{check.__name__}: ok")


main()
