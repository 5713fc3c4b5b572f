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

from farm.config import MESHES, ROOT, ConfigError, chooses_poses, files_of, is_composed, parts_of
from farm.shards import ClipShards, figure
from farm.stamps import Digests, digest_of, label, nameless, names_in, read_stamp, remembered, tool_version, write_whole

SCRIPTS = os.path.join(ROOT, "scripts")


@dataclass
class Job:
    rule: str
    output: str          # relative to the farm's folder, where all commands run
    command: list        # words
    inputs: list         # outputs of other jobs
    sources: list        # files from outside, absolute
    names: dict          # values of the wildcards of PATTERNS
    temporary: bool = False  # not kept once it was read
    merged: str = ""         # by what a temporary one is read
    depfile: str = ""    # where the command lists further files that it read


# Tells where each rule writes. A rig in one piece is baked where the merged file of others stands.
PATTERNS = {
    "bake": "{rig}/{rig}.vis.h5", "shard": "{rig}/shards/{range}.vis.h5", "clip": "{rig}/clips/{range}.vis.h5", "merge": "{rig}/{rig}.vis.h5",
    "fields": "{rig}/{rig}.fields.h5", "poses": "{rig}/{rig}.poses.h5", "fit": "{rig}/{rig}.model.h5", "brdf": "materials/{material}.brdf.h5",
    "light": "lights/{light}.light.h5", "predict": "{rig}/{rig}.pred.vis.h5", "pack": "{rig}/{rig}.pnb",
    "truth": "{rig}/{rig}.truth.pnb", "check": "{rig}/check.json", "sheet": "{rig}/sheet.png", "index": "index.html"}


# No job reads from one of a later rule.
ORDER = ("brdf", "light", "fields", "poses", "bake", "shard", "clip", "merge", "fit", "predict", "truth", "pack", "check", "sheet", "index")


def escaped(name):
    """Returns a name as it stands in a list with commas between."""
    return str(name).replace("\\", "\\\\").replace(",", "\\,")


def options(values):
    """Turns {"max_error": 0.1, "ground": True} into words of a command line."""
    words = []
    for key, value in values.items():
        if value is False or value == []:
            continue
        name = "--" + key.replace("_", "-")
        if key == "ground" and value is not True:
            words.append(f"{name}={value}")  # its value is optional
        elif key == "occluder":
            words += [word for mesh in value for word in (name, mesh)]
        else:
            words += [name] if value is True else [name, ",".join(map(escaped, value)) if isinstance(value, list) else str(value)]
    return words


def mesh_options(rig):
    """Returns which meshes a bake reads, and how, for the programs that must read the same ones."""
    return options({key: rig["bake"][key] for key in MESHES if key in rig["bake"]})


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
    patterns = PATTERNS

    def __init__(self, farm):
        self.farm = farm
        self.jobs = {}  # output -> Job, in an order that can be run
        self.digests = Digests(farm.output)
        self.memory = os.path.join(farm.output, ".farm", "asked.json")
        self.asked = remembered(self.memory)

    def program(self, name):
        return os.path.join(self.farm.programs, name) if self.farm.programs else name

    def add(self, rule, names, command, inputs=(), sources=(), **more):
        output = self.patterns[rule].format(**names)
        if command[0] == self.program("penumbra-bake") or "--materials-of" in command:
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
                 *options({key: rig["bake"][key] for key in ("rays", "seed") if key in rig["bake"]}), *mesh_options(rig)]
        files = [file for path in rig["files"] for file in files_of(path)]
        self.ask(f"rigs.{name}.bake.poses", [*words, "-o", ".farm/probe.poses.h5", "--dry-run"], files)
        return self.add("poses", {"rig": name}, words, sources=files)

    def bake(self, name, rig):
        files = read_by_bake(rig)
        if chooses_poses(rig):
            listed = self.poses(name, rig)
            own = {**rig, "clips": rig["holdout"], "bake": {**rig["bake"], "poses": listed}}
            return self.add("bake", {"rig": name}, [*self.bake_words(own), "--resume"], [listed], files)
        words, shards = self.bake_words(rig), rig.get("shards", 1)
        ranges = self.standing_ranges(name, words, files)
        if ranges is None:
            by_clip = ClipShards(self, name, rig)
            if by_clip.groups:
                parts = [self.shard("clip", name, *piece) for piece in by_clip.pieces(shards)]
                return self.merge(name, parts, options({"clips": rig["clips"]} if "clips" in rig else {}))
            ranges = self.new_ranges(name, words, files, shards) if shards > 1 else []
        if not ranges:
            return self.add("bake", {"rig": name}, [*words, "--resume"], sources=files)
        return self.merge(name, [self.shard("shard", name, f"{a:06}-{b:06}", [*words, "--frames", f"{a}:{b}"], files)
                                 for a, b in ranges])

    def shard(self, rule, name, part, words, files):
        return self.add(rule, {"rig": name, "range": part}, [*words, "--resume"], sources=files, temporary=True,
                        merged=PATTERNS["merge"].format(rig=name))

    def merge(self, name, parts, chosen=()):
        return self.add("merge", {"rig": name}, [self.program("penumbra-bake"), "merge", *parts, *chosen], parts)

    def new_ranges(self, name, words, files, shards):
        """Returns first and last frame of every shard."""
        said = self.ask(f"rigs.{name}", [*words, "-o", ".farm/probe.vis.h5", "--dry-run"], files)
        frames = int(figure(f"rigs.{name}", r"(\d+) frames", said))
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
            nameless(same_for_all_shards(stamp["command"]), files, names_in(stamp)) == \
            nameless([*words, "--resume"], files, [label(file) for file in files]) and \
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
        clips = json.loads(figure(f"rigs.{name}", "clips: (.*)", said))
        for clip in rig["holdout"]:
            if clip not in clips:
                raise ConfigError(f"rigs.{name}.holdout: no clip '{clip}'; the bake has {', '.join(clips)}")
        if set(clips) <= set(rig["holdout"]):
            raise ConfigError(f"rigs.{name}.holdout: no clip is left to train on")

    def fields(self, name, rig):
        """Adds the fields of a rig whose model is composed. Returns the files of fields that the fit reads."""
        if not is_composed(rig):
            return []
        words = [self.program("penumbra-bake"), "fields", *rig["files"], *options(rig["fields"]), *mesh_options(rig)]
        files = [file for path in rig["files"] for file in files_of(path)]
        said = self.ask(f"rigs.{name}.fields", [*words, "-o", ".farm/probe.fields.h5", "--dry-run"], files)
        if int(figure(f"rigs.{name}.fields", r"(\d+) of", said)) < 2:
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
        fit, pack = self.program("penumbra-fit"), self.program("penumbra-pack")
        names = {"rig": name}
        self.check_holdout(name, rig)
        vis = self.bake(name, rig)
        model = self.fit(name, rig, vis)
        brdfs = [f"materials/{m}.brdf.h5" for m in rig["materials"]]
        lights = [f"lights/{l}.light.h5" for l in rig["lights"]]
        given = {key: value for key, value in rig["pack"].items() if key != "slot"}
        slots = [word for slot, m in rig["pack"].get("slot", {}).items() for word in ("--slot", f"{slot}={m}")]
        looks = [word for kind, files in (("--brdf", brdfs), ("--light", lights)) for f in files for word in (kind, f)]
        described = [given["materials_of"]] if "materials_of" in given else []
        asset = self.add("pack", names, [pack, "asset", model, *looks, *options(given), *slots], [model, *brdfs, *lights], described)
        truth = self.add("truth", names, [pack, "truth", vis, *options({"clips": rig["holdout"]})], [vis])
        check, read = [pack, "check", asset, vis, "--model", model], [asset, vis, model]
        if rig.get("predict"):
            prediction = self.add("predict", names, [fit, "predict", model, vis], [model, vis])
            check, read = [*check, "--predictions", prediction], [*read, prediction]
        self.add("check", names, check, read)
        self.sheet(name, asset, truth, lights)

    def sheet(self, name, asset, truth, lights):
        script = os.path.join(SCRIPTS, "farm", "farm_sheet.py")
        looks = [word for light in lights for word in ("--light", light)]
        self.add("sheet", {"rig": name}, [sys.executable, script, self.program("penumbra-player"), self.program("penumbra-bake"), asset, truth,
                                           *looks, *options(self.farm.pictures)], [asset, truth, *lights], [script])

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
    return farm.jobs["bake" if rule in ("shard", "clip") else rule]


def ranges_of(job):
    """Returns the shards that a merge deletes: those of ranges of frames, whose stamps stay. A shard that was merged is
    not baked again. Shards of clips stay, because the next merge may need them beside others."""
    return [path for path in job.inputs if path.split(os.sep)[1:2] == ["shards"]] if job.rule == "merge" else []


def line_of(job):
    """Returns a job as a line of shell, for queues of commands."""
    line = shlex.join(stamped(job, *(["--merged", job.merged] if job.merged else [])))
    gone = ranges_of(job)
    return line + " && rm -f -- " + shlex.join(gone) if gone else line


def stamped(job, *flags):
    """Returns the words that run the job through farm_stamp, which runs it only if it must, and says what made its
    output."""
    words = [sys.executable, os.path.join(SCRIPTS, "farm", "farm_stamp"), job.output, *flags]
    for path in [*job.inputs, *job.sources]:
        words += ["-i", path]
    if job.depfile:
        words += ["--depfile", job.depfile]
    return [*words, "--", *job.command]
