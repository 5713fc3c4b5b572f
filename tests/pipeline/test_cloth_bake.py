"""Baking a mesh without a skeleton: point caches, either side of a sheet, occluders, inputs.

usage: test_cloth_bake.py BIN
"""
import json
import os
import signal
import subprocess
import sys
import tempfile
import time

import h5py
import numpy as np

from programs import digest

BIN = os.path.abspath(sys.argv[1])
BAKE = os.path.join(BIN, "penumbra-bake")
FRAMES, SIDE = 20, 13
SMALL = ["--rays", "32", "--order", "3"]


def run(*words, code=0):
    result = subprocess.run([BAKE, *map(str, words)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    assert result.returncode == code, (words, result)
    return result


def refused(code, *parts, words):
    result = run(*words, code=code)
    assert len(result.stderr.splitlines()) == 1, (words, result)
    for part in parts:
        assert part in result.stderr, (part, result.stderr)


def sheet(side, frames):
    """Makes a square sheet that is rolled up, more than once round at the end: positions [F,V,3] and faces."""
    u, v = np.meshgrid(np.linspace(0, 1, side), np.linspace(0, 1, side), indexing="ij")
    turn = np.linspace(1e-3, 9, frames)[:, None, None]
    positions = np.stack(
        [np.sin(turn * u) / turn, (1 - np.cos(turn * u)) / turn + 0.02 * u, np.broadcast_to(v, (frames, side, side))], -1
    )
    corner = (np.arange(side - 1)[:, None] * side + np.arange(side - 1)).ravel()
    faces = np.concatenate(
        [np.stack([corner, corner + 1, corner + side], 1), np.stack([corner + 1, corner + side + 1, corner + side], 1)]
    )
    return positions.reshape(frames, -1, 3).astype("f4"), faces.astype("i4")


def ball(center, radius, rings=12):
    t, p = np.meshgrid(np.pi * np.arange(1, rings) / rings, np.pi * np.arange(2 * rings) / rings, indexing="ij")
    middle = np.stack([np.sin(t) * np.cos(p), np.cos(t), np.sin(t) * np.sin(p)], -1).reshape(-1, 3)
    positions = np.concatenate([[[0, 1, 0]], middle, [[0, -1, 0]]])
    at = lambda i, j: 1 + (i - 1) * 2 * rings + j % (2 * rings)
    faces = [[0, at(1, j + 1), at(1, j)] for j in range(2 * rings)]
    faces += [[len(positions) - 1, at(rings - 1, j), at(rings - 1, j + 1)] for j in range(2 * rings)]
    for i in range(1, rings - 1):
        for j in range(2 * rings):
            faces += [[at(i, j), at(i, j + 1), at(i + 1, j)], [at(i + 1, j), at(i, j + 1), at(i + 1, j + 1)]]
    return (np.asarray(center) + radius * positions).astype("f4"), np.array(faces, "i4")


def angles_of(positions, edges):
    """Returns signed dihedral angles in double, unwrapped by numpy."""
    a, b, c, d = (positions[:, edges[:, k]].astype("f8") for k in range(4))
    n1, n2 = np.cross(b - a, c - a), np.cross(d - a, b - a)
    sine = np.sum(np.cross(n1, n2) * (b - a), -1)
    return np.unwrap(np.arctan2(sine, np.sum(n1 * n2, -1) * np.linalg.norm(b - a, axis=-1)), axis=0)


def check_cache(folder, cache):
    """Frames are those of the cache, the pose is its dihedral angles, and normals are those of the triangles."""
    positions, faces = sheet(SIDE, FRAMES)
    out = os.path.join(folder, "x.vis.h5")
    assert "estimate from a probe" in run("visibility", cache, "-o", out, *SMALL, "--dry-run").stdout
    run("visibility", cache, "-o", out, *SMALL, "--depfile", os.path.join(folder, "x.d"))
    assert cache in open(os.path.join(folder, "x.d")).read()
    with h5py.File(out) as f:
        assert "skin" not in f and "bones" not in f["frames"] and "two_sided" not in f.attrs
        assert np.array_equal(f["frames/positions"], positions) and np.array_equal(f["mesh/rest_positions"], positions[0])
        assert np.array_equal(f["mesh/triangles"], faces) and list(f["clips/names"]) == [b"sheet"]
        assert np.allclose(f["frames/time"], np.arange(FRAMES) / 10)
        edges, pose = f["mesh/edges"][:], f["frames/pose"][:]
        assert f["frames/pose"].attrs["parameterisation"] == "dihedral_angles"
        assert len(edges) == (SIDE - 1) ** 2 + 2 * (SIDE - 1) * (SIDE - 2) and pose.shape == (FRAMES, len(edges))
        assert np.abs(pose - angles_of(positions, edges)).max() < 2e-5, np.abs(pose - angles_of(positions, edges)).max()
        a, b, c = (positions[7][faces[:, k]].astype("f8") for k in range(3))
        normals = np.zeros_like(positions[7], "f8")
        for k in range(3):
            np.add.at(normals, faces[:, k], np.cross(b - a, c - a))
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
        assert np.abs(f["frames/normals"][7] - normals).max() < 1e-6
        assert f["visibility/coefficients"].shape == (FRAMES, SIDE * SIDE, 9)
    info = run("info", out).stdout
    assert "dihedral_angles" in info, info


def check_blocks(folder, cache):
    """With --blocks the frames of the whole stand in five clips whose times go on. The angles do not see the cuts."""
    whole, blocks, part = (os.path.join(folder, name + ".vis.h5") for name in ("whole", "blocks", "part"))
    run("visibility", cache, "-o", whole, *SMALL)
    run("visibility", cache, "-o", blocks, *SMALL, "--blocks", "3")
    run("visibility", cache, "-o", part, *SMALL, "--blocks", "3", "--frames", "5:20:7")
    with h5py.File(whole) as a, h5py.File(blocks) as b, h5py.File(part) as c:
        assert list(b["clips/names"]) == [b"sheet#1", b"sheet#2", b"sheet#3"]
        assert np.bincount(b["frames/clip"]).tolist() == [6, 7, 7], b["frames/clip"][:]
        for name in ("frames/time", "frames/pose", "frames/positions", "visibility/coefficients"):
            assert np.array_equal(a[name], b[name]) and np.array_equal(a[name][5:20:7], c[name]), name
    refused(1, "--blocks", words=["visibility", cache, "-o", part, "--blocks", "0"])
    refused(1, "--blocks must be at most", words=["visibility", cache, "-o", part, "--blocks", "1000"])
    refused(1, "--up", words=["visibility", os.path.join(BIN, "..", "samples", "bend.glb"), "-o", part, "--up", "z"])


def check_shards(folder, words):
    """Any split into shards and any number of threads, killed or not, gives one file."""
    whole, sums = os.path.join(folder, "whole.vis.h5"), set()
    bake = lambda out, *more: run("visibility", *words, "-o", out, "-q", *more)
    bake(whole)
    sums.add(digest(whole))
    for count, threads in ((1, 1), (2, 1), (2, 2), (7, 2), (7, 8)):
        shards = [os.path.join(folder, f"s{i}.vis.h5") for i in range(count)]
        for i, shard in enumerate(shards):
            bake(shard, "--threads", threads, "--frames", f"{i}:{FRAMES}:{count}")
        run("merge", *shards, "-o", whole, "-q")
        sums.add(digest(whole))
    os.remove(whole)
    command = [BAKE, "visibility", *map(str, words), "-o", whole, "--resume", "--threads", "1"]
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    while process.poll() is None and not (
        os.path.exists(whole + ".journal") and os.path.getsize(whole + ".journal") > 100000
    ):
        time.sleep(0.002)
    process.send_signal(signal.SIGKILL)
    assert process.wait() == -9, "it was done before it could be killed"
    run("visibility", *words, "-o", whole, "--resume", "--report", os.path.join(folder, "r.json"))
    with open(os.path.join(folder, "r.json")) as f:
        assert json.load(f)["figures"]["frames_resumed"] > 0
    sums.add(digest(whole))
    assert len(sums) == 1, sums


def save(path, positions, faces, fps=10):
    np.savez(path, verts=np.asarray(positions, "f4"), faces=faces, fps=np.float32(fps))
    return path


def coefficients(path):
    with h5py.File(path) as f:
        return f["visibility/coefficients"][:]


def check_two_sided(folder, cache):
    """Backs stand behind fronts, which are as without them. A cape of a rig has backs too."""
    one, two = os.path.join(folder, "one.vis.h5"), os.path.join(folder, "two.vis.h5")
    run("visibility", cache, "-o", one, *SMALL)
    run("visibility", cache, "-o", two, *SMALL, "--two-sided")
    with h5py.File(one) as a, h5py.File(two) as b:
        count, triangles = a["mesh/rest_positions"].shape[0], a["mesh/triangles"][:]
        assert b.attrs["two_sided"] == 1
        for name in ("frames/positions", "frames/normals", "visibility/coefficients"):
            assert np.array_equal(a[name], b[name][:, :count]), name
        assert np.array_equal(b["frames/positions"][:, count:], a["frames/positions"])
        assert np.array_equal(b["frames/normals"][:, count:], -a["frames/normals"][:])
        assert np.array_equal(b["mesh/rest_normals"][count:], -a["mesh/rest_normals"][:])
        assert np.array_equal(b["mesh/triangles"], np.concatenate([triangles, triangles[:, [0, 2, 1]] + count]))
        for name in ("mesh/source_vertex", "mesh/edges", "frames/pose"):
            assert np.array_equal(a[name], b[name]), name
        # The sheet is rolled up to a scroll, so its inside is darker than its outside.
        share = b["visibility/coefficients"][-1, :, 0] / np.sqrt(np.pi)
        assert share[:count].mean() + 0.3 < share[count:].mean() or share[count:].mean() + 0.3 < share[:count].mean()
    rig = os.path.join(BIN, "..", "samples", "bend.glb")
    run("visibility", rig, "-o", two, *SMALL, "--two-sided", "--fps", "1")
    with h5py.File(two) as f:
        count = f["mesh/rest_positions"].shape[0] // 2
        assert np.array_equal(f["skin/joints"][:count], f["skin/joints"][count:]) and f.attrs["two_sided"] == 1
        assert np.array_equal(f["frames/normals"][:, :count], -f["frames/normals"][:, count:])


def check_occluders(folder, cache):
    """A ball moves. Each frame equals that of a bake with the ball standing there, and the ball brings no vertex of
    its own."""
    positions, faces = ball((0, 0, 0), 0.2)
    path = np.stack([np.linspace(-1, 1, FRAMES), np.full(FRAMES, 0.3), np.full(FRAMES, 0.5)], -1)
    moving = save(os.path.join(folder, "ball.npz"), positions + path[:, None].astype("f4"), faces)
    plain, out, still = (os.path.join(folder, name + ".vis.h5") for name in ("plain", "out", "still"))
    words = [*SMALL, "--two-sided"]
    run("visibility", cache, "-o", plain, *words)
    run("visibility", cache, "-o", out, *words, "--occluder", moving, "--depfile", os.path.join(folder, "x.d"))
    assert moving in open(os.path.join(folder, "x.d")).read()
    b = coefficients(out)
    assert b.shape == coefficients(plain).shape and np.abs(b - coefficients(plain)).max() > 0.1
    with h5py.File(out) as f:
        inputs = [i["name"] for i in json.loads(f.attrs["provenance"])["inputs"]]
        assert inputs == ["sheet.npz", "ball.npz"], inputs
    for frame in (0, 11, 19):
        there = save(os.path.join(folder, "there.npz"), positions[None] + path[frame].astype("f4"), faces)
        run("visibility", cache, "-o", still, *words, "--occluder", there, "--frames", f"{frame}:{frame + 1}")
        assert np.array_equal(coefficients(still)[0], b[frame]), frame
    # This bakes in blocks, and with two occluders.
    run("visibility", cache, "-o", still, *words, "--occluder", moving, "--occluder", there, "--blocks", "2")
    assert np.all(coefficients(still)[:, :, 0] <= b[:, :, 0] + 1e-6)
    # An occluder must last as long as the mesh, and have a clip that goes with the mesh's.
    short = save(os.path.join(folder, "short.npz"), positions[None] + path[:5, None].astype("f4"), faces)
    refused(3, "short.npz", "ends at", words=["visibility", cache, "-o", still, "--occluder", short])
    refused(2, "nowhere", words=["visibility", cache, "-o", still, "--occluder", os.path.join(folder, "nowhere.npz")])
    check_reference(folder, out, moving, there)
    check_paired_occluder(folder, cache, positions + path[:, None].astype("f4"), faces, b)


def check_reference(folder, baked, moving, other):
    """Pictures want the occluders of the bake, and show what it holds."""
    picture = os.path.join(folder, "x.png")
    words = ["reference", baked, "--frame", 11, "-o", picture, "--size", "48x48", "--samples", "16", "--channel", "ao"]
    refused(1, "ball.npz", "--occluder", words=words)
    refused(1, "not what", words=[*words, "--occluder", other])
    run(*words, "--occluder", moving)
    assert os.path.getsize(picture) > 200


def check_paired_occluder(folder, cache, positions, faces, expected):
    """MESH:CACHE blocks as one file that holds both does, in a bake and in a picture of it."""
    mesh, mdd, out = (os.path.join(folder, name) for name in ("ball.obj", "ball.mdd", "pair.vis.h5"))
    with open(mesh, "w") as f:
        f.writelines("v %.9g %.9g %.9g\n" % tuple(p) for p in positions[0])
        f.writelines("f %d %d %d\n" % tuple(t + 1) for t in faces)
    with open(mdd, "wb") as f:
        np.array(positions.shape[:2], ">i4").tofile(f)
        (np.arange(len(positions)) / 10).astype(">f4").tofile(f)
        positions.astype(">f4").tofile(f)
    words = ["visibility", cache, "-o", out, *SMALL, "--two-sided", "--cache-fps", "10"]  # times of .mdd are floats
    for pair in (f"{mesh}:{mdd}", f"{mdd}:{mesh}"):
        run(*words, "--occluder", pair, "--depfile", os.path.join(folder, "x.d"))
        assert np.array_equal(coefficients(out), expected)
        made_of = open(os.path.join(folder, "x.d")).read()
        assert mesh in made_of and mdd in made_of, made_of
    with h5py.File(out) as f:
        assert json.loads(f.attrs["provenance"])["options"]["occluders"] == ["ball.mdd:ball.obj"], f.attrs["provenance"]
    picture = ["reference", out, "--frame", 3, "-o", os.path.join(folder, "x.png"), "--size", "16x16", "--samples", "4"]
    run(*picture, "--occluder", f"{mdd}:{mesh}")
    refused(1, "not what", words=[*picture, "--occluder", f"{mdd}:{save(os.path.join(folder, 'o.npz'), positions, faces)}"])
    refused(3, "ball.mdd", "no faces", words=[*words, "--occluder", mdd])
    refused(2, "none.mdd", words=[*words, "--occluder", f"{mesh}:{os.path.join(folder, 'none.mdd')}"])
    refused(2, "ball.obj:", words=[*words, "--occluder", f"{mesh}:"])


def check_steps(folder, cache):
    """Files are numbered 0, 5, 10, ...: each is a frame, and one line of warning says so."""
    positions, faces = sheet(SIDE, FRAMES)
    for f in range(4):
        with open(os.path.join(folder, f"s.{5 * f:04}.obj"), "w") as file:
            file.writelines("v %.9g %.9g %.9g\n" % tuple(p) for p in positions[f])
            file.writelines("f %d %d %d\n" % tuple(t + 1) for t in faces)
    out = os.path.join(folder, "x.vis.h5")
    said = run("visibility", os.path.join(folder, "s.####.obj"), "-o", out, *SMALL, "--cache-fps", "10", "-q").stderr
    assert len(said.splitlines()) == 1 and "warning: " in said and "steps of 5" in said, said
    with h5py.File(out) as f:
        assert np.allclose(f["frames/time"], np.arange(4) / 10) and np.array_equal(f["frames/positions"], positions[:4])
    os.remove(os.path.join(folder, "s.0005.obj"))
    refused(3, "s.0005.obj", "is missing", words=["visibility", os.path.join(folder, "s.0000.obj"), "-o", out])


def check_inputs(folder, cache):
    """Columns join the pose of any clip and rate. A frame without a line is an error that names it."""
    out, table = os.path.join(folder, "x.vis.h5"), os.path.join(folder, "inputs.csv")

    def write(text):
        with open(table, "w") as f:
            f.write(text)

    bake = ["visibility", cache, "-o", out, *SMALL, "--inputs", table]
    write("frame,ball.x,ball.y,ball.z,wind\n" + "".join(f"{i},{i},2,3,{i * i}\n" for i in range(FRAMES)))
    run(*bake, "--two-sided", "--depfile", os.path.join(folder, "x.d"))
    assert table in open(os.path.join(folder, "x.d")).read()
    with h5py.File(out) as f:
        edges = len(f["mesh/edges"])
        assert [name.decode() for name in f["inputs/names"]] == ["ball.x", "ball.y", "ball.z", "wind"]
        expected = np.stack([[i, 2, 3, i * i] for i in range(FRAMES)])
        assert np.array_equal(f["frames/pose"][:, edges:], expected)
    write("time,wind\n0,1\n1,3\n1.9,3\n")
    run(*bake, "--fps", "20", "--blocks", "2")
    with h5py.File(out) as f:
        wind = np.interp(f["frames/time"], [0, 1, 1.9], [1, 3, 3])
        assert np.abs(f["frames/pose"][:, -1] - wind).max() < 1e-6
    rig = os.path.join(BIN, "..", "samples", "bend.glb")
    run("visibility", rig, "-o", out, *SMALL, "--fps", "1", "--clips", "bend", "--inputs", table, code=3)
    write("time,clip,wind\n0,bend,1\n100,bend,3\n")
    run("visibility", rig, "-o", out, *SMALL, "--fps", "1", "--clips", "bend", "--inputs", table)
    with h5py.File(out) as f:
        joints = len(f["skin/joint_names"])
        assert f["frames/pose"].shape[1] == 3 * joints + 1 and f["frames/pose"][0, -1] == 1
    for text, *parts in (
        ("frame,wind\n0,1\n5,2\n", "no line for frame 6 (at 0.6", "clip 'sheet'", "end with frame 5 (line 3)"),
        ("frame,wind\n2,1\n19,2\n", "no line for frame 0 (at 0 s)", "begin with frame 2 (line 2)"),
        ("time,wind\n0,1\n0.5,2\n", "no line for 0.6", "end with 0.5 s (line 3)"),
        ("frame,wind\n0,1\n5,2\n3,4\n", "line 4", "frame 3 is not after frame 5 (line 3)"),
        ("frame,wind\n0,1\n20,2\n", "line 3", "frame 20", "which has 20"),
        ("frame,clip,wind\n0,other,1\n", "line 2", "'other'"),
        ("frame,wind\n0,x\n", "line 2", "'x'"),
    ):
        write(text)
        refused(3, "inputs.csv", *parts, words=bake)
    refused(2, words=[*bake[:-1], os.path.join(folder, "none.csv")])


def check_tangents(folder, cache):
    """Pictures of an anisotropic sheet follow a model's tangents; without a model they have others."""
    at = lambda name: os.path.join(folder, name)
    run("visibility", cache, "-o", at("x.vis.h5"), *SMALL, "--two-sided")
    fit = [os.path.join(BIN, "penumbra-fit"), "visibility", at("x.vis.h5"), "-o", at("x.model.h5"), "-q"]
    subprocess.run([*fit, "--model", "linear", "--parts", "3", "--convention", "A3"], check=True)
    words = ["reference", at("x.vis.h5"), "--frame", 15, "--size", "48x48", "--brdf", "ward-gmd:ax=0.1,ay=0.6"]
    run(*words, "-o", at("plain.png"))
    run(*words, "-o", at("carried.png"), "--tangents", at("x.model.h5"))
    run(*words, "-o", at("again.png"), "--tangents", at("x.model.h5"), "--threads", 1)
    assert digest(at("carried.png")) == digest(at("again.png")) != digest(at("plain.png"))
    other = save(at("other.npz"), *sheet(SIDE + 1, 5))
    run("visibility", other, "-o", at("other.vis.h5"), *SMALL, "--two-sided")
    words = ["reference", at("other.vis.h5"), "--frame", 1, "-o", at("no.png"), "--tangents", at("x.model.h5")]
    refused(3, "x.model.h5: /mesh", words=words)


def check_ground(folder, cache):
    """--ground may be a flag or have a height. The height is written, and moves nothing else."""
    out = os.path.join(folder, "x.vis.h5")
    results = []
    for words, height in (
        ([cache, "--ground"], 0.0),
        ([cache, "--ground=-0.5"], -0.5),
        ([cache, "--ground", "-0.5"], -0.5),
        ([cache, "--ground", "1e-1"], 0.1),
        (["--ground", "--two-sided", cache], 0.0),
        (["--ground", "rest", cache], 0.0),
    ):
        run("visibility", *words, "-o", out, *SMALL)
        with h5py.File(out) as f:
            assert abs(f.attrs["ground_y"] - height) < 1e-6, (words, f.attrs["ground_y"])
            count = SIDE * SIDE
            results.append(f["visibility/coefficients"][:, :count])
    assert all(np.array_equal(results[0], other) for other in results[1:])
    for words in ([cache, "--ground", "nan"], [cache, "--ground", "1m"], ["--ground", cache]):
        refused(1, words=["visibility", *words, "-o", out])
    refused(1, "--ground must be a height", words=["visibility", "--ground", cache, cache, "-o", out])


def main():
    positions, faces = sheet(SIDE, FRAMES)
    ball_there = ball((0, 0.3, 0.5), 0.2)

    def shards(folder, cache):
        occluder = save(os.path.join(folder, "ball.npz"), ball_there[0][None], ball_there[1])
        words = ["--rays", "256", "--order", "3", "--blocks", "2", "--two-sided", "--occluder", occluder]
        check_shards(folder, [cache, *words])

    checks = [check_cache, check_blocks, shards, check_two_sided, check_occluders, check_steps, check_inputs, check_tangents]
    checks += [check_ground]
    for check in checks:
        with tempfile.TemporaryDirectory() as folder:
            check(folder, save(os.path.join(folder, "sheet.npz"), positions, faces))
        print("ok", check.__name__)


main()
