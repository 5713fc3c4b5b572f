"""penumbra-bake merge: shards give the bytes of the unsplit bake, whatever the split; anything else is refused by name.

usage: test_merge.py BIN
"""
import itertools
import json
import os
import shutil
import subprocess
import sys
import tempfile

import h5py
import numpy as np

from programs import digest

BIN = os.path.abspath(sys.argv[1])
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


def write_bytes(path, content):
    with open(path, "wb") as file:
        file.write(content)


def refused(words, *parts, code=3):
    result = run("merge", *words)
    assert result.returncode == code and len(result.stderr.splitlines()) == 1, (words, result)
    for part in parts:
        assert part in result.stderr, (part, result.stderr)


def check_splits(folder):
    """Merges 1, 2 and 7 shards, in consecutive ranges and every S-th frame, on 1 and 2 threads, given in any
    order."""
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
    """Merges by clip, in half precision, with a floor, from a bake that chose clips or frames itself, from lists of
    poses, and in steps."""
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
    # Every second frame is baked, split; then its first half is merged, as a step on the way.
    coarse = bake(place("coarse.vis.h5"), "--frames", "1:13:2")
    parts = [bake(place(f"c{i}.vis.h5"), "--frames", r) for i, r in enumerate(("1:5:2", "5:9:2", "9:13:2"))]
    good("merge", *parts[:2], "-o", place("step.vis.h5"), "--frames", "1:9:2")
    assert digest(place("step.vis.h5")) == digest(bake(place("direct.vis.h5"), "--frames", "1:9:2"))
    good("merge", place("step.vis.h5"), parts[2], "-o", merged, "--frames", "1:13:2")
    assert digest(merged) == digest(coarse)
    # These are poses, and a copy of the rig under another name: contents count, and the first shard gives the names.
    poses = place("p.poses.h5")
    good("poses", MAN, "-o", poses, "--choose", 6, "--sample", 3, "--fps", 2, "--holdout", clips[2])
    listed = bake(place("listed.vis.h5"), "--poses", poses, "--clips", clips[2])
    copy = shutil.copy(MAN, place("copy.glb"))
    cuts = ["0:4", "4:8", "8:" + str(count_frames(listed))]
    parts = [bake(place(f"p{i}.vis.h5"), "--poses", poses, "--clips", clips[2], "--frames", r, rig=copy if i else MAN)
             for i, r in enumerate(cuts)]
    good("merge", *parts, "-o", merged)
    assert digest(merged) == digest(listed)


def check_standing(folder):
    """Numbered files of which two have the same bytes: a mesh that stands still for a moment."""
    os.mkdir(os.path.join(folder, "seq"))
    for i, height in enumerate((1, 2, 2, 3)):
        write_bytes(os.path.join(folder, "seq", f"s_{i}.obj"),
                    b"v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 %d\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n" % height)
    mesh = os.path.join(folder, "seq", "s_%d.obj")
    cache = lambda name, *words: good("visibility", mesh, "-o", os.path.join(folder, name), "-q", "--rays", 16, "--order", 2, *words)
    cache("whole.vis.h5")
    for i, frames in enumerate(("0:2", "2:4")):
        cache(f"s{i}.vis.h5", "--frames", frames)
    good("merge", *(os.path.join(folder, f"s{i}.vis.h5") for i in range(2)), "-o", os.path.join(folder, "merged.vis.h5"))
    assert digest(os.path.join(folder, "merged.vis.h5")) == digest(os.path.join(folder, "whole.vis.h5"))


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
    refused([a, b, "-o", out, "--frames", "0:4"], "frames that the whole does not have")
    refused([a, c, "-o", out, "--clips", "moonwalk"], "moonwalk", code=1)
    refused([MAN, a, "-o", out], "capsule_man.glb")
    # Nobody baked this clip.
    walk = bake(place("walk.vis.h5"), "--clips", clips[0])
    wave = bake(place("wave.vis.h5"), "--clips", clips[1])
    before |= {"walk.vis.h5", "wave.vis.h5"}
    refused([walk, wave, "-o", out], f"missing frames: '{clips[2]}' 0:{counts[2]}")
    # Shards have other options, another rig, another version of the program. The report lists everything.
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
    # Somebody edited these files: a mesh is not the others', and places are none.
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


def same_numbers(a, b):
    """Compares every dataset as h5py shows it. The virtual file has /virtual besides."""
    with h5py.File(a) as f, h5py.File(b) as g:
        names = []
        f.visit(names.append)
        for name in names:
            if isinstance(f[name], h5py.Dataset):
                assert np.array_equal(f[name][...], g[name][...]), name
        assert dict(f.attrs) == dict(g.attrs)


def check_virtual(folder):
    """An index of shards gives the same numbers to h5py and to our readers. A shard that is gone or has changed is
    refused."""
    place = lambda name: os.path.join(folder, name)
    os.makedirs(place("shards/100%b"))
    os.makedirs(place("out"))
    whole = bake(place("whole.vis.h5"), "--precision", "f16")
    frames = count_frames(whole)
    # Each shard has every 4th frame, so that the list of sources is longer than HDF5's smallest heap. One name is
    # such that HDF5 would expand it.
    shards = [bake(place(f"shards/100%b/s{i}.vis.h5"), "--precision", "f16", "--frames", f"{i}:{frames}:4") for i in range(4)]
    index = place("out/index.vis.h5")
    good("merge", *shards, "-o", "index.vis.h5", "--virtual", "--quiet", cwd=place("out"))
    first = digest(index)
    assert os.path.getsize(index) < os.path.getsize(shards[0])
    same_numbers(whole, index)
    report = lambda path, *words: good("info", path, "--all", "--report", place("r.json"), *words) and json.load(open(place("r.json")))["figures"]
    a, b = report(whole), report(index)
    assert b["virtual"] is True and "virtual" not in a
    assert all(a[key] == b[key] for key in a if key not in ("file", "bytes")), (a, b)
    # Merging the index gives the whole, and an index of an index is refused.
    good("merge", index, "-o", place("again.vis.h5"))
    assert digest(place("again.vis.h5")) == digest(whole)
    refused([index, "-o", place("x.vis.h5"), "--virtual"], "--virtual", code=1)
    for name in ("reference", ):
        good(name, index, "--frame", 3, "--size", "16x12", "--samples", 4, "-o", place("a.png"))
        good(name, whole, "--frame", 3, "--size", "16x12", "--samples", 4, "-o", place("b.png"))
        assert digest(place("a.png")) == digest(place("b.png"))
    # Moved together, index and shards are still whole.
    os.rename(place("shards"), place("moved"))
    result = run("info", index)
    assert result.returncode == 2 and "s0.vis.h5" in result.stderr and "missing" in result.stderr, result
    with h5py.File(index) as f:  # HDF5 alone reports no error here, but reads NaN instead of zeros
        assert np.isnan(f["visibility/coefficients"][0]).all() and np.isnan(f["frames/positions"][0]).all()
    os.rename(place("moved"), place("shards"))
    assert run("info", index).returncode == 0
    data = bytearray(open(shards[2], "rb").read())
    data[len(data) // 2] ^= 1
    open(shards[2], "wb").write(data)
    result = run("info", index)
    assert result.returncode == 3 and "s2.vis.h5" in result.stderr and "changed" in result.stderr, result
    os.remove(shards[2])
    result = run("merge", index, "-o", place("x.vis.h5"))
    assert result.returncode == 2 and "s2.vis.h5" in result.stderr and not os.path.exists(place("x.vis.h5")), result
    # These shards give that index again.
    bake(shards[2], "--precision", "f16", "--frames", f"2:{frames}:4")
    good("merge", *shards, "-o", index, "--virtual", "-q")
    assert digest(index) == first
    # A shard with a flipped bit, in what all share or in what its frames hold, is refused by name before there is an
    # index.
    good_shard = open(shards[1], "rb").read()
    with h5py.File(shards[1]) as f:
        places = {name: f[name].id.get_chunk_info(0).byte_offset for name in
                  ("mesh/triangles", "frames/time", "frames/positions", "frames/bones", "frames/pose", "visibility/coefficients")}
    for name, at in places.items():
        write_bytes(shards[1], good_shard[:at + 9] + bytes([good_shard[at + 9] ^ 16]) + good_shard[at + 10:])
        for words in ([], ["--virtual"]):
            refused([*shards, "-o", place("x.vis.h5"), *words], f"s1.vis.h5: /{name}: damaged")
            assert not os.path.exists(place("x.vis.h5"))
    write_bytes(shards[1], good_shard)
    # Somebody edited this index.
    for name, value in (("virtual/frame_in_file", 10**6), ("virtual/file_of_frame", 9)):
        shutil.copy(index, place("out/odd.vis.h5"))
        with h5py.File(place("out/odd.vis.h5"), "r+") as f:
            f[name][0] = value
        result = run("info", place("out/odd.vis.h5"))
        assert result.returncode == 3 and name in result.stderr, result


def flip_bit(path, dataset):
    with h5py.File(path) as f:
        at = f[dataset].id.get_chunk_info(0).byte_offset + 9
    data = bytearray(open(path, "rb").read())
    data[at] ^= 16
    write_bytes(path, data)


def check_all_named(folder):
    """One run names all that must be baked again: files that are not there, cut short or damaged, and frames that
    nobody has."""
    place = lambda name: os.path.join(folder, name)
    out, report = place("out.vis.h5"), place("r.json")
    frames = 15
    shards = [bake(place(f"s{i}.vis.h5"), "--frames", f"{3 * i}:{3 * i + 3}") for i in range(5)]
    whole = ["--frames", f"0:{frames}", "-o", out, "--report", report]
    good("merge", *shards, *whole)
    kept = [open(shard, "rb").read() for shard in shards]
    write_bytes(shards[1], kept[1][:len(kept[1]) // 2])
    flip_bit(shards[2], "frames/positions")
    os.remove(shards[3])
    refused([*shards[:4], *whole], "s1.vis.h5: ", "s2.vis.h5: /frames/positions: damaged", "s3.vis.h5: cannot read", "; missing frames: ")
    figures = json.load(open(report))["figures"]
    named = lambda kind: [sentence.partition(": ")[0] for sentence in figures[kind]]
    assert figures["shards"] == 4 and named("unusable") == shards[1:3] and named("unreadable") == [shards[3]], figures
    # frames of s1, s3 and s4
    assert len(figures["missing"]) == 9 and not figures["twice"] + figures["different"], figures
    # Files that cannot be read are worth another try. Nothing is known without one that can.
    write_bytes(shards[1], kept[1])
    write_bytes(shards[2], kept[2])
    refused([*shards, *whole], "cannot be read: ", "s3.vis.h5", "; missing frames: ", code=2)
    refused([shards[3], *whole], "s3.vis.h5", code=2)
    # A shard of another version of the format is named like the others. That is a matter of the program.
    with h5py.File(shards[1], "r+") as f:
        f.attrs.modify("format_version", 99)
    refused([*shards, *whole], "not supported: ", "s1.vis.h5", "cannot be read: ", "s3.vis.h5", "; missing frames: ", code=5)
    write_bytes(shards[1], kept[1])
    # The merge comes upon this damage while it writes.
    write_bytes(shards[3], kept[3])
    for i in (1, 4):
        flip_bit(shards[i], "visibility/coefficients")
    before = digest(out)
    for words in ([], ["--virtual"]):
        refused([*shards, *whole, *words], *(f"s{i}.vis.h5: /visibility/coefficients: damaged" for i in (1, 4)))
        assert len(json.load(open(report))["figures"]["unusable"]) == 2 and digest(out) == before


def main():
    for check in (check_splits, check_choices, check_standing, check_refusals, check_virtual, check_all_named):
        with tempfile.TemporaryDirectory() as folder:
            check(folder)
            print(f"{check.__name__}: ok")


main()
