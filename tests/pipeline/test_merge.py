"""penumbra-bake merge: shards give the bytes of the unsplit bake, whatever the split; anything else is refused by name.

usage: test_merge.py BIN
"""
import hashlib
import itertools
import json
import os
import shutil
import subprocess
import sys
import tempfile

import h5py
import numpy as np

BIN = sys.argv[1]
BAKE = os.path.join(BIN, "penumbra-bake")
SAMPLES = os.path.join(BIN, "..", "samples")
MAN = os.path.join(SAMPLES, "capsule_man.glb")
SMALL = ["--fps", "2", "--rays", "16", "--order", "2"]


def run(*words, cwd=None):
    return subprocess.run([BAKE, *map(str, words)], cwd=cwd, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


def good(*words, cwd=None):
    result = run(*words, cwd=cwd)
    assert result.returncode == 0, (words, result.stderr)
    return result


def bake(out, *words, rig=MAN):
    defaults = [word for pair in zip(SMALL[::2], SMALL[1::2]) for word in pair if pair[0] not in words]
    good("visibility", rig, "-o", out, "-q", *defaults, *words)
    return out


def digest(path):
    return hashlib.sha256(open(path, "rb").read()).hexdigest()


def refused(words, *parts, code=3):
    result = run("merge", *words)
    assert result.returncode == code and len(result.stderr.splitlines()) == 1, (words, result)
    for part in parts:
        assert part in result.stderr, (part, result.stderr)


def check_splits(folder):
    """1, 2 and 7 shards, in consecutive ranges and every S-th frame, on 1 and 2 threads, given in any order."""
    place = lambda name: os.path.join(folder, name)
    whole = bake(place("whole.vis.h5"))
    with h5py.File(whole) as f:
        frames = len(f["frames/time"])
        assert "shard" not in f and frames > 14, frames
    sums = {digest(whole)}
    for count, threads, strided in itertools.product((1, 2, 7), (1, 2), (False, True)):
        cuts = [round(i * frames / count) for i in range(count + 1)]
        ranges = [f"{i}:{frames}:{count}" if strided else f"{cuts[i]}:{cuts[i + 1]}" for i in range(count)]
        shards = [bake(place(f"s{i}.vis.h5"), "--frames", r, "--threads", threads) for i, r in enumerate(ranges)]
        good("merge", *reversed(shards), "-o", place("merged.vis.h5"), "-q", "--threads", threads)
        sums.add(digest(place("merged.vis.h5")))
    assert len(sums) == 1, sums
    # A whole bake is the only shard that it needs.
    good("merge", whole, "-o", place("merged.vis.h5"))
    assert digest(place("merged.vis.h5")) in sums


def check_choices(folder):
    """By clip, half precision, a floor, a bake that chose clips or frames itself, lists of poses; merging in steps."""
    place = lambda name: os.path.join(folder, name)
    merged = place("merged.vis.h5")
    whole = bake(place("whole.vis.h5"))
    with h5py.File(whole) as f:
        clips = [name.decode() for name in f["clips/names"]]
    by_clip = [bake(place(f"{clip}.vis.h5"), "--clips", clip) for clip in clips]
    good("merge", *by_clip, "-o", merged)
    assert digest(merged) == digest(whole)
    two = bake(place("two.vis.h5"), "--clips", f"{clips[1]},{clips[0]}")
    good("merge", by_clip[0], by_clip[1], "-o", merged, "--clips", f"{clips[1]},{clips[0]}")
    assert digest(merged) == digest(two)
    # Shards that were all told the same clips make those clips.
    more = ["--clips", f"{clips[1]},{clips[0]}", "--precision", "f16", "--ground"]
    half = bake(place("half.vis.h5"), *more)
    parts = [bake(place(f"h{i}.vis.h5"), *more, "--frames", r) for i, r in enumerate(("0:3", "3:4", "4:" + str(count_frames(half))))]
    good("merge", *parts, "-o", merged)
    assert digest(merged) == digest(half)
    # Every second frame, split; then its first half, as a step on the way.
    coarse = bake(place("coarse.vis.h5"), "--frames", "1:13:2")
    parts = [bake(place(f"c{i}.vis.h5"), "--frames", r) for i, r in enumerate(("1:5:2", "5:9:2", "9:13:2"))]
    good("merge", *parts[:2], "-o", place("step.vis.h5"), "--frames", "1:9:2")
    assert digest(place("step.vis.h5")) == digest(bake(place("direct.vis.h5"), "--frames", "1:9:2"))
    good("merge", place("step.vis.h5"), parts[2], "-o", merged, "--frames", "1:13:2")
    assert digest(merged) == digest(coarse)
    # Poses, and a copy of the rig under another name: contents count, the first shard gives the names.
    poses = place("p.poses.h5")
    good("poses", MAN, "-o", poses, "--choose", 6, "--sample", 3, "--fps", 2, "--holdout", clips[2])
    listed = bake(place("listed.vis.h5"), "--poses", poses, "--clips", clips[2])
    copy = shutil.copy(MAN, place("copy.glb"))
    cuts = ["0:4", "4:8", "8:" + str(count_frames(listed))]
    parts = [bake(place(f"p{i}.vis.h5"), "--poses", poses, "--clips", clips[2], "--frames", r, rig=copy if i else MAN)
             for i, r in enumerate(cuts)]
    good("merge", *parts, "-o", merged)
    assert digest(merged) == digest(listed)


def count_frames(path):
    with h5py.File(path) as f:
        return len(f["frames/time"])


def check_refusals(folder):
    place = lambda name: os.path.join(folder, name)
    out = place("out.vis.h5")
    whole = bake(place("whole.vis.h5"))
    frames = count_frames(whole)
    with h5py.File(whole) as f:
        clips = [name.decode() for name in f["clips/names"]]
        counts = np.bincount(f["frames/clip"][:]).tolist()
    a = bake(place("a.vis.h5"), "--frames", "0:5")
    b = bake(place("b.vis.h5"), "--frames", f"4:{frames}")
    c = bake(place("c.vis.h5"), "--frames", f"8:{frames}")
    before = set(os.listdir(folder))
    names = [(clips[k], i) for k in range(len(clips)) for i in range(counts[k])]
    assert names[4] == (clips[0], 4), names
    refused([a, b, "-o", out], f"twice: '{clips[0]}' 4:5 in {a} and {b}")
    refused([a, c, "-o", out], "missing frames: '" + names[5][0] + f"' {names[5][1]}:")
    refused([c, "-o", out], f"'{clips[0]}' 0:")
    refused([a, a, c, "-o", out], "given twice", code=1)
    refused([a, b, "-o", out, "--frames", "0:4"], "beyond the whole")
    refused([a, c, "-o", out, "--clips", "moonwalk"], "moonwalk", code=1)
    refused([MAN, a, "-o", out], "capsule_man.glb")
    # A clip that nobody baked.
    walk = bake(place("walk.vis.h5"), "--clips", clips[0])
    wave = bake(place("wave.vis.h5"), "--clips", clips[1])
    before |= {"walk.vis.h5", "wave.vis.h5"}
    refused([walk, wave, "-o", out], f"missing frames: '{clips[2]}' 0:{counts[2]}")
    # Other options, another rig, another version of the program; the report lists everything.
    for words, part in ((["--rays", "32"], "rays 32, not 16"), (["--seed", "2"], "seed 2, not 1"),
                        (["--bias", "1e-3"], "bias 0.001, not 0.0001"), (["--ground"], "ground true, not false"),
                        (["--precision", "f16"], 'precision "f16", not "f32"'), (["--order", "3"], "order 3, not 2")):
        bake(place("odd.vis.h5"), "--frames", f"5:{frames}", *words)
        refused([a, place("odd.vis.h5"), "-o", out], "odd.vis.h5", part)
    refused([a, place("odd.vis.h5"), "-o", out, "--report", place("r.json")], "odd.vis.h5")
    figures = json.load(open(place("r.json")))["figures"]
    assert figures["different"] and not figures["missing"], figures
    rig = place("other.glb")
    data = open(MAN, "rb").read()
    open(rig, "wb").write(data.replace(b'"walk"', b'"wolk"', 1))
    bake(place("odd.vis.h5"), "--frames", f"5:{frames}", rig=rig)
    refused([a, place("odd.vis.h5"), "-o", out], "input other.glb has SHA-256")
    shutil.copy(b, place("odd.vis.h5"))
    with h5py.File(place("odd.vis.h5"), "r+") as f:
        f.attrs["provenance"] = f.attrs["provenance"].replace('"version":"', '"version":"9')
    refused([a, place("odd.vis.h5"), "-o", out], "version 9")
    # Edited files: a mesh that is not the others', places that are none.
    edits = [
        ("mesh/rest_positions", lambda x: x + 1, "another mesh"),
        ("shard/frame_in_clip", lambda x: x[::-1], "/shard/frame_in_clip"),
        ("shard/frame_in_clip", lambda x: x + 1000, "/shard/frame_in_clip"),
    ]
    for dataset, edit, part in edits:
        shutil.copy(b, place("odd.vis.h5"))
        with h5py.File(place("odd.vis.h5"), "r+") as f:
            f[dataset][...] = edit(f[dataset][:])
        refused([a, place("odd.vis.h5"), "-o", out], "odd.vis.h5", part)
    shutil.copy(b, place("odd.vis.h5"))
    with h5py.File(place("odd.vis.h5"), "r+") as f:
        del f["shard"]
    refused([a, place("odd.vis.h5"), "-o", out], "odd.vis.h5", "/shard is missing")
    left = set(os.listdir(folder)) - before - {"odd.vis.h5", "other.glb", "r.json"}
    assert not left, left


def main():
    for check in (check_splits, check_choices, check_refusals):
        with tempfile.TemporaryDirectory() as folder:
            check(folder)
            print(f"{check.__name__}: ok")


main()
