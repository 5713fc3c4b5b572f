"""Sphere blockers as a user makes them: fit, info, pack, check; bad input.

usage: test_blockers.py BIN
"""
import json
import os
import sys
import tempfile

import h5py
import numpy as np

from programs import must, run

BIN = sys.argv[1]
BAKE, FIT, PACK = (os.path.join(BIN, "penumbra-" + name) for name in ("bake", "fit", "pack"))
SAMPLES = os.path.join(BIN, "..", "samples")


def refused(code, part, *words):
    result = run(*words)
    assert result.returncode == code and part in result.stderr, (words, result.returncode, result.stderr)
    assert result.stderr.count("\n") == 1, result.stderr


def content(path):
    with open(path, "rb") as file:
        return file.read()


def figures(*words):
    must(*words, "--report", "r.json")
    with open("r.json") as file:
        return json.load(file)["figures"]


def make_model(rig, name):
    must(BAKE, "visibility", os.path.join(SAMPLES, rig), "-o", name + ".vis.h5", "--fps", 4, "--rays", 32, "--order", 2)
    must(FIT, "visibility", name + ".vis.h5", "-o", name + ".model.h5", "--model", "linear", "--clusters", 2,
         "--convention", "A2")


def check_fit():
    """15 spheres with the mesh's silhouettes, two on each leg's end, the same bytes for any number of threads."""
    fit = figures(FIT, "blockers", "man.model.h5", "-o", "man.blockers.h5", "--spheres", 15)
    assert fit["spheres"] == 15 and abs(fit["area"] / fit["mesh_area"] - 1) < 1e-5, fit
    assert 0.8 < fit["scale"] < 1.2 and fit["silhouette_error"] < 0.15, fit
    assert sorted(foot["joint"] for foot in fit["feet"]) == ["shin.L", "shin.R"], fit
    assert all(foot["spheres"] >= 2 for foot in fit["feet"]), fit
    for threads in (1, 3):
        must(FIT, "blockers", "man.model.h5", "-o", "again.blockers.h5", "--spheres", 15, "--threads", threads, "-q")
        assert content("again.blockers.h5") == content("man.blockers.h5"), threads
    with h5py.File("man.blockers.h5") as f, h5py.File("man.model.h5") as model:
        assert f.attrs["format"] == "penumbra.blockers" and f.attrs["format_version"] == 1
        provenance = json.loads(f.attrs["provenance"])
        assert provenance["options"] == {"spheres": 15, "method": "area", "seed": 1}, provenance
        assert f["blockers/center"].shape == (15, 3) and f["blockers/radius"].shape == (15,)
        rest = model["mesh/rest_positions"][:]
        assert (f["blockers/center"][:] > rest.min(0)).all() and (f["blockers/center"][:] < rest.max(0)).all()
    paper = figures(FIT, "blockers", "man.model.h5", "-o", "paper.blockers.h5", "--method", "paper")
    # Spheres that hold the vertices stick out; 1.6 was measured.
    assert paper["scale"] == 1 and paper["area"] > 1.3 * paper["mesh_area"], paper
    assert "would fit 7 spheres" in must(FIT, "blockers", "man.model.h5", "-o", "dry.blockers.h5", "--spheres", 7,
                                         "--dry-run")
    assert not os.path.exists("dry.blockers.h5")


def check_asset():
    """The asset has the spheres of the file, in 300 bytes; without them it has the bytes that it always had."""
    must(PACK, "asset", "man.model.h5", "-o", "plain.pnb")
    packed = figures(PACK, "asset", "man.model.h5", "--blockers", "man.blockers.h5", "-o", "man.pnb")
    assert packed["blockers"] == 15 and packed["bytes"]["blockers"] <= 300, packed
    assert os.path.getsize("man.pnb") - os.path.getsize("plain.pnb") < 800  # the provenance has one more input
    of_file, of_asset = figures(BAKE, "info", "man.blockers.h5"), figures(BAKE, "info", "man.pnb")
    assert of_file["format"] == "penumbra.blockers" and len(of_file["blockers"]) == 15, of_file
    assert of_asset["blockers"] == of_file["blockers"], of_asset
    assert "blockers" not in figures(BAKE, "info", "plain.pnb")
    assert figures(PACK, "check", "man.pnb", "man.vis.h5")["blockers"] == 15
    assert "blockers" not in figures(PACK, "check", "plain.pnb", "man.vis.h5")
    names = [given["name"] for given in of_asset["provenance"]["inputs"]]
    assert names == ["man.model.h5", "man.blockers.h5"], names


def damaged(name, value):
    """A copy of the blockers with other numbers in one dataset."""
    path = "damaged.blockers.h5"
    with open(path, "wb") as file:
        file.write(content("man.blockers.h5"))
    with h5py.File(path, "r+") as f:
        numbers = f[name][:]
        numbers[2] = value
        f[name][...] = numbers
    return path


def check_refusals():
    fit = (FIT, "blockers", "man.model.h5", "-o", "x.blockers.h5")
    refused(1, "--spheres must be 1..64, not 0", *fit, "--spheres", 0)
    refused(1, "--spheres must be 1..64, not 65", *fit, "--spheres", 65)
    refused(1, "--seed must be 0..", *fit, "--seed", -1)
    refused(1, "--method", *fit, "--method", "best")
    refused(3, "man.vis.h5", FIT, "blockers", "man.vis.h5", "-o", "x.blockers.h5")
    pack = (PACK, "asset", "man.model.h5", "-o", "x.pnb", "--blockers")
    refused(3, "another character", PACK, "asset", "bend.model.h5", "-o", "x.pnb", "--blockers", "man.blockers.h5")
    refused(3, "man.model.h5", *pack, "man.model.h5")
    refused(3, "/blockers/radius", *pack, damaged("blockers/radius", -0.1))
    refused(3, "/blockers/radius", *pack, damaged("blockers/radius", np.nan))
    refused(3, "/blockers/center", *pack, damaged("blockers/center", np.inf))
    refused(3, "/blockers/joint", *pack, damaged("blockers/joint", 13))
    refused(1, "--blockers: needs a model", PACK, "asset", "--brdf", "clay.brdf.h5", "-o", "x.pnb", "--blockers",
            "man.blockers.h5")
    assert not os.path.exists("x.pnb") and not os.path.exists("x.blockers.h5")


def check_cloth():
    """A mesh without a skeleton: its spheres move with its near-rigid parts."""
    make_model("sheet.npz", "sheet")
    fit = figures(FIT, "blockers", "sheet.model.h5", "-o", "sheet.blockers.h5", "--spheres", 6)
    assert fit["spheres"] == 6 and fit["feet"] == [], fit
    must(PACK, "asset", "sheet.model.h5", "--blockers", "sheet.blockers.h5", "-o", "sheet.pnb")
    assert len(figures(BAKE, "info", "sheet.pnb")["blockers"]) == 6


with tempfile.TemporaryDirectory() as folder:
    BIN, SAMPLES = os.path.abspath(BIN), os.path.abspath(SAMPLES)
    BAKE, FIT, PACK = (os.path.abspath(program) for program in (BAKE, FIT, PACK))
    os.chdir(folder)
    make_model("capsule_man.glb", "man")
    make_model("bend.glb", "bend")
    must(FIT, "brdf", "--analytic", "lambert", "-o", "clay.brdf.h5")
    check_fit()
    check_asset()
    check_refusals()
    check_cloth()
    os.chdir("/")
print("sphere blockers: ok")
