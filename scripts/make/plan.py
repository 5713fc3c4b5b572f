"""The jobs of `penumbra make`: those that a farm has for one rig, the pictures of held-out frames, and the page."""
import os
import re

from farm.config import MESHES, NAME, RESERVED, ConfigError, Farm, check_config
from farm.plan import PATTERNS, Planner, options, report_of
from farm.stamps import Digests
from make import survey as surveys
from make.efforts import BYTES_PER_VERTEX, EFFORTS, FEWEST_VERTICES, PRECISION

CLAY = "lambert:color=0.75/0.7/0.65"  # for meshes whose file describes no materials
SKY = "sky:elevation=40,turbidity=3"
READING = [f"bake.{key}" for key in ("up", "units", *MESHES)]  # settings that say how the files are read
CAMERA = "yaw=35,pitch=12"
IN_BAKE = re.compile(r"^\s+-\s+name (.*), frames (\d+), from_seconds", re.M)


class MakePlanner(Planner):
    """Plans as the farm does, with pictures for the page in place of the farm's sheet. Every program tells its
    progress as lines that Runner reads."""
    patterns = {**PATTERNS, "picture": "pictures/{picture}.png", "page": "page.html"}

    def add(self, rule, names, command, inputs=(), sources=(), **more):
        if "--progress" not in command and os.path.basename(command[0]).startswith("penumbra-"):
            command = [*command, "--progress", "openjd"]
        return super().add(rule, names, command, inputs, sources, **more)

    def bake_words(self, rig):
        return [*super().bake_words(rig), "--progress", "openjd"]

    def sheet(self, name, asset, truth, lights):
        pass


def name_of(path):
    """Returns the stem of a file as a name that a farm takes."""
    stem = re.sub(r"[^A-Za-z0-9_-]+", "_", os.path.basename(path).split(".")[0]).lstrip("_-") or "mesh"
    return stem + "_1" if stem.lower() in RESERVED or not NAME.fullmatch(stem) else stem


def light_of(words):
    """Returns (name, keys of a farm's light) of what --light says: a picture, or a text as of --analytic."""
    if words is None:
        return "sky", {"analytic": SKY, "factor": True}
    if not os.path.exists(words) and re.fullmatch(r"[a-z]+([:+][^/].*)?", words) and "." not in words.split(":")[0]:
        return name_of(re.split("[:+.]", words)[0]), {"analytic": words, "factor": True}
    return name_of(words), {"picture": os.path.abspath(words), "factor": True, "order": 5}


def put(config, path, value):
    """Sets a key such as bake.rays of a rig."""
    *folders, last = path.split(".")
    for name in folders:
        config = config.setdefault(name, {})
        if not isinstance(config, dict):
            raise ConfigError(f"{path}: no such key")
    config[last] = value


class MakePlan:
    """Everything that one asset needs. Jobs are added in three steps, because which frames a bake has and how bright
    its pictures are is known only once they are there."""

    def __init__(self, request, folder, programs):
        self.request, self.effort = request, EFFORTS[request.effort]
        self.rig = name_of(request.output)
        empty = Farm("", folder, programs, {}, {}, {}, {}, {})
        self.planner = MakePlanner(empty)
        self.light, light = light_of(request.light)
        light.update({key.removeprefix("light."): value for key, value in request.settings if key.startswith("light.")})
        self.facts = []
        config = {"output": folder, "rigs": {self.rig: self.rig_config()}, "materials": {"clay": {"analytic": CLAY}},
                  "lights": {self.light: light}, "jobs": {"bake": {"minutes": 60}}}
        if programs:
            config["programs"] = programs
        self.planner.farm = check_config(config, os.path.abspath("make"))  # its paths are as in the shell
        self.planner.farm.programs = programs
        self.light_words = light.get("analytic") or light["picture"]

    def rig_config(self):
        """Returns the keys of a farm's rig that the files, the effort and the options ask for."""
        request, effort = self.request, self.effort
        read = {key: value for key, value in request.settings if key in READING}
        source = options({key.removeprefix("bake."): value for key, value in read.items()})
        self.survey = found = surveys.survey(self.planner, request.files, source)
        if strange := [clip for clip in request.clips or [] if clip not in found.clips]:
            raise ConfigError(f"clips: no clip '{strange[0]}'; the files have {', '.join(found.clips)}")
        clips = request.clips or surveys.spread(list(found.clips), effort.clips)
        wanted = [clip for clip in request.holdout or [] if clip in found.clips]
        clips = [clip for clip in found.clips if clip in {*clips, *wanted}]
        seconds = {clip: found.clips[clip] for clip in clips}
        fps = request.fps or surveys.rate(sum(seconds.values()), len(clips), effort)
        holdout, blocks = surveys.held_out(seconds, fps) if request.holdout is None else (request.holdout, 1)
        config = {"files": request.files, "holdout": holdout or "none", "fps": fps, "bake": {"rays": effort.rays}, "fit": {},
                  "pack": {"precision": PRECISION}}
        if found.vertices >= FEWEST_VERTICES:
            config["pack"]["max_bytes_per_vertex"] = BYTES_PER_VERTEX
        if len(clips) < len(found.clips):
            config["clips"] = clips
            why = "as asked" if request.clips else "at this effort"
            self.facts.append(f"{len(clips)} of {len(found.clips)} clips are baked {why}: {', '.join(clips)}.")
        if blocks > 1:
            config["bake"]["blocks"] = blocks
        if found.is_cache:
            config["bake"]["two_sided"] = read.get("bake.one_sided") is not True
        elif found.parts > 1:
            config["fit"]["model"] = "composed"
            if effort.chooses_poses and holdout and blocks == 1 and len(clips) - len(holdout) >= 2:
                config["bake"]["poses"] = "auto"
            elif effort.chooses_poses:
                self.facts.append("No poses were chosen: this needs a held-out clip and two clips to train on.")
        if found.slots:
            config["pack"].update(materials_of=request.files[0], textures="embed")
        for key, value in request.settings:
            if not key.startswith("light."):
                put(config, key, value)
        return config

    # --- the three steps

    def asset_jobs(self):
        """Adds the jobs up to the asset and its check. Returns (jobs that the first picture needs, the others)."""
        planner, farm = self.planner, self.planner.farm
        for name, material in farm.materials.items():
            planner.material(name, material)
        for name, light in farm.lights.items():
            planner.light(name, light)
        planner.rig(self.rig, farm.rigs[self.rig])
        planner.digests.save()
        jobs = list(planner.jobs.values())
        return [job for job in jobs if job.rule not in ("truth", "check")], [job for job in jobs if job.rule in ("truth", "check")]

    def path(self, rule):
        return PATTERNS[rule].format(rig=self.rig)

    def read_frames(self):
        """Chooses the frames of the pictures: (clip, frame of the clip, frame of the bake)."""
        self.planner.digests = Digests(self.planner.farm.output)
        said = self.planner.ask("make", [self.planner.program("penumbra-bake"), "info", self.path("bake")], [self.path("bake")])
        first, clips = 0, []
        for name, frames in IN_BAKE.findall(said):
            clips.append((name, first, int(frames)))
            first += int(frames)
        holdout = self.planner.farm.rigs[self.rig]["holdout"]
        shown = [clip for clip in clips if clip[0] in holdout] or clips
        every = [(name, i, at + i) for name, at, frames in shown for i in range(frames)]
        count = min(self.effort.pictures, len(every))
        self.frames = [every[(2 * i + 1) * len(every) // (2 * count)] for i in range(count)]

    def picture(self, name, command, inputs, sources=()):
        self.planner.add("picture", {"picture": name}, [*command, "--size", f"{self.effort.size}x{self.effort.size}",
                                                        "--camera", CAMERA], inputs, sources)
        return self.planner.jobs[self.planner.patterns["picture"].format(picture=name)]

    def drawn(self, frame, *words):
        clip, at, _ = frame
        return [self.planner.program("penumbra-player"), "render", self.path("pack"), "--clip", clip, "--frame", str(at), *words]

    def first_picture(self):
        """Adds the first picture, which also says how bright all others are."""
        self.read_frames()
        return self.picture("first", self.drawn(self.frames[0]), [self.path("pack")])

    def exposure(self, report):
        return ["--exposure", f"{report['figures']['exposure']:.4g}"]

    def picture_jobs(self, first_report):
        """Adds for each frame the ray-traced picture, the model's and its error."""
        rig, jobs, exposure = self.planner.farm.rigs[self.rig], [], self.exposure(first_report)
        described = rig["pack"].get("materials_of")
        look = ["--materials-of", described] if described else ["--brdf", CLAY]
        look += [word for occluder in rig["bake"].get("occluder", []) for word in ("--occluder", occluder)]
        sources = [path for path in (described, self.light_words) if path and os.path.isfile(path)]
        truth = self.path("truth")
        for number, frame in enumerate(self.frames):
            reference = [self.planner.program("penumbra-bake"), "reference", self.path("bake"), "--frame", str(frame[2]), *look,
                         "--light", self.light_words, "--samples", str(self.effort.samples), *exposure]
            jobs.append(self.picture(f"{number}_truth", reference, [self.path("bake")], sources))
            jobs.append(self.picture(f"{number}_model", self.drawn(frame, *exposure), [self.path("pack")]))
            jobs.append(self.picture(f"{number}_error", self.drawn(frame, "--channel", "error", "--truth", truth),
                                     [self.path("pack"), truth]))
        return jobs

    def page_job(self, description):
        """Adds the page, which `penumbra-fit page` writes from this file."""
        return self.planner.jobs[self.planner.add("page", {}, [self.planner.program("penumbra-fit"), "page", description],
                                                  [description])]


def report_path(folder, output):
    return os.path.join(folder, report_of(output))
