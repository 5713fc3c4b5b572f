"""Characters that stand somewhere: what they hide from the ground and from one another, against counted rays.

usage: test_scene.py BIN
"""
import hashlib
import json
import os
import sys
import tempfile

import h5py
import numpy as np
from PIL import Image

from programs import must, refused, run

BIN = sys.argv[1]
BAKE, FIT, PACK, PLAYER = (os.path.join(BIN, "penumbra-" + name) for name in ("bake", "fit", "pack", "player"))
RIG = os.path.join(BIN, "..", "samples", "capsule_man.glb")
CLIP, FPS, FRAME = "squat", 4, 5
SIDE, HALF = 33, 1.5  # the ground: points a side, metres


def scene(name, **keys):
    with open(name, "w") as f:
        json.dump({"version": 1} | keys, f)
    return name


def write_points(name, positions, normals):
    with open(name, "w") as f:
        f.write("x,y,z,nx,ny,nz\n")
        for p, n in zip(positions, normals):
            f.write(",".join(f"{x:.9g}" for x in (*p, *n)) + "\n")
    return name


def probed(name, points, *more):
    """The columns of probe's CSV by name."""
    must(PLAYER, "probe", name, "--points", points, "-o", "probe.csv", *more)
    with open("probe.csv") as f:
        header, *lines = (line.rstrip("\n").split(",") for line in f)
    return {key: [line[i] for line in lines] for i, key in enumerate(header)}


def grid():
    xs = np.linspace(-HALF, HALF, SIDE)
    x, z = np.meshgrid(xs, xs, indexing="ij")
    corners = np.arange(SIDE * SIDE).reshape(SIDE, SIDE)
    a, b, c, d = (corners[i:SIDE - 1 + i, j:SIDE - 1 + j].ravel() for i, j in ((0, 0), (0, 1), (1, 0), (1, 1)))
    return (np.stack([x.ravel(), np.zeros(SIDE * SIDE), z.ravel()], 1),
            np.concatenate([np.stack([a, b, c], 1), np.stack([b, d, c], 1)]))


def true_ambient(positions, triangles, occluder):
    """E of a mesh whose faces are `triangles`, by the bake, with the posed character as an occluder."""
    faces = positions.astype(np.float32)[None], np.asarray(triangles, np.int32)
    np.savez("mesh.npz", fps=np.float32(30), verts=faces[0], faces=faces[1])
    np.savez("occluder.npz", fps=np.float32(30), verts=occluder[0].astype(np.float32)[None], faces=occluder[1].astype(np.int32))
    must(BAKE, "visibility", "mesh.npz", "--occluder", "occluder.npz", "--rays", 4096, "-o", "mesh.vis.h5", "-q")
    with h5py.File("mesh.vis.h5") as f:
        n, v = f["frames/normals"][0].astype(float), f["visibility/coefficients"][0].astype(float)
    return 2 / np.sqrt(3 * np.pi) * (-n[:, 0] * v[:, 3] - n[:, 1] * v[:, 1] + n[:, 2] * v[:, 2])


def check_ground(body):
    """E of the ground under a held-out pose. Measured: rms .0044, bias -.0018, within 15 cm of a foot .0157."""
    positions, triangles = body
    low = positions[:, 1].min()
    ground, faces = grid()
    ground[:, 1] = low
    truth = true_ambient(ground, faces, body)
    points = write_points("ground.csv", ground, np.tile([0, 1, 0], (len(ground), 1)))
    seconds = FRAME / FPS
    columns = probed(scene("one.json", characters=[{"asset": "man.pnb", "clip": CLIP, "time": seconds}]), points)
    e = np.array(columns["E"], float)
    feet = positions[positions[:, 1] < low + 0.05][:, [0, 2]]
    near = np.sqrt(((ground[:, None, [0, 2]] - feet[None]) ** 2).sum(-1)).min(1) < 0.15
    off = e - truth
    rms, bias, contact = np.sqrt((off**2).mean()), off.mean(), np.sqrt((off[near] ** 2).mean())
    print(f"ground: rms {rms:.4f} bias {bias:+.4f} contact {contact:.4f} ({near.sum()} points), E {truth.min():.2f} to {truth.max():.2f}")
    assert truth.min() < 0.6
    assert rms < 0.008 and abs(bias) < 0.004 and contact < 0.03, (rms, bias, contact)
    # E of a normal that points up is one of the moments.
    assert set(columns["casters"]) <= {"man", ""} and "man" in columns["casters"]
    assert np.allclose(np.array(columns["sh_1"], float) * -2 / np.sqrt(3 * np.pi), e, atol=1e-5)
    # Moved and turned together, nothing changes.
    turned = ground[:, [2, 1, 0]] * [1, 1, -1] + [10, 3, -7]  # 90 degrees about y: +z towards +x
    write_points("turned.csv", turned, np.tile([0, 1, 0], (len(ground), 1)))
    moved = [{"asset": "man.pnb", "clip": CLIP, "time": seconds, "yaw": 90, "position": [10, 3, -7]}]
    again = np.array(probed(scene("moved.json", characters=moved), "turned.csv")["E"], float)
    assert np.abs(again - e).max() < 2e-4, np.abs(again - e).max()
    # --time sets all times.
    later = np.array(probed("one.json", points, "--time", 0)["E"], float)
    assert np.abs(later - e).max() > 0.02


def draw(name, *more):
    must(PLAYER, "render", "--scene", name, "-o", "picture.exr", "--size", "96x96", "--gl", "osmesa", *more)
    with open("picture.exr", "rb") as f:
        return f.read()


def check_pictures():
    man = {"asset": "man.pnb", "clip": CLIP}
    ground = {"height": 0, "size": 4, "resolution": 48}
    both = scene("both.json", characters=[man, {**man, "position": [0.6, 0, 0], "yaw": 40}], ground=ground)
    assert draw(both) == draw(both, "--threads", 1), "threads change the picture"
    assert draw(both, "--channel", "ao") != draw(both)
    assert draw(both, "--time", 1) != draw(both)
    # A prop is a caster as well, and an asset without fields receives.
    draw(scene("mixed.json", characters=[{**man, "asset": "additive.pnb"}], props=[{"asset": "man.pnb", "position": [0.5, 0, 0]}],
               ground=ground, light={"asset": "man.pnb", "rotation": "yaw=30"}, camera="yaw=30,pitch=20"))


def check_periodic():
    """Rays see a periodic ground as the middle one of nine. Measured: rms 1.6 of 255, and 6.2 without its
    neighbours."""
    chance = np.random.default_rng(3)
    waves = np.fft.fftfreq(40)[:, None] ** 2 + np.fft.fftfreq(40)[None] ** 2
    waves[0, 0] = np.inf
    tile = np.fft.ifft2(np.fft.fft2(chance.standard_normal((40, 40))) / waves**0.8).real
    tile = np.ascontiguousarray((0.25 * tile / tile.std()).astype(np.float32))
    np.save("tile.npy", tile)
    np.save("nine.npy", np.tile(tile, (3, 3)))

    def traced(name, file, border):
        ground = {"heights": {"file": file, "cell": 0.1, "border": border}}
        scene(name, characters=[{"asset": "man.pnb", "on_ground": True}], ground=ground,
              camera="yaw=25,pitch=35,distance=7")
        must(BAKE, "reference", "--scene", name, "--samples", 128, "--size", "96x72", "--exposure", 1, "-o", "traced.png", "-q")
        return np.asarray(Image.open("traced.png").convert("RGBA"), float)

    periodic, nine, alone = traced("p.json", "tile.npy", "periodic"), traced("n.json", "nine.npy", "clamped"), \
        traced("c.json", "tile.npy", "clamped")
    seen = periodic[..., 3] == 255
    off, off_alone = (np.sqrt(((picture - nine)[seen][:, :3] ** 2).mean()) for picture in (periodic, alone))
    print(f"periodic ground: rms {off:.1f} of 255 from the middle one of nine; one alone {off_alone:.1f}")
    assert seen.mean() > 0.2
    assert off < 0.5 * off_alone and off < 3, (off, off_alone)
    wide = {"heights": {"analytic": "waves", "rows": 2, "columns": 8192, "border": "periodic"}}
    refused(5, "/ground/heights", BAKE, "reference", "--scene",
            scene("w.json", characters=[{"asset": "man.pnb"}], ground=wide), "-o", "traced.png")


def check_wide_ground():
    """A body on a ground of 500 m or 40 km is traced as on one of 8 m. Measured with a real character: 0.02 of 255 at
    most, against 9 and 26 where the bias grew with the ground."""
    def traced(cell):
        ground = {"heights": {"analytic": "waves:height=0", "rows": 101, "columns": 101, "cell": cell}}
        name = scene("wide.json", ground=ground, camera="yaw=40,pitch=60,fov=20,distance=7,target=0/0.9/0",
                     characters=[{"asset": "man.pnb", "clip": CLIP, "time": 1, "on_ground": True}])
        must(BAKE, "reference", "--scene", name, "--channel", "ao", "--samples", 64, "--size", "64x96", "-o", "wide.png", "-q")
        return np.asarray(Image.open("wide.png").convert("RGBA"), float)

    small = traced(0.08)
    assert (small[..., 3] == 255).all() and (small[..., 0] < 200).mean() > 0.02
    for cell in (5, 400):
        off = np.sqrt(((traced(cell) - small)[..., :3] ** 2).mean())
        print(f"ground of {100 * cell} m: rms {off:.2f} of 255 from one of 8 m")
        assert off < 2, off


def check_walk():
    """A character on the ground stands there in both programs, and in a probe of what it casts."""
    name = scene("walk.json", camera="yaw=30,pitch=25,distance=6,target=0/0.9/0",
                 ground={"heights": {"analytic": "waves:height=0.5,length=2", "rows": 65, "columns": 65, "cell": 0.0625}},
                 characters=[{"asset": "man.pnb", "clip": CLIP, "on_ground": True}])
    alone = scene("alone.json", camera="yaw=30,pitch=25,distance=6,target=0/0.9/0", characters=[{"asset": "man.pnb"}])
    for seconds in (0, 1):
        look = ["--time", seconds, "--size", "96x96"]
        must(BAKE, "reference", "--scene", name, *look, "--channel", "normals", "--samples", 4, "-o", "traced.png", "-q")
        must(PLAYER, "render", "--scene", name, *look, "--gl", "osmesa", "--channel", "ao", "-o", "drawn.png", "-q")
        a, b = (np.asarray(Image.open(p).convert("RGBA"), float)[..., 3] for p in ("traced.png", "drawn.png"))
        assert (a > 0).mean() > 0.1
        assert (np.abs(a - b) > 128).mean() < 0.004, (np.abs(a - b) > 128).mean()


def check_several():
    """Several assets stand in a row on a ground that lies under them, as a scene that says so."""
    look = ["--size", "96x96", "--gl", "osmesa", "--exposure", 1]

    def row(name, *more):
        must(PLAYER, "render", "man.pnb", "additive.pnb", "-o", name, *look, *more)
        return pixels(name)

    with h5py.File("m.h5") as f:
        rest = f["mesh/rest_positions"][:].astype(float)
    low, high = rest.min(0), rest.max(0)
    half = (high[0] - low[0]) * 2 / 3
    both = high - low + [2 * half, 0, 0]
    ground = {"height": low[1], "centre": list((low + high) / 2), "size": 4 * np.linalg.norm(both), "resolution": 145}
    named = scene("row.json", characters=[{"asset": "man.pnb", "position": [-half, 0, 0]}, {"asset": "additive.pnb", "position": [half, 0, 0]}],
                  ground=ground)
    must(PLAYER, "render", "--scene", named, "-o", "named.png", *look)
    ours = row("row.png")
    assert np.abs(ours - pixels("named.png")).mean() < 1e-3, "the places are others"
    for more in (("--time", 1), ("--light-rotation", "yaw=90"), ("--camera", "yaw=60")):
        assert np.abs(row("changed.png", *more) - ours).max() > 0.05, more
    assert "2 characters and props, 1 of which cast" in must(PLAYER, "render", "man.pnb", "additive.pnb", "-o", "row.png", *look)
    for words in (("--clip", CLIP), ("--frame", 1), ("--slot", "a=clay"), ("--csv", "x.csv"), ("--scene", named)):
        result = run(PLAYER, "render", "man.pnb", "man.pnb", "-o", "x.png", *words)
        assert result.returncode == 1 and result.stderr.count("\n") == 1, (words, result)
    for code, says, words in ((3, "lights.pnb: has no model", ("man.pnb", "lights.pnb")), (2, "nobody.pnb", ("man.pnb", "nobody.pnb")),
                              (3, 'has no "gold"', ("man.pnb", "man.pnb", "--brdf", "gold")),
                              (1, "--light-rotation", ("man.pnb", "man.pnb", "--light-rotation", "far"))):
        result = run(PLAYER, "render", *words, "-o", "x.png", "--gl", "osmesa")
        assert result.returncode == code and says in result.stderr and result.stderr.count("\n") == 1, (words, result)
    assert not os.path.exists("x.png")


SUN = np.array([-0.6, 1, 0.5]) / np.linalg.norm([-0.6, 1, 0.5])


def sees_sun(points, body):
    """Which points a ray towards the sun leaves (Moeller and Trumbore's test, for one direction)."""
    a, b, c = (body[0][body[1][:, i]] for i in range(3))
    across = np.cross(SUN, c - a)
    scale = 1 / (across * (b - a)).sum(-1)
    free = []
    for p in points:
        u = (across * (p - a)).sum(-1) * scale
        turned = np.cross(p - a, b - a)
        v, t = turned @ SUN * scale, (turned * (c - a)).sum(-1) * scale
        free.append(not np.any((u >= 0) & (v >= 0) & (u + v <= 1) & (t > 1e-4)))
    return np.array(free)


def make_suns():
    """sunny.pnb has a sky with a point sun that is split off, mixed.pnb the same light that is not."""
    sun = f"sun:direction={'/'.join(map(str, SUN))},irradiance=4"
    for name, more in (("sunny", ["--factor"]), ("mixed", [])):
        must(FIT, "light", "--analytic", "uniform", "--analytic", sun, *more, "--name", "l", "-o", name + ".light.h5", "-q")
        must(PACK, "asset", "--light", name + ".light.h5", "-o", name + ".pnb", "-q")


def check_suns(body):
    """The sun's share of irradiance is past the map, and V_c shadows the rest alone. Measured: 0.3% of the points
    differ from counted rays by more than 0.1, and 4.9% are in shadow."""
    make_suns()
    low = body[0][:, 1].min()
    ground = grid()[0]
    ground[:, 1] = low
    points = write_points("sunny.csv", ground, np.tile([0, 1, 0], (len(ground), 1)))
    man = {"asset": "man.pnb", "clip": CLIP, "time": FRAME / FPS}
    sunny = scene("sunny.json", characters=[man], light={"asset": "sunny.pnb"})
    columns = probed(sunny, points)
    seen = np.array(columns["sun_visibility_1"], float)
    rays = sees_sun(ground, body)
    off = np.abs(seen - rays) > 0.1
    print(f"sun: {off.mean():.2%} of the points differ from rays, {(~rays).mean():.1%} are in shadow")
    assert (~rays).mean() > 0.03 and off.mean() < 0.01, (off.mean(), rays.mean())
    red = np.array(columns["irradiance_r"], float)
    assert np.allclose(red - 4 * SUN[1] * seen, np.pi * np.array(columns["E"], float), atol=1e-3)
    with open("probe.csv", "rb") as f:
        on = f.read()
    told = must(BAKE, "info", "sunny.pnb").split()
    at = told.index("irradiance")
    assert np.allclose([float(x.strip(",")) for x in told[at + 1:at + 4]], 4, atol=1e-3), told
    # Where nobody stands, the ground sends the light of the open sky to what faces it.
    down = write_points("down.csv", [[0, low + 1, 0]], [[0, -1, 0]])
    lonely = scene("lonely.json", characters=[], light={"asset": "sunny.pnb"}, ground={"height": float(low), "albedo": [0.5] * 3})
    assert float(probed(lonely, down)["received_r"][0]) > 0.1
    mixed = scene("mixed.json", characters=[man], light={"asset": "mixed.pnb"})
    outputs = []
    for name, *more in ((sunny, "--suns", "off"), (mixed,), (mixed, "--suns", "auto"), (sunny, "--cast", "folded"), (mixed, "--cast", "folded")):
        probed(name, points, *more)
        with open("probe.csv", "rb") as f:
            outputs.append(f.read())
    assert outputs[0] == outputs[1] == outputs[2] != on and outputs[3] == outputs[4]
    assert b"sun_visibility" not in outputs[0]
    for code, text, words in ((1, "the light \"l\" has none", (mixed, "--suns", "on")),
                              (1, "--suns", (sunny, "--suns", "on", "--cast", "folded")),
                              (1, "--suns", (sunny, "--suns", "maybe")), (1, "--sun-map", (sunny, "--sun-map", 4))):
        result = run(PLAYER, "probe", words[0], "--points", points, "-o", "no.csv", *words[1:])
        assert result.returncode == code and text in result.stderr, result
    assert not os.path.exists("no.csv")
    refused(1, "--suns", PLAYER, "render", "--scene", sunny, "--suns", "on", "--cast", "folded", "-o", "no.png",
            "--gl", "osmesa")


def check_poses():
    """A pose of a file is the pose of the clip, in both programs, and need not be of any bake."""
    must(BAKE, "poses", RIG, "--clips", CLIP, "--fps", FPS, "--choose", 3, "--sample", 2, "-o", "man.poses.json", "-q")
    with open("man.poses.json") as f:
        poses = json.load(f)
    assert [pose["clip"] for pose in poses["poses"]] == 3 * [CLIP] + 2 * ["sampled"], poses["poses"]
    ground = {"size": 3, "resolution": 32}
    clip = scene("clip.json", ground=ground, characters=[{"asset": "man.pnb", "clip": CLIP, "time": poses["poses"][1]["time"]}])
    posed = lambda frame: {"asset": "man.pnb", "pose": {"file": "man.poses.json", "frame": frame}}
    same = scene("posed.json", ground=ground, characters=[posed(1)])
    new = scene("new.json", ground=ground, characters=[posed(4)])
    assert draw(same) == draw(clip), "a pose of a file is another one"
    assert draw(same, "--time", 0) == draw(same), "--time moves a pose"
    assert draw(new) != draw(clip)
    for name in (clip, same, new):
        must(BAKE, "reference", "--scene", name, "--size", "48x48", "--samples", 16, "-o", name + ".exr", "-q")
    truths = [open(name + ".exr", "rb").read() for name in (clip, same, new)]
    assert truths[0] == truths[1] != truths[2]
    must(PLAYER, "bench", "--scene", same, "--runs", 1, "--size", "64x64", "--gl", "osmesa", "-q")
    poses["joints"][3] = "tail"
    with open("other.poses.json", "w") as f:
        json.dump(poses, f)
    other = scene("other.json", characters=[{**posed(0), "pose": {"file": "other.poses.json"}}])
    missing = scene("missing.json", characters=[posed(5)])
    sheet = scene("posed_sheet.json", characters=[{**posed(0), "asset": "arch.pnb"}])
    for name, says in ((other, 'other.poses.json is of another rig: its joint 3 is "tail"'), (missing, "none of number 5"),
                       (sheet, "arch.pnb is a cloth")):
        for words in ((PLAYER, "render", "--gl", "osmesa"), (BAKE, "reference")):
            result = run(*words, "--scene", name, "-o", "no.png")
            assert result.returncode == 3 and says in result.stderr and result.stderr.count("\n") == 1, (name, result)
    assert not os.path.exists("no.png")


def check_inputs():
    """Depfile and report list every file that a scene names, and none of them is written over."""
    poses = {"file": "man.poses.json"}
    name = scene("inputs.json", characters=[{"asset": "man.pnb", "pose": poses}, {"asset": "man.pnb"}], props=[{"asset": "additive.pnb"}],
                 light={"asset": "lights.pnb"})
    named = ["man.pnb", "man.poses.json", "additive.pnb", "lights.pnb"]
    points = write_points("points.csv", [[0, 0, 0]], [[0, 1, 0]])
    small = ["--size", "16x16"]
    for words, read in (([PLAYER, "render", "--scene", name, *small, "--gl", "osmesa"], [name]),
                        ([PLAYER, "probe", name, "--points", points], [name, points]),
                        ([BAKE, "reference", "--scene", name, *small, "--samples", 4], [name])):
        out = "inputs.csv" if "probe" in words else "inputs.png"
        must(*words, "-o", out, "--report", "inputs.report", "--depfile", "inputs.d", "-q")
        with open("inputs.report") as f:
            report = json.load(f)
        assert report["inputs"] == read + named, report["inputs"]
        for file in read + named:
            with open(file, "rb") as f:
                assert report["sha256"][file] == hashlib.sha256(f.read()).hexdigest(), file
        with open("inputs.d") as f:
            assert f.read().replace(" \\\n ", "").split() == [out + ":", *read, *named]
    for key, there in (("characters", {"asset": "nowhere.pnb"}), ("light", {"asset": "nowhere.pnb"})):
        nowhere = scene("nowhere.json", **{"characters": [{"asset": "man.pnb"}], key: [there] if key != "light" else there})
        place = "/characters/0/asset" if key == "characters" else "/light/asset"
        for words in ([PLAYER, "render", "--scene", nowhere, "-o", "no.png"], [PLAYER, "bench", "--scene", nowhere],
                      [PLAYER, "probe", nowhere, "--points", points, "-o", "no.csv"],
                      [BAKE, "reference", "--scene", nowhere, "-o", "no.png"]):
            result = run(*words)
            assert result.returncode == 2 and f"{place}: nowhere.pnb: cannot read" in result.stderr, result
    result = run(PLAYER, "probe", name, "--points", points, "-o", "man.poses.json")
    assert result.returncode == 1 and "man.poses.json: is input and output" in result.stderr, result
    must(PLAYER, "bench", "--scene", name, "--runs", 1, *small, "--gl", "osmesa", "--report", "inputs.report", "-q")
    with open("inputs.report") as f:
        assert json.load(f)["inputs"] == [name, *named]


def check_bench_of_suns(words):
    """Suns have rows of their own, beside the same scene with all light as SH. An asset alone has no maps, and says
    so."""
    name = scene("bench_suns.json", characters=[{"asset": "man.pnb", "clip": CLIP}], light={"asset": "sunny.pnb"})
    said = must(PLAYER, "bench", "--scene", name, *words, "--report", "suns.report.json")
    with open("suns.report.json") as f:
        cost = json.load(f)["figures"]["scene"]["suns"]
    assert "suns, ms" in said and cost["count"] == 1 and cost["maps_ms"] > 0, (said, cost)
    for part in ("shade", "draw", "frame"):
        with_ms, without_ms = cost[part]["with_ms"], cost[part]["without_ms"]
        assert min(with_ms, without_ms) > 0 and np.isclose(cost[part]["ratio"] * without_ms, with_ms), cost
    must(PACK, "asset", "a.h5", "--brdf", "clay.brdf.h5", "--light", "sunny.light.h5", "-o", "sunny_man.pnb", "-q")
    alone = "1, timed as SH like all of the light; bench --scene times suns"
    assert alone in must(PLAYER, "bench", "sunny_man.pnb", *words), "nothing is said of the suns"
    assert alone not in must(PLAYER, "bench", "additive.pnb", *words)


def check_bench():
    """Measures the cost of a scene: the scene itself, then copies of its first character on a ground that grows with
    them."""
    name = scene("bench.json", characters=[{"asset": "man.pnb", "clip": CLIP}], props=[{"asset": "additive.pnb"}],
                 ground={"size": 2, "resolution": 33})
    words = ("--scene", name, "--runs", 2, "--size", "64x64", "--gl", "osmesa", "--threads", 2)
    said = must(PLAYER, "bench", *words, "--characters", "4,1", "--report", "bench.report.json")
    assert "pose of one caster" in said and "ns a pair" in said and "Hz" in said, said
    with open("bench.report.json") as f:
        figures = json.load(f)["figures"]
    whole, one, four = figures["scene"], *figures["copies"]
    assert (whole["members"], whole["casters"], one["members"], four["casters"]) == (2, 1, 1, 4), figures
    vertices = one["members_cast"]["evaluated"]
    # Nobody is past himself, and who has no fields is past everyone who has some.
    assert [cost["members_cast"]["pairs"] for cost in (whole, one, four)] == [vertices, 0, 4 * 3 * vertices], figures
    assert one["members_cast"]["pair_ns"] is None and four["members_cast"]["pair_ns"] > 0
    assert [cost["ground_vertices"] for cost in (whole, one, four)] == [33**2, 33**2, 66**2], figures
    for cost in (whole, one, four):
        assert 0 < cost["ground"]["evaluated"] < cost["ground_vertices"]
        assert cost["ground"]["pairs"] == cost["ground"]["evaluated"] * cost["casters"]
        parts = [cost[key] for key in ("pose_ms", "evaluate_ms", "shade_ms", "draw_ms", "pose_caster_ms")]
        assert min(parts) > 0 and cost["frame_ms"] > 0 and np.isclose(cost["hz"] * cost["frame_ms"], 1000), cost
    assert all(cost["suns"] is None for cost in (whole, one, four)) and "suns, ms" not in said
    assert "2 characters and props" in must(PLAYER, "bench", *words, "--dry-run")
    check_bench_of_suns(words[2:])
    bare = scene("bare.json", props=[{"asset": "man.pnb"}], characters=[{"asset": "additive.pnb"}])
    must(PLAYER, "bench", "--scene", bare, *words[2:], "-q")
    for more in (("--brdf", "clay"), ("--light", "sky"), ("man.pnb",)):
        assert run(PLAYER, "bench", *words, *more).returncode == 1, more
    assert run(PLAYER, "bench").returncode == 1


def pixels(name):
    return np.asarray(Image.open(name).convert("RGBA")).astype(float) / 255


def check_truth():
    """Pictures beside brute force: everyone at the same place, in the same light, with the same shadows. The clip is
    held out, and capsules that meet are dark at whole vertices: measured .042 and .029."""
    man = {"asset": "man.pnb", "clip": CLIP, "time": 1}
    name = scene("truth.json", characters=[man, {**man, "position": [0.7, 0, 0.2], "yaw": 200}], ground={"size": 3},
                 light={"rotation": "yaw=70"}, camera="yaw=25,pitch=25,fov=40")
    look = ["--scene", name, "--size", "160x120"]
    for channel, bound in (("ao", 0.05), ("shaded", 0.05)):
        must(PLAYER, "render", *look, "--gl", "osmesa", "--aa", 4, "--channel", channel, "-o", "ours.png")
        must(BAKE, "reference", *look, "--aa", 4, "--samples", 512, "--channel", channel, "-o", "truth.png")
        ours, truth = pixels("ours.png"), pixels("truth.png")
        assert (np.abs(ours[..., 3] - truth[..., 3]) > 0.3).mean() < 0.002, "outlines differ"
        inside = (ours[..., 3] == 1) & (truth[..., 3] == 1)
        rms = np.sqrt(((ours - truth)[inside][:, :3] ** 2).mean())
        print(f"{channel}: rms {rms:.4f} of a picture whose values have a deviation of {truth[inside][:, :3].std():.3f}")
        assert inside.mean() > 0.2 and truth[inside][:, :3].std() > 0.04 and rms < bound, (channel, rms)
    # Another time is another picture, in both programs.
    must(BAKE, "reference", *look, "--samples", 64, "--time", 0, "-o", "later.png")
    assert np.abs(pixels("later.png") - truth).max() > 0.2
    for words in (("--frame", 1), ("--light-rotation", "yaw=3"), ("rig.vis.h5",)):
        assert run(BAKE, "reference", *look, "-o", "no.png", *words).returncode == 1, words
    assert run(BAKE, "reference", "-o", "no.png").returncode == 1
    assert run(BAKE, "reference", "rig.vis.h5", "-o", "no.png").returncode == 1
    assert not os.path.exists("no.png")


def check_sheet():
    """A two-sided sheet, a pipe with a slit, whose inside is dark: each side shows its own numbers, in both programs.
    Seen from the side, both are in the picture. Measured: rms .0068; .197 where either side may be drawn."""
    columns, rows, frames = 25, 13, 6
    angle, along = np.meshgrid(np.linspace(-0.9, np.pi + 0.9, columns), np.linspace(-0.8, 0.8, rows), indexing="ij")
    radius = 0.5 + 0.02 * np.arange(frames)[:, None, None]
    arch = np.stack([radius * np.cos(angle), radius * np.sin(angle), along + 0 * radius], -1)
    corner = (np.arange(columns - 1)[:, None] * rows + np.arange(rows - 1)).ravel()
    faces = np.concatenate([np.stack([corner, corner + 1, corner + rows], 1),
                            np.stack([corner + 1, corner + rows + 1, corner + rows], 1)])
    np.savez("arch.npz", verts=arch.reshape(frames, -1, 3).astype("f4"), faces=faces.astype("i4"), fps=np.float32(10))
    must(BAKE, "visibility", "arch.npz", "--two-sided", "--rays", 512, "-o", "arch.vis.h5", "-q")
    must(FIT, "visibility", "arch.vis.h5", "--model", "linear", "--parts", 4, "-o", "arch.h5", "-q")
    must(PACK, "asset", "arch.h5", "--brdf", "clay.brdf.h5", "--light", "sky.light.h5", "-o", "arch.pnb", "-q")
    name = scene("arch.json", characters=[{"asset": "arch.pnb", "time": 0.3}], camera="yaw=25,pitch=20")
    look = ["--scene", name, "--size", "120x90", "--aa", 4, "--channel", "ao"]
    must(PLAYER, "render", *look, "--gl", "osmesa", "-o", "ours.png")
    must(BAKE, "reference", *look, "--samples", 1024, "-o", "truth.png")
    ours, truth = pixels("ours.png"), pixels("truth.png")
    inside = (ours[..., 3] == 1) & (truth[..., 3] == 1)
    rms = np.sqrt(((ours - truth)[inside][:, :3] ** 2).mean())
    print(f"sheet: rms {rms:.4f}, values from {truth[inside][:, 0].min():.2f} to {truth[inside][:, 0].max():.2f}")
    assert inside.mean() > 0.1 and (np.abs(ours[..., 3] - truth[..., 3]) > 0.3).mean() < 0.004
    assert truth[inside][:, 0].max() - truth[inside][:, 0].min() > 0.35 and rms < 0.015, rms


def check_rubbish():
    def fails(code, text, *words):
        result = run(*words)
        assert result.returncode == code and text in result.stderr and result.stderr.count("\n") == 1, (words, result)

    points = write_points("points.csv", [[0, 0, 0]], [[0, 1, 0]])
    man = {"asset": "man.pnb"}

    def probe_fails(code, text, **keys):
        fails(code, text, PLAYER, "probe", scene("bad.json", **keys), "--points", points, "-o", "bad.csv")

    probe_fails(2, "nobody.pnb", characters=[{"asset": "nobody.pnb"}])
    probe_fails(3, 'bad.json: /characters/0/clip: the asset has no "fly"', characters=[{**man, "clip": "fly"}])
    probe_fails(3, 'bad.json: /characters/0/material: the asset has no "gold"', characters=[{**man, "material": "gold"}])
    probe_fails(3, 'bad.json: /light/name: the asset has no "moon"', characters=[man], light={"name": "moon"})
    probe_fails(3, "bad.json: /light/rotation", characters=[man], light={"rotation": "yaw=far"})
    probe_fails(3, "bad.json: /characters/0/asset", characters=[{"asset": "lights.pnb"}])
    probe_fails(3, "bad.json", characters=[{"asset": "bad.json"}])
    probe_fails(3, "bad.json: /moon: unknown key", characters=[man], moon=1)
    good = scene("good.json", characters=[man])
    for text, rows in (("header", "x,y,z\n0,0,0\n"), ("line 2", "x,y,z,nx,ny,nz\n0,0,0,0,0,0\n"),
                       ("line 3", "x,y,z,nx,ny,nz\n0,0,0,0,1,0\n0,0,nan,0,1,0\n"), ("line 2", "x,y,z,nx,ny,nz\n1,2\n")):
        with open("rubbish.csv", "w") as f:
            f.write(rows)
        result = run(PLAYER, "probe", good, "--points", "rubbish.csv", "-o", "bad.csv")
        assert result.returncode == 3 and "rubbish.csv" in result.stderr, (text, result)
    for words in (("--frame", 1), ("--brdf", "clay"), ("--csv", "x.csv"), ("--channel", "clusters"), ("man.pnb",)):
        assert run(PLAYER, "render", "--scene", good, "-o", "x.png", *words).returncode == 1, words
    assert run(PLAYER, "render", "man.pnb", "--time", 1, "-o", "x.png").returncode == 1
    assert run(PLAYER, "render", "-o", "x.png").returncode == 1
    assert not os.path.exists("bad.csv") and not os.path.exists("x.png")


def main():
    os.chdir(tempfile.mkdtemp())
    must(BAKE, "fields", RIG, "-o", "f.h5", "-q")
    must(BAKE, "visibility", RIG, "--fps", FPS, "--rays", 128, "--local", "-o", "rig.vis.h5", "-q")
    must(FIT, "visibility", "rig.vis.h5", "--fields", "f.h5", "--holdout", CLIP, "-o", "m.h5", "-q")
    must(FIT, "visibility", "rig.vis.h5", "--convention", "A4", "-o", "a.h5", "-q")
    must(FIT, "brdf", "--analytic", "lambert:color=0.7/0.7/0.7", "-o", "clay.brdf.h5", "-q")
    must(FIT, "light", "--analytic", "sky:elevation=30", "-o", "sky.light.h5", "-q")
    for model, asset in (("m.h5", "man.pnb"), ("a.h5", "additive.pnb"), (None, "lights.pnb")):
        must(PACK, "asset", *([model] if model else []), "--brdf", "clay.brdf.h5", "--light", "sky.light.h5", "-o", asset, "-q")
    with h5py.File("rig.vis.h5") as f:
        names = [name.decode() for name in f["clips/names"][:]]
        frame = np.flatnonzero(f["frames/clip"][:] == names.index(CLIP))[FRAME]
        body = f["frames/positions"][frame].astype(float), f["mesh/triangles"][:]
    check_ground(body)
    check_suns(body)
    check_pictures()
    check_periodic()
    check_wide_ground()
    check_walk()
    check_several()
    check_bench()
    check_truth()
    check_sheet()
    check_poses()
    check_inputs()
    check_rubbish()


main()
