"""A farm of cloth: numbered .obj files with an occluder, extra inputs, blocks to hold out and both sides, from bake to
page; a changed table of inputs or a changed frame is baked again, and a second run does nothing.

usage: test_cloth_farm.py BIN
"""
import json
import os
import sys
import tempfile

import numpy as np

from farm_folder import outputs_made, replace, skip_without, snakemake, write

BIN = os.path.abspath(sys.argv[1])
FARM = """output: out
rigs:
  sheet:
    files: ["frames/sheet_%02d.obj"]
    holdout: ["sheet#3"]
    shards: 2
    bake: {rays: 16, blocks: 3, two_sided: true, occluder: ["floor.obj:floor.mdd"], inputs: wind.csv, ground: -0.5}
    fit: {model: linear, parts: 3, clusters: 3, output_variance: 0.8}
materials: {clay: {analytic: lambert}}
lights: {grey: {analytic: "uniform:radiance=1"}}
pictures: {frames: 1, size: 32}
"""


def write_frames():
    with np.load(os.path.join(BIN, "..", "samples", "sheet.npz")) as cache:
        verts, faces = cache["verts"], cache["faces"] + 1
    os.mkdir("frames")
    for f, positions in enumerate(verts):
        lines = ["v %.6g %.6g %.6g" % tuple(p) for p in positions] + ["f " + " ".join(map(str, q)) for q in faces]
        write("frames/sheet_%02d.obj" % f, "\n".join(lines) + "\n")
    write("floor.obj", "v -1 -0.2 -1\nv 2 -0.2 -1\nv 2 -0.2 1\nv -1 -0.2 1\nf 4 3 2 1\n")
    with open("floor.mdd", "wb") as cache:  # one frame: it stands still
        np.array([1, 4], ">i4").tofile(cache)
        np.array([0, -1, -0.2, -1, 2, -0.2, -1, 2, -0.2, 1, -1, -0.2, 1], ">f4").tofile(cache)
    write("wind.csv", "frame,wind\n" + "".join("%d,%d\n" % (f, f % 5) for f in range(len(verts))))


skip_without("snakemake")
with tempfile.TemporaryDirectory() as folder:
    os.chdir(folder)
    os.environ["PENUMBRA_BIN"] = BIN
    write_frames()
    write("farm.yaml", FARM)
    snakemake(folder)
    for made in ("index.html", "sheet/sheet.png", "sheet/sheet.pnb", "sheet/sheet.truth.pnb"):
        assert os.path.getsize("out/" + made) > 0, made
    with open("out/sheet/check.json") as report:
        figures = json.load(report)["figures"]
    assert figures, figures
    assert not outputs_made(snakemake(folder, "-n")), "nothing has changed"

    replace("wind.csv", "\n3,3\n", "\n3,4\n")
    again = outputs_made(snakemake(folder))
    assert {"sheet/sheet.vis.h5", "sheet/sheet.model.h5", "sheet/sheet.pnb"} <= again, again
    assert not any(made.startswith(("materials/", "lights/")) for made in again), again
    with open("frames/sheet_04.obj") as file:
        frame = file.read()
    write("frames/sheet_04.obj", frame.replace("v 0 0 ", "v 0.01 0 ", 1))
    assert "sheet/sheet.vis.h5" in outputs_made(snakemake(folder, "-n")), "one frame has changed"

    replace("farm.yaml", "sheet#3", "flag#3")
    said = snakemake(folder, code=1)
    assert "flag" in said, said
    replace("farm.yaml", "frames/sheet_%02d.obj", "frames/flag_%02d.obj")
    said = snakemake(folder, code=1)
    assert "rigs.sheet.files" in said and "no numbered files" in said, said
    os.chdir("/")
print("ok")
