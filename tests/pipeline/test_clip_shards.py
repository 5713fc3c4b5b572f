"""A farm of two rigs that share eight files of clips: one file that changed bakes its own clips again, a renamed one
nothing, and the merged bakes are those of one machine.

usage: test_clip_shards.py BIN
"""
import os
import shutil
import subprocess
import sys
import tempfile

from farm_folder import SCRIPTS, outputs_made, replace, skip_without, snakemake, write
from glb import read_glb, write_glb
from programs import digest

sys.path.insert(0, SCRIPTS)
from farm.config import read_config
from farm.plan import line_of, make_plan

BIN = os.path.abspath(sys.argv[1])
BAKE = os.path.join(BIN, "penumbra-bake")
MAN = os.path.join(BIN, "..", "samples", "capsule_man.glb")
CLIPS = [f"clip{i}" for i in range(8)]
FARM = """output: out
defaults: {fps: 4, shards: 4, holdout: [clip7], bake: {rays: 16, order: 2}, fit: {model: linear, clusters: 2, convention: D2}}
rigs:
  bare: {files: [bare.glb, %(files)s]}
  man: {files: [man.glb, %(files)s], clips: [walk, %(names)s]}
materials: {clay: {analytic: lambert}}
lights: {grey: {analytic: "uniform:radiance=1"}}
pictures: {frames: 1, size: 32}
""" % {"files": ", ".join(f"{name}.glb" for name in CLIPS), "names": ", ".join(CLIPS)}


def write_clip(path, name, source):
    """A file of one clip of the man, under another name."""
    description, rest = read_glb(MAN)
    clip = next(clip for clip in description["animations"] if clip["name"] == source)
    write_glb(path, description | {"animations": [clip | {"name": name}]}, rest)


def make_clip_farm(folder):
    os.environ["PENUMBRA_BIN"] = BIN
    description, rest = read_glb(MAN)
    write_glb(os.path.join(folder, "bare.glb"), {key: value for key, value in description.items() if key != "animations"}, rest)
    write_glb(os.path.join(folder, "man.glb"), description, rest)
    for i, name in enumerate(CLIPS):
        write_clip(os.path.join(folder, name + ".glb"), name, ("wave", "squat", "walk")[i % 3])
    write(os.path.join(folder, "farm.yaml"), FARM)


def bakes(text):
    return sorted(output for output in outputs_made(text) if "/clips/" in output)


def check_same_bytes(folder):
    """The merged bakes are byte for byte those of one process, clips that are left out included."""
    for rig, more in (("bare", []), ("man", ["--clips", "walk," + ",".join(CLIPS)])):
        whole = os.path.join(folder, f"{rig}.vis.h5")
        # Warnings that the bake keeps name the files.
        files = [os.path.join(folder, f"{name}.glb") for name in (rig, *CLIPS)]
        subprocess.run([BAKE, "visibility", *files, *more, "--fps", "4", "--rays", "16", "--order", "2", "-o", whole, "-q"], check=True,
                       stderr=subprocess.DEVNULL)
        assert digest(whole) == digest(os.path.join(folder, "out", rig, f"{rig}.vis.h5")), rig


def check_changes(folder):
    clip = os.path.join(folder, "clip3.glb")
    write_clip(clip, "clip3", "squat")
    text = snakemake(folder)
    made = outputs_made(text)
    assert len(bakes(text)) == 2 and {"bare/bare.vis.h5", "man/man.vis.h5"} <= made, made
    print(f"one clip changed: {len(bakes(text))} bakes of {2 * len(CLIPS) + 1}, {len(made)} jobs in all")
    check_same_bytes(folder)
    # The old shards of this clip are gone with the page that was made after them.
    shards = [name for name in os.listdir(os.path.join(folder, "out", "bare", "clips")) if name.endswith(".vis.h5")]
    assert len(shards) == len(CLIPS), shards


def check_names(folder):
    """A file with the same bytes under another name runs nothing, but for the page, which the YAML file is an
    input of."""
    os.rename(os.path.join(folder, "clip5.glb"), os.path.join(folder, "jump.glb"))
    os.rename(os.path.join(folder, "man.glb"), os.path.join(folder, "hero.glb"))
    yaml = os.path.join(folder, "farm.yaml")
    replace(yaml, "clip5.glb", "jump.glb")
    replace(yaml, "[man.glb", "[hero.glb")
    made = outputs_made(snakemake(folder, "-n"))
    assert made == {"index.html"}, made
    print("two files renamed: the page")


def check_choices(folder):
    """Files whose clips are not baked, tables of inputs and single files leave the split to ranges of frames."""
    rules = lambda: {job.names["rig"]: job.rule for job in make_plan(read_config(os.path.join(folder, "farm.yaml"))).values()
                     if job.rule in ("bake", "shard", "clip")}
    plan = make_plan(read_config(os.path.join(folder, "farm.yaml")))
    assert not any("rm -f" in line_of(job) for job in plan.values())  # queues of commands keep the shards of clips
    shutil.rmtree(os.path.join(folder, "out"))
    yaml = os.path.join(folder, "farm.yaml")
    assert rules() == {"bare": "clip", "man": "clip"}
    replace(yaml, "clips: [walk, clip0, ", "clips: [walk, ")
    assert rules() == {"bare": "clip", "man": "shard"}
    replace(yaml, "shards: 4", "shards: 1")
    assert rules() == {"bare": "bake", "man": "bake"}


skip_without("snakemake")
with tempfile.TemporaryDirectory() as folder:
    make_clip_farm(folder)
    first = snakemake(folder)
    assert len(bakes(first)) == 2 * len(CLIPS) + 1, bakes(first)
    check_same_bytes(folder)
    assert not outputs_made(snakemake(folder, "-n"))
    check_changes(folder)
    check_names(folder)
    check_choices(folder)
