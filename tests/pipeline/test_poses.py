"""penumbra-bake poses as a user runs it: lists and rigs of poses, their bakes, bad input.

usage: test_poses.py BIN
"""
import json
import os
import shutil
import struct
import sys
import tempfile

import h5py
import numpy as np

from gltf_reference import Evaluator
from programs import run

BIN = sys.argv[1]
BAKE, FIT = (os.path.join(BIN, name) for name in ("penumbra-bake", "penumbra-fit"))
SAMPLES = os.path.join(BIN, "..", "samples")
MAN = os.path.join(SAMPLES, "capsule_man.glb")
FEW = ["--rays", "16", "--order", "1"]


def poses(out, *words, rig=MAN):
    report = os.path.splitext(out)[0] + ".json"
    result = run(BAKE, "poses", rig, "-o", out, *words, "--report", report)
    assert result.returncode == 0, (words, result.stderr)
    return json.load(open(report))["figures"]


def bake(out, rig, *words):
    result = run(BAKE, "visibility", rig, "-o", out, *FEW, *words)
    assert result.returncode == 0, (words, result.stderr)
    return h5py.File(out)


def check_list(folder):
    """The list is a permutation of the best frames, the same for any thread count, and traceable."""
    out = os.path.join(folder, "man.poses.h5")
    words = ["--fps", 10, "--choose", 12, "--sample", 5, "--holdout", "squat"]
    figures = poses(out, *words)
    first = open(out, "rb").read()
    for threads in (1, 2, 8):
        poses(out, *words, "--threads", threads)
        assert open(out, "rb").read() == first, threads
    with h5py.File(out) as f:
        assert f.attrs["format"] == "penumbra.poses" and f.attrs["format_version"] == 1
        names = [name.decode() for name in f["clips/names"][:]]
        assert names == ["wave", "walk", "sampled"], names
        table = [
            {"clip": names[c], "time": t, "rank": r, "distance": d}
            for c, t, r, d in zip(f["frames/clip"][:], f["frames/time"][:], f["frames/rank"][:], f["frames/distance"][:])
        ]
        assert table == figures["poses"], (table, figures["poses"])
        assert sorted(row["rank"] for row in table) == list(range(17))
        assert f["sampled/pose"].shape == (5, 3 * len(f["skin/joint_names"]))
        provenance = json.loads(f.attrs["provenance"])
        assert provenance["options"]["holdout"] == ["squat"] and provenance["inputs"][0]["name"] == "capsule_man.glb"
    assert (figures["chosen"], figures["sampled"], figures["candidates"]) == (12, 5, 62), figures
    distances = [row["distance"] for row in sorted(table, key=lambda row: row["rank"])][1:12]
    assert distances == sorted(distances, reverse=True) and figures["largest_gap"] <= distances[-1], figures
    limits = {(row["joint"], row["axis"]): (row["min"], row["max"]) for row in figures["limits_degrees"]}
    assert limits and all(low <= high for low, high in limits.values())
    fewer = poses(os.path.join(folder, "fewer.poses.h5"), "--fps", 10, "--choose", 4, "--holdout", "squat")
    best = {(row["clip"], row["time"]) for row in table if row["rank"] < 4}
    assert {(row["clip"], row["time"]) for row in fewer["poses"]} == best
    gaps = {}
    for method in ("farthest", "representative", "random"):
        other = poses(os.path.join(folder, "other.poses.h5"), "--fps", 10, "--choose", 12, "--method", method)
        gaps[method] = (other["largest_gap"], other["mean_gap"])
    assert min(gaps, key=lambda m: gaps[m][0]) == "farthest", gaps
    assert min(gaps, key=lambda m: gaps[m][1]) == "representative", gaps
    info = run(BAKE, "info", out)
    assert info.returncode == 0 and "penumbra.poses" in info.stdout and "wave" in info.stdout, info
    return out


def check_limits(folder):
    """A joint that the table holds still stays still. Another turns as far as the table says."""
    table = os.path.join(folder, "limits.csv")
    with h5py.File(os.path.join(folder, "man.poses.h5")) as f:
        joints = [name.decode() for name in f["skin/joint_names"][:]]
    open(table, "w").write(f"joint,axis,min,max\n{joints[2]},x,40,50\n{joints[2]},y,0,0\n{joints[2]},z,0,0\n")
    out = os.path.join(folder, "limits.poses.h5")
    poses(out, "--fps", 10, "--sample", 64, "--limits", table, "--seed", 3)
    with h5py.File(out) as f:
        turned = np.degrees(f["sampled/pose"][:, 6:9])
    assert 40 <= turned[:, 0].min() < 40.5 and 49.5 < turned[:, 0].max() <= 50, turned
    assert np.abs(turned[:, 1:]).max() == 0, turned


def check_bakes(folder, listed):
    """Bakes of the list and of the rig hold the poses of the source, by an evaluation of our own."""
    rig = os.path.join(folder, "poses.glb")
    figures = poses(rig, "--fps", 10, "--choose", 12, "--sample", 5, "--holdout", "squat")
    with open(rig, "rb") as f:
        scene = json.loads(f.read()[20 : 20 + struct.unpack_from("<I", open(rig, "rb").read(20), 12)[0]])
    assert scene["extras"]["penumbra_poses"] == figures["poses"]
    of_list = bake(os.path.join(folder, "list.vis.h5"), MAN, "--poses", listed)
    of_rig = bake(os.path.join(folder, "rig.vis.h5"), rig)
    at_one_fps = bake(os.path.join(folder, "fps.vis.h5"), rig, "--fps", 1)
    assert [name.decode() for name in of_list["clips/names"][:]] == ["wave", "walk", "sampled"]
    assert [name.decode() for name in of_rig["clips/names"][:]] == ["poses"]
    inputs = json.loads(of_list.attrs["provenance"])["inputs"]
    assert [i["name"] for i in inputs] == ["capsule_man.glb", "man.poses.h5"], inputs
    assert np.array_equal(of_rig["frames/time"][:], np.arange(17)) and len(at_one_fps["frames/time"]) == 17
    for name in ("mesh/triangles", "mesh/rest_positions", "mesh/source_vertex", "skin/joint_names", "skin/joints"):
        assert np.array_equal(of_list[name][:], of_rig[name][:]), name
    source, written = Evaluator(MAN), Evaluator(rig)
    clips = [name for name, _ in source.clips]
    for f, row in enumerate(figures["poses"]):
        shown = of_rig["frames/positions"][f]
        diagonal = np.linalg.norm(np.ptp(shown, axis=0))
        assert np.abs(of_list["frames/positions"][f] - shown).max() < 1e-5 * diagonal, f  # 3e-7 measured
        if row["clip"] != "sampled":
            expected = source.positions(clips.index(row["clip"]), row["time"])
            assert np.abs(expected - shown[of_rig["mesh/source_vertex"][:]]).max() < 1e-5 * diagonal, row
        again = written.positions(0, f)
        assert np.abs(again - shown[of_rig["mesh/source_vertex"][:]]).max() < 1e-5 * diagonal, row
    # Sampled poses give their rotation vectors back.
    with h5py.File(listed) as f:
        assert np.abs(of_list["frames/pose"][12:] - f["sampled/pose"][:]).max() < 1e-5


def relative_moves(bones, parents, joint):
    """[F,4,4]: how a joint moved against its parent joint, in the rest space."""
    full = np.zeros((len(bones), bones.shape[1], 4, 4))
    full[:, :, :3] = bones.reshape(len(bones), -1, 3, 4)
    full[:, :, 3, 3] = 1
    return np.linalg.inv(full[:, parents[joint]]) @ full[:, joint]


def check_mixed(folder):
    """Mixed poses are listed after the frames that they are mixed from, and every joint moves as in one of these, or as
    the joint on the other side in a mirror."""
    out = os.path.join(folder, "mixed.poses.h5")
    words = ["--fps", 5, "--holdout", "squat", "--mix", 12, "--cover", 4]
    figures = poses(out, *words)
    first = open(out, "rb").read()
    for threads in (1, 2, 8):
        poses(out, *words, "--threads", threads)
        assert open(out, "rb").read() == first, threads
    assert figures["chosen"] == figures["candidates"] == 32 and "largest_gap" not in figures, figures
    mixed = figures["mixed"]
    assert (mixed["poses"], mixed["limbs"], mixed["mirrored_limbs"]) == (16, 7, 7), mixed
    assert 1 > mixed["open_before_covering"] > mixed["open_after_covering"] > 0, mixed
    with h5py.File(out) as f:
        assert [name.decode() for name in f["clips/names"][:]] == ["wave", "walk", "mixed"]
        assert f["mixed/nodes"].shape == (16, len(f["mixed/node_names"]), 10)
        assert np.array_equal(f["frames/time"][32:], np.arange(16))
        options = json.loads(f.attrs["provenance"])["options"]
        assert (options["mix"], options["cover"]) == (12, 4), options
    check_mixed_bakes(folder, out)
    both = poses(os.path.join(folder, "both.poses.h5"), "--fps", 5, "--choose", 6, "--sample", 3, "--mix", 12)
    assert list(both["frames_by_clip"])[-2:] == ["sampled", "mixed"], both
    info = run(BAKE, "info", out)
    assert info.returncode == 0 and "mixed                  16\n" in info.stdout, info
    dry = run(BAKE, "poses", MAN, "-o", os.path.join(folder, "dry.poses.h5"), *words, "--dry-run")
    assert dry.stdout == "32 of 32 frames, 0 sampled poses, 16 mixed poses\n", dry


def check_mixed_bakes(folder, listed):
    """Bakes of the list and of a rig of these poses agree, and hold limbs of the listed frames."""
    rig = os.path.join(folder, "mixed.glb")
    poses(rig, "--fps", 5, "--holdout", "squat", "--mix", 12, "--cover", 4)
    of_list = bake(os.path.join(folder, "mixed.vis.h5"), MAN, "--poses", listed)
    of_rig = bake(os.path.join(folder, "mixed_rig.vis.h5"), rig)
    assert [name.decode() for name in of_list["clips/names"][:]] == ["wave", "walk", "mixed"]
    difference = np.abs(of_list["frames/positions"][:] - of_rig["frames/positions"][:]).max()
    assert difference < 1e-5, difference  # metres; 5e-7 measured
    names = [name.decode() for name in of_list["skin/joint_names"][:]]
    parents = of_list["skin/parents"][:]
    mirror = np.diag([-1, 1, 1, 1])
    seen = set()
    for joint, name in enumerate(names):
        if parents[joint] < 0:
            continue
        other = names.index(name[:-1] + {"L": "R", "R": "L"}[name[-1]]) if name[-2] == "." else joint
        moves = relative_moves(of_list["frames/bones"][:], parents, joint)
        images = mirror @ relative_moves(of_list["frames/bones"][:32], parents, other) @ mirror
        for move in moves[32:]:
            as_frame = np.abs(moves[:32] - move).max((1, 2)).min()
            as_image = np.abs(images - move).max((1, 2)).min()
            seen.add(as_frame > 1e-4)
            assert min(as_frame, as_image) < 1e-5, (name, as_frame, as_image)  # 1e-6 measured
    assert seen == {False, True}, seen


def check_formats(folder):
    """Poses come from whatever assimp reads as well."""
    for name in ("swing.fbx", "swing.dae", "swing.x"):
        rig = os.path.join(SAMPLES, name)
        for extension in ("poses.h5", "glb"):
            out = os.path.join(folder, name + "." + extension)
            figures = poses(out, "--fps", 10, "--choose", 3, "--sample", 2, rig=rig)
            assert figures["chosen"] == 3, figures
        a = bake(os.path.join(folder, "a.vis.h5"), rig, "--poses", os.path.join(folder, name + ".poses.h5"))
        b = bake(os.path.join(folder, "b.vis.h5"), os.path.join(folder, name + ".glb"))
        assert np.abs(a["frames/positions"][:] - b["frames/positions"][:]).max() < 1e-5, name
        a.close(), b.close()


def check_training(folder):
    """penumbra-fit trains on listed frames alone. Clips keep their names, so that hold-outs work."""
    listed, all_frames = os.path.join(folder, "train.poses.h5"), os.path.join(folder, "all.vis.h5")
    poses(listed, "--fps", 5, "--choose", 14, "--holdout", "squat")
    bake(all_frames, MAN, "--fps", 5).close()
    model, report = os.path.join(folder, "m.model.h5"), os.path.join(folder, "m.json")
    words = [FIT, "visibility", all_frames, "-o", model, "--convention", "A1", "--report", report]
    result = run(*words, "--holdout", "squat", "--train-frames", listed)
    assert result.returncode == 0, result.stderr
    figures = json.load(open(report))["figures"]
    assert (figures["train_frames"], figures["held_out_frames"]) == (14, 16), figures
    with h5py.File(model) as f:
        assert [i["name"] for i in json.loads(f.attrs["provenance"])["inputs"]] == ["all.vis.h5", "train.poses.h5"]
    # A bake of nothing but these training frames, with the held-out clip in full, gives the same model.
    both = os.path.join(folder, "both.vis.h5")
    bake(both, MAN, "--poses", listed, "--clips", "squat", "--fps", 5).close()
    result = run(FIT, "visibility", both, "-o", os.path.join(folder, "n.model.h5"), "--convention", "A1",
                 "--holdout", "squat", "--report", report)
    assert result.returncode == 0, result.stderr
    other = json.load(open(report))["figures"]
    assert abs(other["held_out"]["relative_error"] - figures["held_out"]["relative_error"]) < 1e-9, (other, figures)
    os.remove(model)
    result = run(*words, "--holdout", "wave", "--train-frames", listed)
    assert result.returncode == 1 and "clip 'wave'" in result.stderr and "held out" in result.stderr, result
    result = run(FIT, "visibility", os.path.join(folder, "list.vis.h5"), *words[3:], "--train-frames", listed)
    assert result.returncode == 1 and "no such frame" in result.stderr, result
    result = run(*words, "--train-frames", MAN)
    assert result.returncode == 3 and "capsule_man.glb" in result.stderr, result
    assert not os.path.exists(model)


def rename_first(names):
    texts = names[:]
    texts[0] = b"x"
    names[:] = texts


def check_failures(folder):
    place = lambda name: os.path.join(folder, name)
    open(place("empty.csv"), "w").close()
    open(place("cut.poses.h5"), "wb").write(open(place("man.poses.h5"), "rb").read()[:5000])
    out = place("out.poses.h5")
    cases = [
        ([MAN], 1, "--choose"),
        ([MAN, "--choose", "94"], 1, "at most 93"),
        ([MAN, "--choose", "-1"], 1, "--choose must be 0.."),
        ([MAN, "--choose", "many"], 1, "--choose"),
        ([MAN, "--sample", "1000001"], 1, "--sample must be 0..1000000"),
        ([MAN, "--mix", "0"], 1, "--mix"),
        ([MAN, "--mix", "-1"], 1, "--mix must be 0..1000000 poses, not -1"),
        ([MAN, "--mix", "1000000000"], 1, "--mix must be 0..1000000 poses"),
        ([MAN, "--mix", "1e99"], 1, "--mix"),
        ([MAN, "--cover", "10001"], 1, "--cover must be 0..10000 poses, not 10001"),
        ([MAN, "--mix", "3", "--choose", "1"], 1, "at least 2 frames"),
        ([MAN, "--mix", "3", "--limits", place("empty.csv")], 1, "--limits needs --sample"),
        ([os.path.join(SAMPLES, "bend.glb"), "--mix", "3"], 1, "no fork"),
        ([MAN, "--choose", "3", "--method", "best"], 1, "--method"),
        ([MAN, "--choose", "3", "--seed", "-1"], 1, "--seed must be 0..9223372036854775807, not -1"),
        ([MAN, "--choose", "3", "--clips", "moonwalk"], 1, "moonwalk"),
        ([MAN, "--choose", "3", "--holdout", "moonwalk"], 1, "moonwalk"),
        ([MAN, "--choose", "3", "--holdout", "wave,walk,squat"], 1, "no clip is left"),
        ([MAN, "--choose", "3", "--clips", "wave", "--holdout", "wave"], 1, "no clip is left"),
        ([MAN, "--choose", "3", "--frames", "0:1000"], 1, "--frames must end at most at"),
        ([MAN, "--choose", "3", "--limits", place("empty.csv")], 1, "--limits needs --sample"),
        ([MAN, "--sample", "3", "--limits", place("empty.csv")], 3, "empty.csv"),
        ([MAN, "--sample", "3", "--limits", place("none.csv")], 2, "none.csv"),
        ([MAN, MAN, "--choose", "3"], 1, "given twice"),
        ([place("none.glb"), "--choose", "3"], 2, "none.glb"),
        ([place("cut.poses.h5"), "--choose", "3"], 5, "not a rig"),
        ([], 1, "rig"),
    ]
    for words, code, name in cases:
        result = run(BAKE, "poses", *words, "--fps", "10", "-o", out)
        assert result.returncode == code and len(result.stderr.splitlines()) == 1, (words, result)
        assert name in result.stderr and not os.path.exists(out), (words, result)
    assert run(BAKE, "poses", MAN, "--choose", 3, "-o", place("out.txt")).returncode == 1
    assert run(BAKE, "poses", MAN, "--choose", 3, "-o", place("nowhere/x.glb")).returncode == 2
    assert run(BAKE, "poses", MAN, "--choose", 3, "-o", out, "--dry-run").returncode == 0 and not os.path.exists(out)
    for name, damage in (("other", lambda f: rename_first(f["mixed/node_names"])),
                         ("nan", lambda f: f["mixed/nodes"].__setitem__((0, 0, 0), np.nan))):
        shutil.copy(place("mixed.poses.h5"), place(name + ".poses.h5"))
        with h5py.File(place(name + ".poses.h5"), "r+") as f:
            damage(f)
    cases = [
        ([MAN, "--poses", place("cut.poses.h5")], 3, "cut.poses.h5"),
        ([MAN, "--poses", place("none.poses.h5")], 2, "none.poses.h5"),
        ([MAN, "--poses", place("list.vis.h5")], 3, "penumbra.visibility"),
        ([MAN, "--poses", place("man.poses.h5"), "--fps", "5"], 1, "--fps needs --clips"),
        ([MAN, "--poses", place("man.poses.h5"), "--clips", "walk"], 1, "walk"),
        ([os.path.join(SAMPLES, "bend.glb"), "--poses", place("man.poses.h5")], 3, "no clip 'wave'"),
        ([MAN, "--poses", place("other.poses.h5")], 3, "/mixed/node_names: mixed poses of a rig with other nodes"),
        ([MAN, "--poses", place("nan.poses.h5")], 3, "/mixed/nodes"),
        ([place("mixed.glb"), "--poses", place("mixed.poses.h5")], 3, "no clip 'wave'"),
    ]
    for words, code, name in cases:
        result = run(BAKE, "visibility", *words, "-o", place("out.vis.h5"), *FEW)
        assert result.returncode == code and len(result.stderr.splitlines()) == 1, (words, result)
        assert name in result.stderr and not os.path.exists(place("out.vis.h5")), (words, result)


def main():
    with tempfile.TemporaryDirectory() as folder:
        listed = check_list(folder)
        check_limits(folder)
        check_bakes(folder, listed)
        check_mixed(folder)
        check_formats(folder)
        check_training(folder)
        check_failures(folder)
    print("lists, limits, bakes of them, mixed poses, other formats, training on them, bad input: ok")


main()
