"""Finds out what is in the files before anything is baked, and chooses from it: which clips, how often they are
sampled, which clip is held out, which model. The farm's planner asks all questions and remembers the answers."""
import json
import math
import os
import re
from dataclasses import dataclass

from farm.config import ConfigError, files_of
from farm.plan import escaped

CLIP = re.compile(r"^\s+-\s+name (.*), (seconds|keys) ([-+.\de]+)$", re.M)
MATERIALS = (".glb", ".gltf", ".vrm", ".fbx", ".dae", ".x")  # penumbra-pack asset --materials-of
CACHE_RATE = 24  # keys a second that the bake takes where a point cache does not say
RATE = 30        # samples a second by which the length of any other clip is measured


@dataclass
class Survey:
    clips: dict          # name -> seconds; 0 for a single pose
    is_cache: bool       # a point cache: no skeleton, and both sides of the sheet are seen
    parts: int           # rigid parts of a rig; 1 of a mesh without a skeleton
    slots: bool          # whether the file may describe materials
    vertices: int


def survey(planner, files, source):
    """Asks the programs what is in `files`, of which the first has the mesh. `source` are words about how to read them.
    Raises ConfigError with the complaint of a program."""
    bake, probe = planner.program("penumbra-bake"), ["-o", ".farm/probe.vis.h5", "--dry-run"]
    read = [file for path in files for file in files_of(path)]
    said = planner.ask("make", [bake, "visibility", *files, "--rays", "16", "--frames", "0:1", *source, *probe], read)
    names = json.loads(re.search("^clips: (.*)$", said, re.M)[1])
    vertices = int(re.search(r" frames x (\d+) vertices", said)[1])
    found = Survey({}, False, 1, files[0].lower().endswith(MATERIALS), vertices)
    lengths = {}
    for path in files:
        if not os.path.isfile(path):  # numbered files, one frame each
            found.is_cache |= path == files[0]
            lengths.setdefault(names[0], (len(files_of(path)) - 1) / CACHE_RATE)
            continue
        try:
            text = planner.ask("make", [bake, "info", path], files_of(path))
        except ConfigError:  # a file of clips alone
            continue
        found.is_cache |= path == files[0] and bool(re.search("^format +point cache", text, re.M))
        for name, unit, value in CLIP.findall(text):
            lengths.setdefault(name, float(value) if unit == "seconds" else (float(value) - 1) / CACHE_RATE)
    # `info` tells nothing about files of clips alone, and nothing about the rest pose where there are no clips.
    for name in names:
        if name not in lengths:
            chosen = ["--clips", escaped(name)] if len(names) > 1 else []
            text = planner.ask("make", [bake, "visibility", *files, "--rays", "16", *chosen, "--fps", str(RATE),
                                        *source, *probe], read)
            lengths[name] = (int(re.match(r"(\d+) frames", text)[1]) - 1) / RATE
    found.clips = {name: lengths[name] for name in names}
    if not found.is_cache:
        text = planner.ask("make", [bake, "fields", *files, *source, "-o", ".farm/probe.fields.h5", "--dry-run"], read)
        found.parts = int(re.match(r"(\d+) of", text)[1])
    return found


def spread(names, count):
    """Returns `count` of the names, spread evenly."""
    if len(names) <= count:
        return names
    return [names[i * len(names) // count] for i in range(count)]


def rate(seconds, clips, effort):
    """Returns samples a second that make about effort.frames frames, at most effort.fps."""
    wanted = max(effort.frames - clips, 1) / seconds if seconds > 0 else effort.fps
    return effort.fps if wanted >= effort.fps else float(f"{wanted:.2g}")


def held_out(clips, fps):
    """Returns (clips to hold out, number of blocks to cut clips into). `clips` are seconds by name.

    Of ten clips or more every fifth is held out. Of fewer it is the one that is nearest to a fifth of the whole. A
    single clip is cut into blocks, of which the last is held out. What has too few frames for that has none."""
    moving = [name for name in clips if clips[name] * fps >= 2]
    if len(moving) >= 10:
        return moving[2::5], 1
    if len(moving) >= 2:
        fifth = sum(clips[name] for name in moving) / 5
        return [min(moving, key=lambda name: abs(clips[name] - fifth))], 1
    frames = math.floor(clips[moving[0]] * fps) + 1 if moving else 0
    blocks = min(5, frames // 3)
    if len(clips) == 1 and blocks >= 2:
        return [f"{moving[0]}#{blocks}"], blocks
    return [], 1
