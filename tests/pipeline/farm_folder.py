"""A farm of synthetic rigs that takes seconds, for the tests of the pipeline."""
import os
import re
import shutil
import subprocess
import sys

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
SCRIPTS = os.path.join(ROOT, "scripts")
FARM = """output: out
defaults: {{fps: 3, shards: {shards}, bake: {{rays: 16}}, fit: {{model: linear, clusters: 2}}}}
rigs:
  bend: {{files: [bend.glb], holdout: [sway]}}
  man: {{files: [capsule_man.glb], holdout: [walk], materials: [clay], lights: [grey]}}
materials:
  clay: {{analytic: lambert}}
  gold: {{analytic: "ggx:alpha=0.4"}}
lights:
  grey: {{analytic: "uniform:radiance=1"}}
  sky: {{analytic: sky}}
pictures: {{frames: 1, size: 32}}
"""


def make_farm(folder, bins, shards=1):
    """Makes FOLDER/farm.yaml and its rigs. The programs of `bins` are used."""
    os.environ["PENUMBRA_BIN"] = os.path.abspath(bins)
    os.makedirs(folder, exist_ok=True)
    for rig in ("bend.glb", "capsule_man.glb"):
        shutil.copy(os.path.join(bins, "..", "samples", rig), folder)
    write(os.path.join(folder, "farm.yaml"), FARM.format(shards=shards))


def write(path, text):
    with open(path, "w") as file:
        file.write(text)


def replace(path, old, new):
    with open(path) as file:
        text = file.read()
    assert old in text, (path, old)
    write(path, text.replace(old, new))


def snakemake(folder, *words, code=0, **more):
    """Runs Snakemake and returns all that it printed."""
    command = ["snakemake", *words, "-s", os.path.join(SCRIPTS, "Snakefile"), "--configfile", "farm.yaml"]
    if "--profile" not in words:
        command.append("-c2")
    result = subprocess.run(command, cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, **more)
    assert result.returncode == code, (words, result.returncode, result.stdout)
    return result.stdout


def outputs_made(text):
    """Returns the outputs of the jobs that Snakemake ran, or would run."""
    return set(re.findall(r"^    output: (\S+)", text, re.M))


def skip_without(*programs):
    for program in programs:
        if not shutil.which(program):
            print(f"skipped: {program} is not installed (scripts/setup installs it)")
            sys.exit(77)
