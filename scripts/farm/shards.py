"""Splits the bake of a rig by the files of its clips, so that a changed file bakes its own clips again and no others:
each shard names the rig and one of these files. `penumbra-bake merge` makes of them the very file of one bake."""
import json
import os
import re
from dataclasses import dataclass

from farm.config import ConfigError
from farm.stamps import read_stamp

RIGS = (".glb", ".gltf", ".vrm", ".fbx", ".dae", ".x")
FURTHER_FILES = ("poses", "blocks", "occluder", "inputs")  # options of a bake whose shards name the same files


def figure(key, pattern, said):
    """Returns what a line of a program's answer has."""
    if not (found := re.search("^" + pattern, str(said), re.M)):
        raise ConfigError(f"{key}: an answer of penumbra-bake --dry-run that nobody expects: {str(said)[:60]!r}")
    return found[1]


@dataclass
class Group:
    """The clips of one file."""
    key: str      # stands for the content of the file
    files: list   # the rig, and the file unless it is the rig itself
    clips: list
    frames: int


def can_split(rig):
    """Tells whether the files after the first can be told apart as files of clips."""
    files = rig["files"]
    return len(files) > 1 and files[0].lower().endswith(RIGS) and all(map(os.path.isfile, files)) and \
        not any(option in rig["bake"] for option in FURTHER_FILES) and len({os.path.basename(file) for file in files}) == len(files)


class ClipShards:
    """The groups of a rig's bake, none where it cannot be split by them; and what to bake of each."""

    def __init__(self, planner, name, rig):
        self.planner, self.name, self.rig = planner, name, rig
        self.merged = [piece for piece, _ in (read_stamp(planner.farm.output, f"{name}/{name}.vis.h5") or {"inputs": []})["inputs"]]
        wanted = rig.get("shards", 1) > 1 or any(piece.startswith(f"{name}/clips/") for piece in self.merged)
        try:
            self.groups = self.find_groups() if wanted and can_split(rig) else []
        except ConfigError:  # a file that goes with all others and not alone
            self.groups = []

    def words(self, files, clips):
        return self.planner.bake_words({**self.rig, "files": files, "clips": clips})

    def ask(self, files, clips=()):
        """Returns the clips of these files and the number of their frames. Few rays make the
        estimate of a bake quick."""
        rig = {**self.rig, "files": files, "bake": {**self.rig["bake"], "rays": 16}}
        rig.pop("clips", None)
        words = self.planner.bake_words({**rig, "clips": list(clips)} if clips else rig)
        said = self.planner.ask(f"rigs.{self.name}", [*words, "-o", ".farm/probe.vis.h5", "--dry-run"], files)
        key = f"rigs.{self.name}"
        return json.loads(figure(key, "clips: (.*)", said)), int(figure(key, r"(\d+) frames", said))

    def find_groups(self):
        """Returns a group for each file that brings clips, or nothing where one brings none of those that are baked, or
        where their clips are not one after the other those of all files together."""
        all_clips = self.ask(self.rig["files"])[0]
        own, own_frames = self.ask(self.rig["files"][:1])
        if all_clips[:len(own)] != own:  # a rig without clips would be baked at rest, if it was alone
            own, own_frames = [], 0
        groups = [Group(self.key(self.rig["files"][0]), self.rig["files"][:1], own, own_frames)] if own else []
        for file in self.rig["files"][1:]:
            files = [self.rig["files"][0], file]
            clips, frames = self.ask(files)
            groups.append(Group(self.key(file), files, clips[len(own):], frames - own_frames))
        if all_clips != [clip for group in groups for clip in group.clips]:
            return []
        groups = [self.chosen(group) for group in groups]
        keys = {group.key for group in groups}  # files with the same bytes have one key
        return groups if len(keys) == len(groups) > 1 and all(group.clips for group in groups) else []

    def chosen(self, group):
        """Returns the group with those of its clips that the rig wants baked."""
        clips = [clip for clip in group.clips if clip in self.rig.get("clips", group.clips)]
        frames = self.ask(group.files, clips)[1] if clips and clips != group.clips else group.frames
        return Group(group.key, group.files, clips, frames)

    def key(self, file):
        """A file that was renamed has the shards that it had, and so have the files beside one that has come or
        gone."""
        return self.planner.digests.of(file)[:12]

    def pieces(self, shards):
        """Returns name, command and files of each shard, about `shards` in all and one a file at least."""
        total = sum(group.frames for group in self.groups)
        pieces = []
        for group in self.groups:
            words = self.words(group.files, group.clips)
            count = min(group.frames, max(1, round(shards * group.frames / total)))
            edges = [group.frames * i // count for i in range(count + 1)]
            for a, b in self.standing(group, words) or zip(edges, edges[1:]):
                part = [*words, "--frames", f"{a}:{b}"] if (a, b) != (0, group.frames) else words
                pieces.append((f"{group.key}-{a:06}-{b:06}", part, group.files))
        return pieces

    def standing(self, group, words):
        """Returns the ranges of the shards that the merged bake has of this group: another number of shards, or of
        frames elsewhere, bakes none of them again."""
        stamp = read_stamp(self.planner.farm.output, f"{self.name}/{self.name}.vis.h5") or {"inputs": []}
        ranges = []
        for piece, digest in stamp["inputs"]:
            match = re.fullmatch(rf"{re.escape(self.name)}/clips/{group.key}-(\d+)-(\d+)\.vis\.h5", piece)
            if match and self.planner.is_of_bake(piece, digest, words, group.files):
                ranges.append((int(match[1]), int(match[2])))
        whole = [edge for range in ranges for edge in range]
        follow = whole[:1] == [0] and whole[-1:] == [group.frames] and whole[1:-1:2] == whole[2::2]
        return ranges if follow else []
