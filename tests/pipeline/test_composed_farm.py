"""A farm of composed models: fields are a job of their own whatever runs the farm, and run again when they must; what does not go
with a composed model is refused before any job.

usage: test_composed_farm.py BIN
"""
import os
import subprocess
import sys
import tempfile

import h5py

from farm_folder import SCRIPTS, make_farm, outputs_made, replace, skip_without, snakemake, write

sys.path.insert(0, SCRIPTS)
from farm.config import ConfigError, read_config
from farm.plan import make_plan

BIN = os.path.abspath(sys.argv[1])
FARM = """output: out
defaults: {fps: 3, bake: {rays: 16}, fields: {rays: 16, cells: 4}, fit: {model: composed, local_model: linear, clusters: 2}}
rigs:
  man: {files: [capsule_man.glb], holdout: [walk], shards: 2}
materials: {clay: {analytic: lambert}}
lights: {grey: {analytic: "uniform:radiance=1"}}
pictures: {frames: 1, size: 32}
"""
LINEAR = FARM.replace("rigs:\n", "rigs:\n  bend: {files: [bend.glb], holdout: [sway], fit: {model: linear}}\n")
FIELDS, VIS, MODEL = "man.man.fields.h5", "man.man.vis.h5", "man.man.model.h5"


def run(*words, code=0, env=None):
    result = subprocess.run(words, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, env=env)
    assert result.returncode == code, (words, result.returncode, result.stdout)
    return result.stdout


def report_times():
    folder = "out/reports"
    names = os.listdir(folder) if os.path.isdir(folder) else []
    return {name.removesuffix(".json"): os.stat(os.path.join(folder, name)).st_mtime_ns for name in names}


def ran_by(*command):
    """Returns the outputs of the jobs that a command ran, as their reports are named."""
    before = report_times()
    run(*command)
    return {name for name, time in report_times().items() if before.get(name) != time}


def check_ninja():
    """Makes everything, then nothing, and after a change only what it changes."""
    run(os.path.join(SCRIPTS, "farm", "farm_ninja"), "farm.yaml")
    made = ran_by("ninja", "-C", "out")
    assert {FIELDS, VIS, MODEL, "man.man.pnb", "man.sheet.png", "index.html"} <= made, made
    with h5py.File("out/man/man.vis.h5") as bake, h5py.File("out/man/man.model.h5") as model:
        assert "visibility/local" in bake and "composition" in model
    with open("out/index.html") as page:
        assert 'href="man/man.fields.h5"' in page.read()
    assert ran_by("ninja", "-C", "out") == set()
    ninja = ["ninja", "-C", "out", "man/man.model.h5"]
    replace("farm.yaml", "cells: 4", "cells: 5")
    ran = ran_by(*ninja)
    assert ran == {FIELDS, MODEL}, ran
    replace("farm.yaml", "local_model: linear", "local_model: quadratic")
    ran = ran_by(*ninja)
    assert ran == {MODEL}, ran
    with open("capsule_man.glb", "ab") as rig:
        rig.write(b" " * 4)
    ran = ran_by("ninja", "-C", "out")
    assert {FIELDS, VIS, MODEL, "index.html"} <= ran and "materials.clay.brdf.h5" not in ran, ran
    print(f"ninja: {len(made)} jobs; the rig changed, {len(ran)}")


def check_others():
    """What ninja made is current for make, job arrays and Snakemake; other options of the fields are not."""
    run(os.path.join(SCRIPTS, "farm", "farm_ninja"), "farm.yaml", "--make")
    assert ran_by("make", "-C", "out", "-j2") == set()
    array = os.path.join(SCRIPTS, "farm", "slurm", "farm_array")
    assert "nothing to do" in run(array, "farm.yaml")
    replace("farm.yaml", "bake: {rays: 16}", "bake: {local: true, rays: 16}")  # which composed implies
    assert outputs_made(snakemake(".", "-n")) == {"index.html"}, "the page follows the file"
    replace("farm.yaml", "cells: 5", "cells: 6")
    text = snakemake(".", "-n")
    wanted = {"man/man.fields.h5", "man/man.model.h5", "man/man.pnb", "man/check.json", "man/sheet.png", "index.html"}
    assert outputs_made(text) == wanted, text
    assert "farm: man/man.model.h5: follows man/man.fields.h5: made with other options" in text, text
    ran = ran_by("make", "-C", "out", "man/man.model.h5")
    assert ran == {FIELDS, MODEL}, ran
    replace("farm.yaml", "cells: 6", "cells: 7")
    check_array(array)
    run(os.path.join(SCRIPTS, "farm", "farm_ninja"), "farm.yaml", "--lists")
    with open("out/lists/03-fields.txt") as lines:
        assert len(lines.readlines()) == 1


def check_belonging():
    """farm_check knows files of fields."""
    check = os.path.join(SCRIPTS, "farm", "farm_check")
    text = run(check, "out/man/man.fields.h5", "out/man/man.model.h5", "capsule_man.glb")
    assert text == "2 inputs compared, 0 disagree\n", text
    with open("capsule_man.glb", "ab") as rig:
        rig.write(b" " * 4)
    text = run(check, "out/man/man.fields.h5", "capsule_man.glb", code=3)
    assert "out/man/man.fields.h5: made from another capsule_man.glb" in text, text


def check_array(array):
    """The array of the fit waits for that of the fields."""
    os.mkdir("fake")
    write("fake/sbatch", f'#!/bin/sh\necho "$@" >>{os.getcwd()}/asked\nwc -l <{os.getcwd()}/asked\n')
    os.chmod("fake/sbatch", 0o755)
    text = run(array, "farm.yaml", env={**os.environ, "PATH": os.path.abspath("fake") + ":" + os.environ["PATH"]})
    assert text.startswith("fields: 1 tasks, array 1\nfit: 1 tasks, array 2, after 1\n"), text
    os.remove("out/.farm/submitted.json")


def check_other_models():
    """A rig whose model is another has no fields and no local moments, whatever `defaults` say of composed ones."""
    write("farm.yaml", LINEAR)
    plan = make_plan(read_config("farm.yaml"))
    assert "man/man.fields.h5" in plan and "bend/bend.fields.h5" not in plan, plan.keys()
    assert all("--local" in plan[shard].command for shard in plan["man/man.vis.h5"].inputs)
    assert "--local" not in plan["bend/bend.vis.h5"].command
    assert not {"--fields", "--local-model"} & set(plan["bend/bend.model.h5"].command)


def check_chosen_poses():
    """The bake of a rig with `poses: auto` follows the choice of its poses, and has the held-out clips beside them."""
    write("farm.yaml", FARM.replace("[walk], shards: 2", "[walk], bake: {poses: auto}, clips: [walk, wave]"))
    plan = make_plan(read_config("farm.yaml"))
    listed, bake = plan["man/man.poses.h5"], plan["man/man.vis.h5"]
    words = " ".join(listed.command)
    assert "--clips walk,wave --fps 3 --holdout walk --auto --minutes 60 --rays 16" in words, words
    words = " ".join(bake.command)
    assert "--clips walk --fps 3 --rays 16 --poses man/man.poses.h5 --local --resume" in words, words
    assert bake.inputs == ["man/man.poses.h5"] and list(plan).index("man/man.poses.h5") < list(plan).index("man/man.vis.h5")


def check_refusals():
    """Mistakes are named before any job."""
    write("farm.yaml", LINEAR)
    sheet = os.path.join(BIN, "..", "samples", "sheet.npz")
    cases = [
        ("[walk], shards: 2", "[walk], shards: 2, bake: {poses: auto}", "rigs.man.bake.poses: auto takes shards: 1, not 2"),
        ("[walk], shards: 2", "['walk#1'], bake: {poses: auto, blocks: 2}", "rigs.man.bake.poses: auto does not go with blocks"),
        ("[walk], shards: 2", "[walk], bake: {poses: autos}", "rigs.man.bake.poses: no such file"),
        ("[walk], shards: 2", "[walk], bake: {local: false}", "rigs.man.bake.local: model composed needs local moments"),
        ("linear, clusters", "linear, convention: A4, clusters", "rigs.man.fit.convention: model composed takes convention D, not A4"),
        ("linear, clusters", "linear, convention: B5, clusters", "rigs.man.fit.convention: model composed takes convention D, not B5"),
        ("rays: 16}, fields: {rays: 16, cells: 4}, fit: {", "rays: 16, order: 6}, fit: {convention: D6, ",
         "rigs.man.fit.convention: D6 needs local moments of order 6; bake.local_order is 5"),
        ("[capsule_man.glb], holdout: [walk]", f"[{sheet}], holdout: ['sheet#3'], bake: {{blocks: 3}}",
         "rigs.man.fit.model: composed needs a rig of several parts; sheet.npz is a single one"),
        ("cells: 4", "cells: 400", "rigs.man.fields: penumbra-bake: --cells must be 4..64 points along a side, not 400"),
        ("cells: 4", "megabyte: 4", "defaults.fields.megabyte: no such key; did you mean megabytes?"),
        ("fit: {model: linear}}", "fit: {model: linear}, fields: {rays: 32}}", "rigs.bend.fields: only fit: {model: composed} reads them"),
        ("{model: linear}", "{model: linear, local_model: linear}", "rigs.bend.fit.local_model: only model composed has one"),
        ("local_model: linear", "local_model: composed", "defaults.fit.local_model: takes one of linear, quadratic, neural, additive"),
    ]
    for old, new, says in cases:
        replace("farm.yaml", old, new)
        try:
            make_plan(read_config("farm.yaml"))
            assert False, ("taken", new)
        except ConfigError as error:
            assert says in str(error), (says, str(error))
        write("farm.yaml", LINEAR)
    print(f"{len(cases)} mistakes are named")


skip_without("snakemake", "ninja", "make")
with tempfile.TemporaryDirectory() as folder:
    os.chdir(folder)
    make_farm(folder, BIN)
    write("farm.yaml", FARM)
    check_ninja()
    check_others()
    check_belonging()
    check_other_models()
    check_chosen_poses()
    check_refusals()
    os.chdir("/")
print("composed models on a farm: ok")
