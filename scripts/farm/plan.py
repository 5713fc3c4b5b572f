"""Every job of a farm's YAML file: what it reads, what it writes, its command. Snakefile, farm_ninja and slurm/farm_array
run this one list, so that none of them knows an option of a program."""
import json
import os
import re
import shlex
import subprocess
import sys
from dataclasses import dataclass
from urllib.parse import unquote

from farm.config import ROOT, ConfigError
from farm.stamps import Digests, label, tool_version, write_whole

SCRIPTS = os.path.join(ROOT, "scripts")


@dataclass
class Job:
    rule: str
    output: str          # relative to the farm's folder, where all commands run
    command: list        # words
    inputs: list         # outputs of other jobs
    sources: list        # files from outside, absolute
    names: dict          # what the wildcards of PATTERNS stand for
    temporary: bool = False  # not kept once it was read
    depfile: str = ""    # where the command lists further files that it read


# Where each rule writes. A rig in one piece is baked where the merged file of others stands.
PATTERNS = {
    "bake": "{rig}/{rig}.vis.h5", "shard": "{rig}/shards/{range}.vis.h5", "merge": "{rig}/{rig}.vis.h5",
    "fit": "{rig}/{rig}.model.h5", "brdf": "materials/{material}.brdf.h5", "light": "lights/{light}.light.h5",
    "pack": "{rig}/{rig}.pnb", "truth": "{rig}/{rig}.truth.pnb", "check": "{rig}/check.json", "sheet": "{rig}/sheet.png",
    "index": "index.html"}


# No job reads from one of a later rule.
ORDER = ("brdf", "light", "bake", "shard", "merge", "fit", "truth", "pack", "check", "sheet", "index")


def options(values):
    """{"max_error": 0.1, "ground": True} as words of a command line."""
    words = []
    for key, value in values.items():
        if value is False:
            continue
        words.append("--" + key.replace("_", "-"))
        if value is not True:
            words.append(",".join(value) if isinstance(value, list) else str(value))
    return words


def report_of(output):
    """Where the report of the job that makes `output` lies."""
    return output if output.endswith("check.json") else f"reports/{output.replace('/', '.')}.json"


def buffers_of(path):
    """The files that a .gltf names; --dry-run of the bake, which knows them too, writes no --depfile."""
    if not path.lower().endswith(".gltf"):
        return []
    try:
        with open(path) as file:
            names = [buffer.get("uri", "data:") for buffer in json.load(file).get("buffers", [])]
    except (ValueError, AttributeError):  # the bake says what is wrong with it
        return []
    found = [os.path.join(os.path.dirname(path), unquote(name)) for name in names if not name.startswith("data:")]
    return [file for file in found if os.path.isfile(file)]


class Planner:
    def __init__(self, farm):
        self.farm = farm
        self.jobs = {}  # output -> Job, in an order that can be run

    def program(self, name):
        return os.path.join(self.farm.programs, name) if self.farm.programs else name

    def add(self, rule, names, command, inputs=(), sources=(), **more):
        output = PATTERNS[rule].format(**names)
        if command[0] == self.program("penumbra-bake"):
            more["depfile"] = output + ".d"
            command = [*command, "--depfile", output + ".d"]
        command = [*command, "--report", report_of(output)]
        if rule != "check":
            command += ["-o", output]
        self.jobs[output] = Job(rule, output, command, list(inputs), list(sources), names, **more)
        return output

    # --- jobs of one rig

    def bake(self, name, rig):
        words = [self.program("penumbra-bake"), "visibility", *rig["files"],
                 *options({key: rig[key] for key in ("clips", "fps") if key in rig}), *options(rig["bake"])]
        files = [*rig["files"], *([rig["bake"]["poses"]] if "poses" in rig["bake"] else [])]
        shards = rig.get("shards", 1)
        if shards == 1:
            return self.add("bake", {"rig": name}, [*words, "--resume"], sources=files)
        frames = self.frames(name, words, files)
        edges = [frames * i // shards for i in range(shards + 1)]
        parts = [self.add("shard", {"rig": name, "range": f"{a:06}-{b:06}"}, [*words, "--frames", f"{a}:{b}", "--resume"],
                          sources=files, temporary=True) for a, b in zip(edges, edges[1:]) if a < b]
        return self.add("merge", {"rig": name}, [self.program("penumbra-bake"), "merge", *parts], parts)

    def frames(self, name, words, files):
        """How many frames a bake has: asked of the program once, and remembered by its version and the content of its files."""
        memory = os.path.join(self.farm.output, ".farm", "frames.json")
        digests = Digests(self.farm.output)
        read = [*files, *(buffer for file in files for buffer in buffers_of(file))]
        key = json.dumps([tool_version(words), [label(word) for word in words[1:]], [digests.of(file) for file in read]])
        digests.save()
        known = {}
        if os.path.exists(memory):
            with open(memory) as file:
                known = json.load(file)
        if key not in known:
            result = subprocess.run([*words, "-o", os.path.join(self.farm.output, ".farm", "probe.vis.h5"), "--dry-run"],
                                    capture_output=True, text=True)
            found = re.search(r"(\d+) frames", result.stdout)
            if result.returncode != 0 or not found:
                raise ConfigError(f"rigs.{name}: {result.stderr.strip() or 'the bake does not say how many frames it has'}")
            known[key] = int(found[1])
            write_whole(memory, json.dumps(known, indent=1))
        return known[key]

    def rig(self, name, rig):
        bake, fit, pack = (self.program(f"penumbra-{p}") for p in ("bake", "fit", "pack"))
        names, holdout = {"rig": name}, options({"holdout": rig["holdout"]})
        vis = self.bake(name, rig)
        train_frames = [rig["fit"]["train_frames"]] if "train_frames" in rig["fit"] else []
        model = self.add("fit", names, [fit, "visibility", vis, *holdout, *options(rig["fit"])], [vis], train_frames)
        brdfs = [f"materials/{m}.brdf.h5" for m in rig["materials"]]
        lights = [f"lights/{l}.light.h5" for l in rig["lights"]]
        given = {key: value for key, value in rig["pack"].items() if key != "slot"}
        slots = [word for slot, m in rig["pack"].get("slot", {}).items() for word in ("--slot", f"{slot}={m}")]
        looks = [word for kind, files in (("--brdf", brdfs), ("--light", lights)) for f in files for word in (kind, f)]
        asset = self.add("pack", names, [pack, "asset", model, *looks, *options(given), *slots], [model, *brdfs, *lights])
        truth = self.add("truth", names, [pack, "truth", vis, *options({"clips": rig["holdout"]})], [vis])
        self.add("check", names, [pack, "check", asset, vis, "--model", model], [asset, vis, model])
        script = os.path.join(SCRIPTS, "farm_sheet.py")
        self.add("sheet", names, [sys.executable, script, self.program("penumbra-player"), bake, asset, truth,
                                  *looks[2 * len(brdfs):], *options(self.farm.pictures)], [asset, truth, *lights], [script])

    # --- what rigs share

    def material(self, name, material):
        files = [material[kind] for kind in ("merl", "table") if kind in material]
        self.add("brdf", {"material": name}, [self.program("penumbra-fit"), "brdf", *options(material), "--name", name],
                 sources=files)

    def light(self, name, light):
        picture = [light["picture"]] if "picture" in light else []
        rest = {key: value for key, value in light.items() if key != "picture"}
        self.add("light", {"light": name}, [self.program("penumbra-fit"), "light", *picture, *options(rest), "--name", name],
                 sources=picture)


def make_plan(farm):
    """Jobs by output, each after those that it reads from."""
    planner = Planner(farm)
    for name, material in farm.materials.items():
        planner.material(name, material)
    for name, light in farm.lights.items():
        planner.light(name, light)
    for name, rig in farm.rigs.items():
        planner.rig(name, rig)
    script = os.path.join(SCRIPTS, "farm_index.py")
    kept = [output for output, job in planner.jobs.items() if not job.temporary]
    planner.add("index", {}, [sys.executable, script, farm.file], kept, [script, farm.file])
    return planner.jobs


def line_of(job):
    """A job as a line of shell, for queues of commands; a merge deletes its shards, whose stamps stay."""
    line = shlex.join(stamped(job))
    return line + " && rm -f -- " + shlex.join(job.inputs) if job.rule == "merge" else line


def stamped(job, *flags):
    """The words that run the job through farm_stamp, which runs it only if it must and says what made its output."""
    words = [sys.executable, os.path.join(SCRIPTS, "farm_stamp"), job.output, *flags]
    for path in [*job.inputs, *job.sources]:
        words += ["-i", path]
    if job.depfile:
        words += ["--depfile", job.depfile]
    return [*words, "--", *job.command]
