"""Characters in photographs: pictures, numbered pictures and .y4m, what stays as it was, and what is refused.

usage: test_composite.py BIN
"""
import json
import os
import subprocess
import sys
import tempfile

import numpy as np
from PIL import Image

from programs import must, refused
from view_window import Display, View, wait_until

BIN = os.path.abspath(sys.argv[1])
BAKE, FIT, PACK, PLAYER = (os.path.join(BIN, "penumbra-" + name) for name in ("bake", "fit", "pack", "player"))
RIG = os.path.join(BIN, "..", "samples", "capsule_man.glb")
WIDTH, HEIGHT = 160, 120
TURN = [[1, 0, 0], [0, -0.4472136, -0.8944272], [0, 0.8944272, -0.4472136]]
CAMERA = {"f": 150, "size": [WIDTH, HEIGHT]}


def make_asset():
    must(BAKE, "visibility", RIG, "-o", "m.vis.h5", "--clips", "squat", "--fps", 4, "--rays", 64, "--local", "-q")
    must(BAKE, "fields", RIG, "-o", "m.fields.h5", "-q")
    must(FIT, "visibility", "m.vis.h5", "--model", "composed", "--fields", "m.fields.h5", "-o", "m.model.h5", "-q")
    must(FIT, "brdf", "--analytic", "lambert:color=0.6/0.3/0.1", "-o", "m.brdf.h5", "-q")
    must(FIT, "light", "--analytic", "uniform", "--analytic", "sun:direction=0.5/0.8/0.3,irradiance=4", "--factor", "-o",
         "m.light.h5", "-q")
    must(PACK, "asset", "m.model.h5", "--brdf", "m.brdf.h5", "--light", "m.light.h5", "-o", "m.pnb", "-q")


def scene(name, **keys):
    whole = {"version": 1, "characters": [{"asset": "m.pnb", "on_ground": True}], "ground": {"catcher": True},
             "light": {"asset": "m.pnb"}, "camera": CAMERA | {"R": TURN, "t": [0, -0.6, 5]}} | keys
    with open(name, "w") as f:
        json.dump(whole, f)
    return name


def write_plates(count):
    """Numbered pictures of noise around one gray, which is dark enough that light can be added."""
    random = np.random.default_rng(1)
    for i in range(count):
        picture = random.integers(90, 110, (HEIGHT, WIDTH, 3)).astype(np.uint8)
        Image.fromarray(picture).save(f"plate_{i + 3:02d}.png")


def read(name):
    return np.asarray(Image.open(name).convert("RGB")).astype(int)


def composite(*words):
    return must(PLAYER, "composite", *words)


def check_pictures():
    scene("s.json")
    composite("s.json", "--plate", "plate_03.png", "-o", "one.png", "--exposure", 0.2)
    before, after = read("plate_03.png"), read("one.png")
    changed = (before != after).any(-1)
    assert 0.05 < changed.mean() < 0.9, changed.mean()
    assert (before == after)[:10, :30].all()  # far away
    composite("s.json", "--plate", "plate_03.png", "-o", "none.png", "--no-shadow")
    covered = (read("none.png") != before).any(-1)
    shadow = changed & ~covered
    assert shadow.sum() > 200 and (after - before)[shadow].mean() < -2, (shadow.sum(), (after - before)[shadow].mean())
    composite("s.json", "--plate", "plate_03.png", "-o", "again.png", "--exposure", 0.2, "--threads", 3)
    assert (read("again.png") == after).all()
    # The lens bends the character and its shadow.
    scene("lens.json", camera=CAMERA | {"R": TURN, "t": [0, -0.6, 5], "k1": -0.3})
    composite("lens.json", "--plate", "plate_03.png", "-o", "lens.png", "--exposure", 0.2)
    assert (read("lens.png") != after).any()
    # Nobody: the photograph as it is.
    scene("nobody.json", characters=[])
    composite("nobody.json", "--plate", "plate_03.png", "-o", "nobody.png")
    assert (read("nobody.png") == before).all()


def check_numbered():
    frames = [{"file": "", "R": TURN, "t": [0.05 * i, -0.6, 5]} for i in range(3)]
    with open("track.json", "w") as f:
        json.dump({"format": "penumbra.camera_poses", "camera": CAMERA, "frames": frames}, f)
    scene("moving.json", camera={"poses": "track.json"})
    words = ["moving.json", "--plate", "plate_%02d.png", "-o", "out_%03d.png", "--fps", 4]
    composite(*words)
    whole = [read(f"out_{i:03d}.png") for i in (3, 4, 5)]
    assert (whole[0] != whole[1]).any()
    os.remove("out_004.png")
    with open("out_005.png", "r+b") as f:
        f.truncate(100)
    composite(*words, "--resume", "--report", "report.json")
    figures = json.load(open("report.json"))["figures"]
    assert figures["pictures"] == 2 and figures["skipped"] == 1, figures
    assert all((read(f"out_{i:03d}.png") == w).all() for i, w in zip((3, 4, 5), whole))
    write_plates(4)
    refused(3, "has 3 poses for 4 pictures", PLAYER, "composite", *words)
    del frames[1]["R"], frames[1]["t"]
    with open("gap.json", "w") as f:
        json.dump({"format": "penumbra.camera_poses", "camera": CAMERA, "frames": frames}, f)
    scene("gap_scene.json", camera={"poses": "gap.json", "frame": 1})
    refused(3, "frame 1 has no pose", PLAYER, "composite", "gap_scene.json", "--plate", "plate_03.png", "-o", "x.png")
    assert not os.path.exists("x.png")
    check_names(whole)


def check_names(whole):
    """Photographs and poses belong together by their names, and gaps are told before the first picture is written."""
    frames = [{"file": f"film/p_{i:02d}.jpg", "R": TURN, "t": [0.05 * (i - 3), -0.6, 5]} for i in range(2, 6)]

    def track(name):
        with open(f"{name}.json", "w") as f:
            json.dump({"format": "penumbra.camera_poses", "camera": CAMERA, "frames": frames}, f)
        return scene(f"{name}_scene.json", camera={"poses": f"{name}.json", "frame": 1})

    os.makedirs("part", exist_ok=True)
    for i in (4, 5):
        os.replace(f"plate_{i:02d}.png", f"part/plate_{i:02d}.png")
    named = track("named")
    words = ["--plate", "part/plate_%02d.png", "-o", "part/out_%03d.png", "--fps", 4]
    composite(named, *words)
    assert all((read(f"part/out_{i:03d}.png") == whole[i - 3]).all() for i in (4, 5))
    refused(3, "plate_06.png", PLAYER, "composite", named, "--plate",
            "plate_%02d.png", "-o", "none_%d.png")
    del frames[3]["R"], frames[3]["t"]  # plate 5, the last one
    gap = track("last")
    for name in ("part/out_004.png", "part/out_005.png"):
        os.remove(name)
    refused(3, "--without-pose keep", PLAYER, "composite", gap, *words)
    assert not os.path.exists("part/out_004.png")
    said = subprocess.run([PLAYER, "composite", gap, *map(str, words), "--without-pose", "keep"], check=True,
                          capture_output=True, text=True).stderr
    assert "1 photographs have no pose" in said, said
    assert (read("part/out_004.png") == whole[1]).all()
    assert (read("part/out_005.png") == read("part/plate_05.png")).all()


def check_video():
    header = b"YUV4MPEG2 W%d H%d F30:1 Ip A1:1 C420jpeg\n" % (WIDTH, HEIGHT)
    gray = b"FRAME\n" + bytes([100]) * (WIDTH * HEIGHT) + bytes([128]) * (WIDTH * HEIGHT // 2)
    result = subprocess.run([PLAYER, "composite", "s.json", "--plate", "-", "-o", "-"], input=header + 2 * gray,
                            stdout=subprocess.PIPE, check=True)
    assert result.stdout.startswith(header) and len(result.stdout) == len(header) + 2 * len(gray), len(result.stdout)
    first = np.frombuffer(result.stdout, np.uint8, WIDTH * HEIGHT, len(header) + 6).reshape(HEIGHT, WIDTH)
    assert (first[:10, :30] == 100).all() and (first != 100).any()
    # A stream may have more pictures than there are poses. What is said goes beside the stream.
    longer = subprocess.run([PLAYER, "composite", "moving.json", "--plate", "-", "-o", "-"], input=header + 5 * gray,
                            capture_output=True, check=True)
    assert len(longer.stdout) == len(header) + 3 * len(gray) and b"ends at the last pose" in longer.stderr, longer.stderr
    dry = subprocess.run([PLAYER, "composite", "s.json", "--plate", "plate_03.png", "-o", "-", "--dry-run"],
                         capture_output=True, check=True)
    assert dry.stdout == b"" and b"would compose" in dry.stderr, dry
    with open("film.y4m", "wb") as f:
        f.write(header + gray + gray[:500])
    refused(3, "picture 1 is cut short", PLAYER, "composite", "s.json", "--plate", "film.y4m", "-o", "film_out.y4m")
    assert not os.path.exists("film_out.y4m")


def check_refusals():
    def no(code, part, *words):
        refused(code, part, PLAYER, "composite", *words)
        assert not os.path.exists("x.png")

    Image.fromarray(np.zeros((50, 60, 3), np.uint8)).save("small.png")
    no(3, "has 60 x 50 pixels, and the scene's camera has 160 x 120", "s.json", "--plate", "small.png", "-o", "x.png")
    no(2, "absent.png", "s.json", "--plate", "absent.png", "-o", "x.png")
    no(2, "no file has such a name", "s.json", "--plate", "absent_%d.png", "-o", "x_%d.png")
    no(1, "one file for many pictures", "s.json", "--plate", "plate_%02d.png", "-o", "x.png")
    no(1, "must end in", "s.json", "--plate", "plate_03.png", "-o", "x.gif")
    no(1, "exposure", "s.json", "--plate", "plate_03.png", "-o", "x.png", "--exposure", "-1")
    no(2, "wrong.json", "s.json", "--plate", "plate_03.png", "-o", "x.png", "--response", "wrong.json")
    scene("orbit.json", camera="yaw=3")
    no(3, "must be the camera of a photograph", "orbit.json", "--plate", "plate_03.png", "-o", "x.png")
    scene("hilly.json", ground={"heights": {"analytic": "waves:height=0.1", "cell": 0.1}})
    no(3, "level ground", "hilly.json", "--plate", "plate_03.png", "-o", "x.png")
    # render draws such a scene by the same camera, and probe takes it.
    must(PLAYER, "render", "--scene", "s.json", "-o", "render.png", "--size", "160x120")
    assert np.asarray(Image.open("render.png"))[:10, :30, 3].max() == 0  # no ground
    refused(3, "give another camera", BAKE, "reference", "--scene", "s.json", "-o", "x.png")


def check_window():
    """The window shows what composite writes."""
    composite("s.json", "--plate", "plate_03.png", "-o", "still.png", "--exposure", 0.2)
    with Display():
        view = View("--scene", "s.json", "--plate", "plate_03.png", "--exposure", "0.2", "--screenshots", ".", size="640x480")
        view.keys("Tab", "F12")
        wait_until(lambda: os.path.exists("view_0001.png"), "a screenshot")
        view.keys("q")
        said = view.process.communicate(timeout=60)[0]
        assert view.process.returncode == 0 and "with a tag" in said, said
        done = subprocess.run([PLAYER, "view", "--scene", "moving.json", "--plate", ".", "--pictures", "3"],
                              capture_output=True, text=True)
        assert done.returncode == 3 and "several sequences" in done.stderr, done
    shown = Image.open("view_0001.png").convert("RGB").resize((WIDTH, HEIGHT), Image.BOX)
    difference = np.abs(np.asarray(shown).astype(int) - read("still.png"))
    assert difference.mean() < 4, difference.mean()
    refused(1, "--plate", PLAYER, "view", "--plate", "plate_03.png")
    refused(3, "must be the camera", PLAYER, "view", "--scene", "orbit.json", "--plate", "plate_03.png")


def main():
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        make_asset()
        write_plates(3)
        check_pictures()
        check_numbered()
        check_video()
        check_refusals()
        check_window()
    print("composites of pictures, numbered pictures and videos are as they should be")


main()
