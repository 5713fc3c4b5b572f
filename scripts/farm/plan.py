"""Lists every job of a farm's YAML file: what it reads, what it writes, its command. Snakefile, farm_ninja and
slurm/farm_array run this one list, so that none of them knows an option of a program."""
import json
import os
import re
import shlex
import subprocess
import sys
from dataclasses import dataclass
from urllib.parse import unquote

from farm.config import ROOT, ConfigError, chooses_poses, files_of, is_composed, parts_of
from farm.stamps import Digests, digest_of, label, read_stamp, tool_version, write_whole

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
    merged: str = ""         # by what a temporary one is read
    depfile: str = ""    # where the command lists further files that it read


# Tells where each rule writes. A rig in one piece is baked where the merged file of others stands.
PATTERNS = {
    "bake": "{rig}/{rig}.vis.h5", "shard": "{rig}/shards/{range}.vis.h5", "merge": "{rig}/{rig}.vis.h5",
    "fields": "{rig}/{rig}.fields.h5", "poses": "{rig}/{rig}.poses.h5", "fit": "{rig}/{rig}.model.h5", "brdf": "materials/{material}.brdf.h5",
    "light": "lights/{light}.light.h5", "predict": "{rig}/{rig}.pred.vis.h5", "pack": "{rig}/{rig}.pnb",
    "truth": "{rig}/{rig}.truth.pnb", "check": "{rig}/check.json", "sheet": "{rig}/sheet.png", "index": "index.html"}


# No job reads from one of a later rule.
ORDER = ("brdf", "light", "fields", "poses", "bake", "shard", "merge", "fit", "predict", "truth", "pack", "check", "sheet", "index")


def options(values):
    """Turns {"max_error": 0.1, "ground": True} into words of a command line."""
    words = []
    for key, value in values.items():
        if value is False:
            continue
        name = "--" + key.replace("_", "-")
        if key == "ground" and value is not True:
            words.append(f"{name}={value}")  # its value is optional
        elif key == "occluder":
            words += [word for mesh in value for word in (name, mesh)]
        else:
            words += [name] if value is True else [name, ",".join(value) if isinstance(value, list) else str(value)]
    return words


def read_by_bake(rig):
    """Returns the files that a rig and the options of its bake name."""
    bake = rig["bake"]
    occluders = [part for occluder in bake.get("occluder", []) for part in parts_of(occluder)]
    meshes = [file for path in [*rig["files"], *occluders] for file in files_of(path)]
    return [*meshes, *(bake[key] for key in ("poses", "inputs") if key in bake and not (key == "poses" and chooses_poses(rig)))]


def report_of(output):
    """Returns where the report of the job that makes `output` lies."""
    return output if output.endswith("check.json") else f"reports/{output.replace('/', '.')}.json"


def buffers_of(path):
    """Returns the files that a .gltf names. --dry-run of the bake knows them too, but writes no --depfile."""
    if not path.lower().endswith(".gltf"):
        return []
    try:
        with open(path) as file:
            names = [buffer.get("uri", "data:") for buffer in json.load(file).get("buffers", [])]
    except (ValueError, AttributeError):  # the bake says what is wrong with it
        return []
    found = [os.path.join(os.path.dirname(path), unquote(name)) for name in names if not name.startswith("data:")]
    return [file for file in found if os.path.isfile(file)]


WHERE = ("--frames", "-o", "--report", "--depfile")  # options that shards of one bake do not share


def same_for_all_shards(command):
    """Returns a bake's command without its frames and files."""
    return [word for before, word in zip(["", *command], command) if word not in WHERE and before not in WHERE]


class Planner:
    def __init__(self, farm):
        self.farm = farm
        self.jobs = {}  # output -> Job, in an order that can be run
        self.digests = Digests(farm.output)
        self.memory = os.path.join(farm.output, ".farm", "asked.json")
        self.asked = {}
        if os.path.exists(self.memory):
            with open(self.memory) as file:
                self.asked = json.load(file)

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

    def bake_words(self, rig):
        return [self.program("penumbra-bake"), "visibility", *rig["files"],
                *options({key: rig[key] for key in ("clips", "fps") if key in rig}), *options(rig["bake"])]

    def poses(self, name, rig):
        """Adds the choice of poses of a rig. Their bake is to end within the minutes of its job."""
        words = [self.program("penumbra-bake"), "poses", *rig["files"], *options({key: rig[key] for key in ("clips", "fps") if key in rig}),
                 *options({"holdout": rig["holdout"], "auto": True, "minutes": needs_of(self.farm, "bake")["minutes"]}),
                 *options({key: rig["bake"][key] for key in ("rays", "seed") if key in rig["bake"]})]
        files = [file for path in rig["files"] for file in files_of(path)]
        self.ask(f"rigs.{name}.bake.poses", [*words, "-o", ".farm/probe.poses.h5", "--dry-run"], files)
        return self.add("poses", {"rig": name}, words, sources=files)

    def bake(self, name, rig):
        if chooses_poses(rig):
            listed = self.poses(name, rig)
            own = {**rig, "clips": rig["holdout"], "bake": {**rig["bake"], "poses": listed}}
            return self.add("bake", {"rig": name}, [*self.bake_words(own), "--resume"], [listed], read_by_bake(rig))
        words, files = self.bake_words(rig), read_by_bake(rig)
        ranges = self.standing_ranges(name, words, files)
        if ranges is None:
            ranges = self.new_ranges(name, words, files, rig.get("shards", 1))
        if not ranges:
            return self.add("bake", {"rig": name}, [*words, "--resume"], sources=files)
        parts = [self.add("shard", {"rig": name, "range": f"{a:06}-{b:06}"}, [*words, "--frames", f"{a}:{b}", "--resume"],
                          sources=files, temporary=True, merged=PATTERNS["merge"].format(rig=name)) for a, b in ranges]
        return self.add("merge", {"rig": name}, [self.program("penumbra-bake"), "merge", *parts], parts)

    def new_ranges(self, name, words, files, shards):
        """Returns first and last frame of every shard; [] for a bake in one piece."""
        if shards == 1:
            return []
        said = self.ask(f"rigs.{name}", [*words, "-o", ".farm/probe.vis.h5", "--dry-run"], files)
        frames = int(re.match(r"(\d+) frames", said)[1])
        edges = [frames * i // shards for i in range(shards + 1)]
        return [(a, b) for a, b in zip(edges, edges[1:]) if a < b]

    def standing_ranges(self, name, words, files):
        """Returns the ranges of the shards of the bake that lies there, like new_ranges(). Returns None when that is
        not the bake that is wanted, whatever its shards. Its bytes do not depend on the shards, so another number of
        shards waits until something else changes, and nothing is made again for it."""
        whole = PATTERNS["merge"].format(rig=name)
        stamp = read_stamp(self.farm.output, whole)
        if stamp is None or not os.path.exists(os.path.join(self.farm.output, whole)):
            return None
        merged = stamp["command"][1:2] == ["merge"]
        pieces = stamp["inputs"] if merged else [[whole, stamp["output"]["sha256"]]]
        if not all(self.is_of_bake(piece, digest, words, files) for piece, digest in pieces):
            return None
        return [tuple(map(int, re.findall(r"\d+", os.path.basename(piece))[:2])) for piece, _ in pieces] if merged else []

    def is_of_bake(self, piece, digest, words, files):
        """Tells whether this piece, which need not be there any more, was baked by these words from these files."""
        stamp = read_stamp(self.farm.output, piece)
        return stamp is not None and stamp["output"]["sha256"] == digest and stamp["version"] == tool_version(words) and \
            same_for_all_shards(stamp["command"]) == [label(word) for word in [*words, "--resume"]] and \
            [found for _, found in stamp["inputs"]] == [self.digests.of(file) for file in files] and \
            all(digest_of(self.farm.output, path, self.digests) == found for path, found in stamp["further_inputs"].items())

    def ask(self, key, words, files):
        """Returns what a program says to --dry-run. It is asked once, and the answer is remembered by its version and
        the content of its files. Raises ConfigError with its complaint."""
        read = [*files, *(buffer for file in files for buffer in buffers_of(file))]
        question = json.dumps([tool_version(words), [label(word) for word in words[1:]], [self.digests.of(file) for file in read]])
        if question not in self.asked:
            os.makedirs(os.path.dirname(self.memory), exist_ok=True)
            result = subprocess.run(words, cwd=self.farm.output, capture_output=True, text=True)
            if result.returncode != 0:
                raise ConfigError(f"{key}: {result.stderr.strip() or f'{words[0]}: exit code {result.returncode}'}")
            self.asked[question] = result.stdout
            write_whole(self.memory, json.dumps(self.asked, indent=1))
        return self.asked[question]

    def check_holdout(self, name, rig):
        """Checks before any job starts that the clips are in the bake, and that one is left to train on."""
        bake = {key: value for key, value in rig["bake"].items() if key != "poses" or not chooses_poses(rig)}
        words = self.bake_words({**rig, "bake": {**bake, "rays": 16}})
        said = self.ask(f"rigs.{name}", [*words, "--frames", "0:1", "-o", ".farm/probe.vis.h5", "--dry-run"], read_by_bake(rig))
        clips = json.loads(re.search("^clips: (.*)$", said, re.M)[1])
        for clip in rig["holdout"]:
            if clip not in clips:
                raise ConfigError(f"rigs.{name}.holdout: no clip '{clip}'; the bake has {', '.join(clips)}")
        if set(clips) <= set(rig["holdout"]):
            raise ConfigError(f"rigs.{name}.holdout: no clip is left to train on")

    def fields(self, name, rig):
        """Adds the fields of a rig whose model is composed. Returns the files of fields that the fit reads."""
        if not is_composed(rig):
            return []
        words = [self.program("penumbra-bake"), "fields", *rig["files"], *options(rig["fields"])]
        files = [file for path in rig["files"] for file in files_of(path)]
        said = self.ask(f"rigs.{name}.fields", [*words, "-o", ".farm/probe.fields.h5", "--dry-run"], files)
        if int(re.match(r"(\d+) of", said)[1]) < 2:
            raise ConfigError(f"rigs.{name}.fit.model: composed needs a rig of several parts; {os.path.basename(rig['files'][0])} is "
                              "a single one, as is all that has no skeleton")
        return [self.add("fields", {"rig": name}, words, sources=files)]

    def fit(self, name, rig, vis):
        fields = self.fields(name, rig)
        train_frames = [rig["fit"]["train_frames"]] if "train_frames" in rig["fit"] else []
        words = [self.program("penumbra-fit"), "visibility", vis, *options({"holdout": rig["holdout"]}), *options(rig["fit"])]
        words += [word for file in fields for word in ("--fields", file)]
        return self.add("fit", {"rig": name}, words, [vis, *fields], train_frames)

    def rig(self, name, rig):
        bake, fit, pack = (self.program(f"penumbra-{p}") for p in ("bake", "fit", "pack"))
        names = {"rig": name}
        self.check_holdout(name, rig)
        vis = self.bake(name, rig)
        model = self.fit(name, rig, vis)
        brdfs = [f"materials/{m}.brdf.h5" for m in rig["materials"]]
        lights = [f"lights/{l}.light.h5" for l in rig["lights"]]
        given = {key: value for key, value in rig["pack"].items() if key != "slot"}
        slots = [word for slot, m in rig["pack"].get("slot", {}).items() for word in ("--slot", f"{slot}={m}")]
        looks = [word for kind, files in (("--brdf", brdfs), ("--light", lights)) for f in files for word in (kind, f)]
        asset = self.add("pack", names, [pack, "asset", model, *looks, *options(given), *slots], [model, *brdfs, *lights])
        truth = self.add("truth", names, [pack, "truth", vis, *options({"clips": rig["holdout"]})], [vis])
        check, read = [pack, "check", asset, vis, "--model", model], [asset, vis, model]
        if rig.get("predict"):
            prediction = self.add("predict", names, [fit, "predict", model, vis], [model, vis])
            check, read = [*check, "--predictions", prediction], [*read, prediction]
        self.add("check", names, check, read)
        script = os.path.join(SCRIPTS, "farm", "farm_sheet.py")
        self.add("sheet", names, [sys.executable, script, self.program("penumbra-player"), bake, asset, truth,
                                  *looks[2 * len(brdfs):], *options(self.farm.pictures)], [asset, truth, *lights], [script])

    # --- what rigs share

    def material(self, name, material):
        files = [material[kind] for kind in ("merl", "table") if kind in material]
        words = [self.program("penumbra-fit"), "brdf", *options(material), "--name", name]
        self.ask(f"materials.{name}", [*words, "-o", ".farm/probe.brdf.h5", "--dry-run"], files)
        self.add("brdf", {"material": name}, words, sources=files)

    def light(self, name, light):
        picture = [light["picture"]] if "picture" in light else []
        rest = {key: value for key, value in light.items() if key != "picture"}
        words = [self.program("penumbra-fit"), "light", *picture, *options(rest), "--name", name]
        self.ask(f"lights.{name}", [*words, "-o", ".farm/probe.light.h5", "--dry-run"], picture)
        self.add("light", {"light": name}, words, sources=picture)


def make_plan(farm):
    """Returns jobs by output, each after those that it reads from."""
    planner = Planner(farm)
    for name, material in farm.materials.items():
        planner.material(name, material)
    for name, light in farm.lights.items():
        planner.light(name, light)
    for name, rig in farm.rigs.items():
        planner.rig(name, rig)
    script = os.path.join(SCRIPTS, "farm", "farm_index.py")
    kept = [output for output, job in planner.jobs.items() if not job.temporary]
    planner.add("index", {}, [sys.executable, script, planner.program("penumbra-fit"), farm.file], kept, [script, farm.file])
    planner.digests.save()
    return planner.jobs


def needs_of(farm, rule):
    """Returns threads, memory_mb and minutes of a job."""
    return farm.jobs["bake" if rule == "shard" else rule]


def line_of(job):
    """Returns a job as a line of shell, for queues of commands. A merge deletes its shards, whose stamps stay: a shard
    that was merged is not baked again."""
    line = shlex.join(stamped(job, *(["--merged", job.merged] if job.merged else [])))
    return line + " && rm -f -- " + shlex.join(job.inputs) if job.rule == "merge" else line


def stamped(job, *flags):
    """Returns the words that run the job through farm_stamp, which runs it only if it must, and says what made its
    output."""
    words = [sys.executable, os.path.join(SCRIPTS, "farm", "farm_stamp"), job.output, *flags]
    for path in [*job.inputs, *job.sources]:
        words += ["-i", path]
    if job.depfile:
        words += ["--depfile", job.depfile]
    return [*words, "--", *job.command]
