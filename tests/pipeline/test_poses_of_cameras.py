"""Tags as scripts/ar/make_tags prints them, photographed by this script, and penumbra-fit poses.

usage: test_poses_of_cameras.py BIN
"""
import json
import pathlib
import subprocess
import sys
import tempfile

import numpy as np
from PIL import Image

BIN = pathlib.Path(sys.argv[1]).resolve()
ROOT = pathlib.Path(__file__).resolve().parents[2]
DPI = 150
CAMERA = {"f": 420.0, "cx": 159.5, "cy": 119.5, "size": [320, 240], "k1": -0.15, "k2": 0.03}


def printed(folder, word, *more):
    """A page as light, and metres a pixel of it."""
    done = subprocess.run([ROOT / "scripts/ar/make_tags", *more, word, "-o", folder / "page.png", "--dpi", str(DPI)],
                          capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return np.asarray(Image.open(folder / "page.png")).astype(float) / 255, 0.0254 / DPI


def looking(eye, target):
    eye, target = np.array(eye, float), np.array(target, float)
    z = (target - eye) / np.linalg.norm(target - eye)
    x = np.cross(z, [0, 0, 1])
    x /= np.linalg.norm(x)
    rotation = np.stack([x, np.cross(z, x), z])
    return rotation, -rotation @ eye


def photograph(pages, rotation, translation, paper=0.6):
    """Pages lie on z = 0 at (x, y) of their middles; three by three rays a pixel, sRGB codes."""
    f, (w, h) = CAMERA["f"], CAMERA["size"]
    offsets = (np.arange(3) - 1) / 3
    u, v = np.meshgrid((np.arange(w)[:, None] + offsets).ravel(), (np.arange(h)[:, None] + offsets).ravel())
    seen = np.stack([(u - CAMERA["cx"]) / f, (v - CAMERA["cy"]) / f])
    ray = seen.copy()
    for _ in range(30):  # undo the lens
        square = (ray**2).sum(0)
        ray = seen / (1 + CAMERA["k1"] * square + CAMERA["k2"] * square**2)
    way = np.concatenate([ray, np.ones_like(ray[:1])]).reshape(3, -1).T @ rotation
    eye = -rotation.T @ translation
    hit = eye + way * (-eye[2] / way[:, 2:])
    light = np.full(len(hit), 0.2)
    for page, size, x, y in pages:
        column = np.floor((hit[:, 0] - x) / size + page.shape[1] / 2).astype(int)
        row = np.floor((y - hit[:, 1]) / size + page.shape[0] / 2).astype(int)
        inside = (way[:, 2] < 0) & (column >= 0) & (row >= 0) & (column < page.shape[1]) & (row < page.shape[0])
        light[inside] = paper * (0.05 + 0.95 * page[row[inside], column[inside]])
    light = light.reshape(h, 3, w, 3).mean((1, 3)) + np.random.default_rng(1).normal(0, 0.003, (h, w))
    light = np.clip(light, 0, 1)
    codes = np.where(light <= 0.0031308, 12.92 * light, 1.055 * light**(1 / 2.4) - 0.055)
    return np.repeat(np.round(255 * codes).astype(np.uint8)[..., None], 3, 2)


def poses(folder, files, *more, expect=0):
    done = subprocess.run([BIN / "penumbra-fit", "poses", *map(str, files), "--camera", folder / "cam.json", "-o",
                           folder / "out.json", "--report", folder / "report.json", *more], capture_output=True,
                          text=True)
    assert done.returncode == expect, (done.returncode, done.stderr)
    if expect:
        assert not (folder / "out.json").exists(), "a refused run leaves nothing"
        return done.stderr
    track = json.loads((folder / "out.json").read_text())
    (folder / "out.json").unlink()
    assert track["format"] == "penumbra.camera_poses"
    return track["frames"], done.stderr


def apart(frame, truth):
    """Metres and degrees between a pose and the true one."""
    rotation, translation = np.array(frame["R"]), np.array(frame["t"])
    turn = np.arccos(np.clip((np.trace(rotation @ truth[0].T) - 1) / 2, -1, 1))
    place = np.linalg.norm(rotation.T @ translation - truth[0].T @ truth[1])
    return place, np.degrees(turn)


def write(folder, name, picture):
    Image.fromarray(picture).save(folder / name)
    return folder / name


def check_every_family(folder):
    truth = looking([0.15, -0.5, 0.45], [0.01, 0, 0])
    for family in ("36h11", "25h9", "16h5", "4x4_50"):
        word = f"{family}:5:0.12"
        page, size = printed(folder, word, "single")
        # The tag is not in the middle of its page, which has a line of text below.
        top = np.nonzero((page < 0.5).sum(1) > 40)[0][0]
        shift = (page.shape[0] / 2 - (top + 0.12 / size / 2)) * size
        file = write(folder, "one.png", photograph([(page, size, 0, -shift)], *truth))
        (frame,), warned = poses(folder, [file], "--tag", word)
        place, turn = apart(frame, truth)
        assert place < 0.005 * 0.69 and turn < 0.4 and frame["residual"] < 0.3, (family, place, turn, frame)
        assert frame["margin"] > 0.5 and warned == "", warned
    clipped = write(folder, "bright.png", photograph([(page, size, 0, -shift)], *truth, paper=1.0))
    assert "clipped" in poses(folder, [clipped], "--tag", word)[1]
    return page, size, shift


def check_several_tags(folder):
    """Three frames: both tags, the second alone, none. The second is known from the first frame."""
    pages = []
    for number, x in ((1, -0.11), (2, 0.11)):
        page, size = printed(folder, f"25h9:{number}:0.1", "single")
        top = np.nonzero((page < 0.5).sum(1) > 40)[0][0]
        pages.append((page, size, x + 0.11, -(page.shape[0] / 2 - (top + 0.1 / size / 2)) * size))
    truths = [looking([0.2 + 0.02 * i, -0.6, 0.5], [0.12, 0, 0]) for i in range(5)]
    pictures = [pages, [pages[1]], [], pages, pages]
    for i, shown in enumerate(pictures):
        write(folder, f"f.{i:03d}.png", photograph(shown, *truths[i]))
    words = ["--tag", "25h9:1:0.1", "--tag", "25h9:2:0.1"]
    frames, warned = poses(folder, [folder / "f.%03d.png"], *words)
    assert "1 of 5 pictures: no tag is seen" in warned, warned
    for i, frame in enumerate(frames):
        place, turn = apart(frame, truths[i])
        assert place < 0.012 and turn < 1, (i, place, turn)
        assert frame.get("filled", False) == (i == 2)
    frames, _ = poses(folder, [folder / "f.%03d.png"], *words, "--gaps", "leave", "--smooth", "1")
    assert "R" not in frames[2] and "R" in frames[1]
    return folder / "f.000.png", folder / "f.002.png", pages


def check_refusals(folder, page, size, shift, both, none):
    twice = photograph([(page, size, -0.12, -shift), (page, size, 0.12, -shift)], *looking([0, -0.7, 0.6], [0, 0, 0]))
    exif = Image.Exif()
    exif[0x0112] = 6
    Image.open(both).save(folder / "turned.jpg", quality=98, exif=exif)
    assert "orientation 6" in poses(folder, [folder / "turned.jpg"], "--tag", "25h9:1:0.1")[1]
    cases = [([write(folder, "twice.png", twice)], ["--tag", "4x4_50:5:0.12"], 3, "4x4_50:5 is there twice"),
             ([none], ["--tag", "25h9:1:0.1"], 3, "no such tag is seen in any picture"),
             ([write(folder, "small.png", np.zeros((40, 60, 3), np.uint8))], ["--tag", "25h9:1:0.1"], 3,
              "has 60 x 40 pixels, and the camera has 320 x 240"),
             ([both], ["--tag", "25h9:1"], 1, "a tag is FAMILY:ID:SIDE"),
             ([both], ["--tag", "25h9:1:0.1", "--response", "film"], 2, "film"),
             ([folder / "missing.png"], ["--tag", "25h9:1:0.1"], 2, "missing.png")]
    for files, more, code, text in cases:
        assert text in poses(folder, files, *more, expect=code), (files, more)
    # Wrong intrinsics: told, also by -q, and refused where the residual is gross.
    file = write(folder, "near.png", photograph([(page, size, 0, -shift)], *looking([0.1, -0.25, 0.2], [0, 0, 0])))
    for f, code in ((380.0, 0), (220.0, 3)):
        (folder / "cam.json").write_text(json.dumps({**CAMERA, "f": f}))
        said = poses(folder, [file], "--tag", "4x4_50:5:0.12", "-q", expect=code)
        assert "are not those of these pictures" in (said if code else said[1]), (f, said)


def main():
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        (folder / "cam.json").write_text(json.dumps(CAMERA))
        page, size, shift = check_every_family(folder)
        both, none, _ = check_several_tags(folder)
        check_refusals(folder, page, size, shift, both, none)


main()
