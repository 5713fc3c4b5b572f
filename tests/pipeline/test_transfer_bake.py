"""penumbra-bake visibility --quantity transfer and reference --bounces: the direct transfer and the light that bounces,
the same bytes however the bake is split or stopped, and refusals of what does not fit.

usage: test_transfer_bake.py BIN
"""
import hashlib
import json
import os
import signal
import subprocess
import sys
import tempfile
import time

import h5py
import numpy as np

BIN = os.path.abspath(sys.argv[1])
BAKE = os.path.join(BIN, "penumbra-bake")
SAMPLES = os.path.join(BIN, "..", "samples")
MAN = os.path.join(SAMPLES, "capsule_man.glb")
SHEET = os.path.join(SAMPLES, "sheet.npz")
SMALL = ["--fps", "2", "--rays", "64", "--clips", "squat"]
BOUNCES = ["--quantity", "transfer", "--bounces", "3", "--albedo", "0.8/0.5/0.2"]


def run(*words, code=0, tool=BAKE):
    result = subprocess.run([tool, *map(str, words)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    assert result.returncode == code, (words, result)
    return result


def bake(out, *words, rig=MAN, small=SMALL):
    run("visibility", rig, "-o", out, "-q", *small, *words)
    return out


def digest(path):
    return hashlib.sha256(open(path, "rb").read()).hexdigest()


def read(path):
    """Returns the direct transfer and the indirect one (or None)."""
    with h5py.File(path) as f:
        indirect = f.get("visibility/indirect")
        return f["visibility/coefficients"][()], None if indirect is None else indirect[()]


def times_cosine(b, order):
    """The cosine about +z times moments of order + 1, in the frame of the normal."""
    a = lambda l, m: np.sqrt((l * l - m * m) / (4 * l * l - 1))
    return np.stack([a(l + 1, m) * b[..., (l + 1) * (l + 2) + m] + (a(l, m) * b[..., l * (l - 1) + m] if l > abs(m) else 0)
                     for l in range(order) for m in range(-l, l + 1)], -1)


def check_content(place):
    """Transfer has its attributes and shapes, the direct part is the visibility times the cosine, and each bounce adds
    light, more of it where the albedo is greater."""
    visibility = read(bake(place("v.vis.h5")))[0]
    direct, none = read(bake(place("d.vis.h5"), "--quantity", "transfer"))
    assert none is None and direct.shape == visibility.shape
    with h5py.File(place("d.vis.h5")) as f:
        assert f.attrs["quantity"] == "diffuse_transfer" and f.attrs["bounces"] == 0
        up = f["frames/normals"][()][..., 2] > 0.9999
    assert up.any()
    # Coefficient 0 is a scalar: a rotation about an axis across the normal changes it little.
    near = np.abs(direct[up][:, 0] - times_cosine(visibility[up], 4)[:, 0])
    assert near.max() < 0.02, near.max()
    before = np.zeros(1)
    for bounces in (1, 2, 3):
        found, indirect = read(bake(place("b.vis.h5"), *BOUNCES[:2], "--bounces", bounces, *BOUNCES[4:]))
        assert (found == direct).all() and indirect.shape == (7, 1430, 3, 25)
        mean = indirect[..., 0].mean((0, 1))
        assert mean[0] > mean[1] > mean[2] > 0 and mean[0] > before, mean
        before = mean[0]
    with h5py.File(place("b.vis.h5")) as f:
        assert f.attrs["bounces"] == 3 and np.allclose(f["mesh/albedo"][()], [0.8, 0.5, 0.2])
        shares = f["visibility/hit_shares"][()]
        assert shares.shape == (7, 2) and (shares[:, 0] > 0.05).all() and (shares >= 0).all() and (shares <= 1).all()
    report = place("info.json")
    run("info", place("b.vis.h5"), "--report", report)
    figures = json.load(open(report))["figures"]["light_that_bounces"]
    assert np.allclose(figures["mean_albedo"], [0.8, 0.5, 0.2]) and figures["mean_hit_share"] > 0.05, figures
    said = run("visibility", MAN, "-o", place("b.vis.h5"), *SMALL, *BOUNCES).stdout
    assert "of these hits were backs" in said, said
    run("visibility", MAN, "-o", place("x.vis.h5"), *SMALL, *BOUNCES, "--dry-run")
    half = read(bake(place("h.vis.h5"), *BOUNCES, "--precision", "f16"))[1]
    assert half.dtype == np.float16 and np.abs(half - indirect).max() < 1e-3


def check_splits(place):
    """Threads, shards, an index and a kill change no byte and no number."""
    expected = digest(bake(place("whole.vis.h5"), *BOUNCES))
    for threads in (1, 8):
        assert digest(bake(place("t.vis.h5"), *BOUNCES, "--threads", threads)) == expected, threads
    shards = [bake(place(f"s{i}.vis.h5"), *BOUNCES, "--frames", part) for i, part in enumerate(("0:7:2", "1:7:2"))]
    run("merge", *shards, "-o", place("m.vis.h5"), "-q")
    assert digest(place("m.vis.h5")) == expected
    run("merge", *shards, "-o", place("v.vis.h5"), "-q", "--virtual")
    whole, virtual = read(place("whole.vis.h5")), read(place("v.vis.h5"))
    assert (whole[0] == virtual[0]).all() and (whole[1] == virtual[1]).all()
    run("info", place("v.vis.h5"))
    for other in ([], BOUNCES[:2], [*BOUNCES[:5], "0.3/0.3/0.3"]):
        bake(place("o.vis.h5"), *other, "--frames", "1:7:2")
        result = run("merge", shards[0], place("o.vis.h5"), "-o", place("n.vis.h5"), code=3)
        assert "of different bakes" in result.stderr and not os.path.exists(place("n.vis.h5")), result.stderr


def check_resume(place):
    out = place("r.vis.h5")
    small = ["--fps", "16", "--rays", "64", "--clips", "squat"]
    expected = digest(bake(place("e.vis.h5"), *BOUNCES, small=small))
    frame = 1430 * 100 * 4 + 16
    process = subprocess.Popen([BAKE, "visibility", MAN, "-o", out, "-q", *small, *BOUNCES, "--resume"])
    while process.poll() is None and not (os.path.exists(out + ".journal") and os.path.getsize(out + ".journal") > 8 * frame):
        time.sleep(0.002)
    process.send_signal(signal.SIGKILL)
    assert process.wait() == -signal.SIGKILL and not os.path.exists(out)
    report = place("r.json")
    bake(out, *BOUNCES, "--resume", "--report", report, small=small)
    assert json.load(open(report))["figures"]["frames_resumed"] >= 7 and digest(out) == expected


def check_surfaces(place):
    """Tables give colours by slot or vertex, sheets reflect on both sides and let light through, and occluders are
    black."""
    whole = read(bake(place("w.vis.h5"), *BOUNCES))[1]
    with h5py.File(place("w.vis.h5")) as f:
        slots = [name.decode() if isinstance(name, bytes) else name for name in f["mesh/slots"][()]]
    table = place("colors.csv")
    open(table, "w").write("slot,r,g,b\n" + "".join(f"{slot},0.8,0.5,0.2\n" for slot in slots))
    assert (read(bake(place("t.vis.h5"), *BOUNCES[:5], table))[1] == whole).all()
    open(table, "w").write("vertex,r,g,b\r\n" + "".join(f"{v},0.8,0.5,0.2\r\n" for v in range(1430)))
    assert (read(bake(place("t.vis.h5"), *BOUNCES[:5], table))[1] == whole).all()
    sheet = ["--fps", "4", "--rays", "64", "--two-sided"]
    reflected = read(bake(place("c.vis.h5"), *BOUNCES, rig=SHEET, small=sheet))[1]
    through = read(bake(place("m.vis.h5"), *BOUNCES, "--transmission", "0.1/0.3/0.3", rig=SHEET, small=sheet))[1]
    with h5py.File(place("m.vis.h5")) as f:
        assert f["visibility/hit_shares"][()][:, 1].max() == 0 and "mesh/transmission" in f
    assert through[..., 0].mean() > reflected[..., 0].mean() > 0
    run("visibility", SHEET, "-o", place("o.vis.h5"), "-q", *sheet, *BOUNCES, "--occluder", SHEET)


def check_picture(place):
    """Reflections add light, the same for any number of threads, with the albedo of the bake or of --albedo."""
    picture = ["--frame", 3, "--size", "24x24", "--samples", 16, "-q"]
    file = bake(place("p.vis.h5"), *BOUNCES)
    run("reference", file, *picture, "-o", place("direct.exr"))
    run("reference", file, *picture, "--bounces", 2, "-o", place("a.exr"))
    assert digest(place("a.exr")) != digest(place("direct.exr"))
    run("reference", file, *picture, "--bounces", 2, "--threads", 1, "-o", place("b.exr"))
    run("reference", bake(place("q.vis.h5")), *picture, "--bounces", 2, "--albedo", "0.8/0.5/0.2", "-o", place("c.exr"))
    assert digest(place("a.exr")) == digest(place("b.exr")) == digest(place("c.exr"))
    result = run("reference", place("q.vis.h5"), *picture, "--bounces", 2, "-o", place("d.exr"), code=1)
    assert "--bounces needs --albedo" in result.stderr, result.stderr


def check_picture_through(place):
    """Paths go through the sheets of a bake with transmission: more light, with any material, the same for any number
    of threads. --albedo may not make the sheet give back more than it gets."""
    picture = ["--frame", 3, "--size", "24x24", "--samples", 64, "--bounces", 2, "-q"]
    sheet = ["--fps", "4", "--rays", "64", "--two-sided"]
    opaque = bake(place("o.vis.h5"), *BOUNCES, rig=SHEET, small=sheet)
    thin = bake(place("n.vis.h5"), *BOUNCES, "--transmission", "0.2/0.5/0.8", rig=SHEET, small=sheet)
    membrane = ["--brdf", "membrane:rho=0.8/0.5/0.2,tau=0.2/0.5/0.8"]
    for material in ([], membrane):
        run("reference", opaque, *picture, *material, "-o", place("o.exr"))
        run("reference", thin, *picture, *material, "-o", place("n.exr"))
        run("reference", thin, *picture, *material, "--threads", 1, "-o", place("m.exr"))
        assert digest(place("n.exr")) == digest(place("m.exr")) != digest(place("o.exr"))
    run("reference", thin, *picture, "--albedo", "0.8/0.5/0.2", *membrane, "-o", place("m.exr"))
    assert digest(place("n.exr")) == digest(place("m.exr"))
    refuse(["reference", thin, *picture, "--albedo", "0.9/0.5/0.2", "-o", place("x.exr")], "--albedo: " + thin + " has transmission 0.2", 1)
    refuse(["reference", opaque, *picture, "--brdf", "membrane:rho=0.5,tau=0.3,back=open", "-o", place("x.exr")], "back=open", 5)


def refuse(words, part, code, tool=BAKE):
    result = run(*words, code=code, tool=tool)
    assert part in result.stderr and len(result.stderr.splitlines()) == 1, (words, result.stderr)


def check_refusals(place):
    table = place("bad.csv")
    transfer = ["--quantity", "transfer", "--bounces", "1"]
    for words, part in ((["--bounces", "1"], "--bounces needs --quantity transfer"),
                        ([*transfer[:3], "17", "--albedo", "0/0/0"], "--bounces must be 0..16"),
                        ([*transfer[:2], "--albedo", "0.5/0.5/0.5"], "--bounces"),
                        ([*transfer, "--albedo", "1/0.5/0.5"], "not in [0, 1)"),
                        ([*transfer, "--albedo", "0.5/0.5/0.5", "--transmission", "0.1/0.1/0.1"], "not two-sided"),
                        ([*transfer, "--albedo", "0.5/0.5/0.5", "--transmission", "0.6/0/0", "--two-sided"], "not in [0, 1 - albedo]"),
                        ([*transfer[:2], "--local"], "--local needs --quantity visibility")):
        refuse(["visibility", MAN, "-o", place("x.vis.h5"), *SMALL, *words], part, 1)
    refuse(["visibility", SHEET, "-o", place("x.vis.h5"), *transfer], "--albedo: is needed", 1)
    for text, part in (("", "has no colours"), ("a,b\n", "slot,r,g,b or vertex,r,g,b"), ("slot,r,g,b\n", "has no colours"), ("slot,r,g,b\nnobody,0,0,0\n", "nobody"),
                       ("vertex,r,g,b\n0,0,0\n", "fewer than 4 fields"), ("vertex,r,g,b\n0,0,0,nan\n", "'nan' is not a number"),
                       ("vertex,r,g,b\n0,0,0,0.5x\n", "is not a number"), ("vertex,r,g,b\n9999,0,0,0\n", "is not in 0..1429"),
                       ("vertex,r,g,b\n0,0,0,0\n", "has no colour for vertex 1")):
        open(table, "w").write(text)
        refuse(["visibility", MAN, "-o", place("x.vis.h5"), *SMALL, *transfer, "--albedo", table], part, 3)
    open(table, "w").write("vertex,r,g,b\n" + "".join(f"{v},-0.1,0,0\n" for v in range(1430)))
    refuse(["visibility", MAN, "-o", place("x.vis.h5"), *SMALL, *transfer, "--albedo", table], "not in [0, 1)", 1)
    refuse(["visibility", MAN, "-o", place("x.vis.h5"), *SMALL, *transfer, "--albedo", place("none.csv")], "cannot read", 2)
    refuse(["visibility", MAN, "-o", place("x.vis.h5"), *SMALL, *transfer, "--albedo", "0.5/0.5"], "is not a colour R/G/B", 2)
    assert not os.path.exists(place("x.vis.h5"))


def check_consumers(place):
    """A program that reads visibility alone refuses transfer in one line, and so does the comparison of models of a
    higher order."""
    file = bake(place("t.vis.h5"), *BOUNCES)
    fit, pack = os.path.join(BIN, "penumbra-fit"), os.path.join(BIN, "penumbra-pack")
    refuse(["visibility", file, "-o", place("t.model.h5")], "quantity", 3, fit)
    refuse(["compare", file, "--holdout", "squat", "-o", place("t.html")], "--order", 1, fit)
    run("truth", file, "-o", place("t.pnb"), tool=pack)
    damaged = place("damaged.vis.h5")
    for dataset, value in (("mesh/albedo", 1.5), ("visibility/indirect", np.nan)):
        with open(file, "rb") as source, open(damaged, "wb") as target:
            target.write(source.read())
        with h5py.File(damaged, "r+") as f:
            f[dataset][0] = value
        refuse(["merge", damaged, "-o", place("x.vis.h5")], dataset, 3)


def main():
    with tempfile.TemporaryDirectory() as folder:
        place = lambda name: os.path.join(folder, name)
        for check in (check_content, check_splits, check_resume, check_surfaces, check_picture, check_picture_through, check_refusals, check_consumers):
            check(place)
            print(f"{check.__name__}: ok")


main()
