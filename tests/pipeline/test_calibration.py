"""Calibration on pictures that this script makes: penumbra-fit response, camera, align and poses --colmap.

usage: test_calibration.py BIN
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
LENS = {"f": 400.0, "cx": 163.0, "cy": 117.5, "k1": -0.12, "k2": 0.03}
WORD, DPI, SIDE = "25h9:4x5:0.03:0.01", 150, 0.03


def fit(folder, *words, expect=0):
    """Runs penumbra-fit with an output, and returns that as text, the report's figures and stderr."""
    out, report = folder / "out.json", folder / "report.json"
    for path in (out, report):
        path.unlink(missing_ok=True)
    done = subprocess.run([BIN / "penumbra-fit", *map(str, words), "-o", out, "--report", report], capture_output=True,
                          text=True)
    assert done.returncode == expect, (words, done.returncode, done.stderr)
    if expect:
        assert not out.exists(), "a refused run leaves nothing"
        return done.stderr
    return json.loads(out.read_text()), json.loads(report.read_text())["figures"], done.stderr


def check_response(folder):
    """Fields of many brightnesses under the curve of Rec.709, and brackets that are wrong."""
    random = np.random.default_rng(1)
    light = np.kron(10**np.linspace(-2.7, 2.3, 144).reshape(12, 12), np.ones((10, 10)))[..., None].repeat(3, 2)
    pictures = []
    for k in range(6):
        shown = light / 4**k
        shown = np.clip(shown + random.normal(0, 1, shown.shape) * (0.0015 + 0.004 * np.sqrt(shown)), 0, 1)
        codes = np.where(shown < 0.018, 4.5 * shown, 1.099 * shown**0.45 - 0.099)
        Image.fromarray(np.round(255 * codes).astype(np.uint8)).save(folder / f"b{k}.png")
        pictures.append({"file": f"b{k}.png", "exposure": 4.0**-k})
    bracket = folder / "bracket.json"

    def listed(shots):
        bracket.write_text(json.dumps({"pictures": shots}))
        return bracket

    found, figures, warned = fit(folder, "response", listed(pictures))
    codes = np.arange(10, 246) / 255
    true = np.where(codes < 0.081, codes / 4.5, ((codes + 0.099) / 1.099)**(1 / 0.45))
    for channel, quality in zip(found["exposure"], figures["channels"]):
        ratio = np.array(channel)[10:246] / true
        error = np.sqrt(np.mean((ratio / (ratio**2).mean() * ratio.mean() - 1)**2))
        assert error < 0.03, error
        assert quality["rms"] < 0.1 and quality["samples"] >= 100, quality
    assert warned == "", warned
    assert "like the one before" in fit(folder, "response", listed([pictures[0], *pictures]), expect=3)
    assert "must all rise or all fall" in fit(folder, "response", listed([pictures[1], pictures[0], pictures[2]]), expect=3)
    assert "has no \"exposure\"" in fit(folder, "response", listed([pictures[0], {"file": "b1.png"}]), expect=3)
    assert "missing.png" in fit(folder, "response", listed([pictures[0], {"file": "missing.png", "exposure": 0.5}]), expect=2)
    Image.new("RGB", (60, 40)).save(folder / "small.png")
    assert "is 60x40, and" in fit(folder, "response", listed([pictures[0], {"file": "small.png", "exposure": 0.5}]), expect=3)
    Image.new("RGB", (60, 40), (255, 255, 255)).save(folder / "white.png")
    white = [{"file": "white.png", "exposure": 1}, {"file": "white.png", "exposure": 0.25}]
    assert "clipped everywhere" in fit(folder, "response", listed(white), expect=3)
    swapped = [pictures[0], {**pictures[1], "file": "b3.png"}, pictures[2]]
    assert "exposures are out of order" in fit(folder, "response", listed(swapped), expect=3)
    same = [pictures[0], {**pictures[1], "file": "b0.png"}]
    assert "is the same picture as" in fit(folder, "response", listed(same), expect=3)


def turn_of(vector):
    angle = np.linalg.norm(vector)
    x, y, z = np.asarray(vector) / angle
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross


def photograph(page, number, tilt):
    """The grid from one side; three by three rays a pixel, noise, sRGB codes."""
    size, random = 0.0254 / DPI, np.random.default_rng(number)
    around = number * 2.4
    turn = turn_of(tilt * np.array([np.cos(around), np.sin(around), 1e-9])) @ np.diag([1.0, -1.0, -1.0])
    shift = np.array([0.03 * np.cos(1.7 * number), 0.02 * np.sin(2.9 * number), 0.26 + 0.03 * (number % 3)])
    fine = (np.arange(3) - 1) / 3
    u, v = np.meshgrid((np.arange(320)[:, None] + fine).ravel(), (np.arange(240)[:, None] + fine).ravel())
    seen = np.stack([(u - LENS["cx"]) / LENS["f"], (v - LENS["cy"]) / LENS["f"]])
    ray = seen.copy()
    for _ in range(15):
        square = (ray**2).sum(0)
        ray = seen / (1 + LENS["k1"] * square + LENS["k2"] * square**2)
    way = np.einsum("ji,jhw->ihw", turn, np.concatenate([ray, np.ones_like(ray[:1])]))
    eye = -turn.T @ shift
    hit = eye[:, None, None] - way * (eye[2] / way[2])
    column = np.floor(hit[0] / size + page.shape[1] / 2).astype(int).clip(0, page.shape[1] - 1)
    row = np.floor(page.shape[0] / 2 - hit[1] / size).astype(int).clip(0, page.shape[0] - 1)
    light = (0.03 + 0.6 * page[row, column]).reshape(240, 3, 320, 3).mean((1, 3)) + random.normal(0, 0.003, (240, 320))
    codes = np.where(light <= 0.0031308, 12.92 * light, 1.055 * light.clip(1e-6)**(1 / 2.4) - 0.055).clip(0, 1)
    return np.repeat(np.round(255 * codes).astype(np.uint8)[..., None], 3, 2)


def check_camera(folder):
    subprocess.run([ROOT / "scripts/ar/make_tags", "grid", WORD, "-o", folder / "grid.png", "--dpi", str(DPI)], check=True)
    page = np.asarray(Image.open(folder / "grid.png").convert("L")).astype(float) / 255
    files = []
    for shot in range(10):
        files.append(folder / f"shot{shot}.png")
        Image.fromarray(photograph(page, shot, 0.5)).save(files[-1])
    found, figures, _ = fit(folder, "camera", *files, "--tags", WORD)
    assert abs(found["f"] / LENS["f"] - 1) < 0.004, found
    assert abs(found["cx"] - LENS["cx"]) < 1.5 and abs(found["cy"] - LENS["cy"]) < 1.5, found
    assert figures["residual_px"] < 0.3 and 0 < figures["f"]["deviation"] < 2, figures
    both = np.concatenate([photograph(page, 0, 0.1), photograph(page, 0, 0.1)], 1)  # two grids beside one another
    Image.fromarray(both).save(folder / "both.png")
    assert "both.png: tag 25h9:" in fit(folder, "camera", folder / "both.png", "--tags", WORD, expect=3)
    assert "only 2 pictures" in fit(folder, "camera", *files[:2], "--tags", WORD)[2]
    Image.fromarray(photograph(page, 0, 0.01)).save(folder / "level.png")
    assert "tells no focal length" in fit(folder, "camera", folder / "level.png", "--tags", WORD, expect=3)
    assert "no picture shows the grid" in fit(folder, "camera", folder / "white.png", "--tags", WORD, expect=3)
    assert "has 60 x 40 pixels" in fit(folder, "camera", files[0], folder / "white.png", "--tags", WORD, expect=3)
    assert "--tags" in fit(folder, "camera", files[0], "--tags", "25h9:4x5:0.03", expect=1)


def check_align(folder):
    """A track of structure from motion comes to a marker's, through a change of frame and scale."""
    random, turn, scale, origin = np.random.default_rng(2), turn_of([0.3, -0.8, 1.1]), 0.37, np.array([0.25, -0.4, 0.05])
    camera, frames, images = {"f": 400, "size": [320, 240]}, [], ""
    places = []
    for i in range(12):
        around = 0.15 * i
        place = np.array([0.8 * np.cos(around), 0.8 * np.sin(around), 0.5 + 0.02 * i])
        z = -place / np.linalg.norm(place)
        x = np.cross(z, [0, 0, 1]) / np.linalg.norm(np.cross(z, [0, 0, 1]))
        look = np.stack([x, np.cross(z, x), z])
        places.append(place)
        noisy = turn_of(random.normal(0, 0.002, 3)) @ look
        if i != 4:  # the marker is hidden here
            frames.append({"file": f"in/f{i}.jpg", "R": noisy.tolist(),
                           "t": (-look @ place + random.normal(0, 0.0005, 3)).tolist()})
        mapped = look @ turn.T
        w = np.sqrt(max(1 + np.trace(mapped), 1e-9)) / 2
        q = np.array([mapped[2, 1] - mapped[1, 2], mapped[0, 2] - mapped[2, 0], mapped[1, 0] - mapped[0, 1]]) / (4 * w)
        shift = -mapped @ (scale * turn @ place + origin)
        images += " ".join(map(repr, map(float, [i + 1, w, *q, *shift]))).replace(f"{i + 1}.0 ", f"{i + 1} ", 1) + \
            f" 1 f{i}.jpg\n\n"
    (folder / "a.json").write_text(json.dumps({"format": "penumbra.camera_poses", "camera": camera, "frames": frames}))
    model = folder / "sparse"
    model.mkdir()
    (model / "images.txt").write_text("# images\n" + images)
    (model / "cameras.txt").write_text("1 SIMPLE_RADIAL 320 240 400 160 120 0.01\n")
    track, _, _ = fit(folder, "poses", "--colmap", model)
    assert len(track["frames"]) == 12 and track["camera"]["cx"] == 159.5, track["camera"]
    (folder / "b.json").write_text(json.dumps(track))
    joined, figures, warned = fit(folder, "align", folder / "a.json", folder / "b.json")
    assert figures["pictures"] == 11 and abs(figures["scale"] / scale - 1) < 0.002, figures
    assert np.linalg.norm(np.array(figures["origin"]) - origin) < 0.002 and warned == "", (figures, warned)
    names = [pathlib.Path(frame["file"]).name for frame in joined["frames"]]
    assert names == [f"f{i}.jpg" for i in range(12)], names  # also f4, which the first track lacks
    hidden = {**track, "frames": [frame for frame in track["frames"] if frame["file"] not in ("f2.jpg", "f9.jpg")]}
    (folder / "hidden.json").write_text(json.dumps(hidden))
    inserted = fit(folder, "align", folder / "a.json", folder / "hidden.json")[0]
    assert [pathlib.Path(frame["file"]).name for frame in inserted["frames"]] == names, inserted
    zoomed = {**track, "camera": {**track["camera"], "f": 520}}
    (folder / "zoomed.json").write_text(json.dumps(zoomed))
    assert "have cameras that differ" in fit(folder, "align", folder / "a.json", folder / "zoomed.json", expect=3)
    zoomed["camera"]["f"] = 410
    (folder / "zoomed.json").write_text(json.dumps(zoomed))
    assert "have cameras that differ" in fit(folder, "align", folder / "a.json", folder / "zoomed.json")[2]
    for frame in joined["frames"]:
        place = -np.array(frame["R"]).T @ np.array(frame["t"])
        assert np.linalg.norm(place - places[int(pathlib.Path(frame["file"]).stem[1:])]) < 0.004, frame["file"]
    (model / "cameras.txt").write_text("1 OPENCV 320 240 400 400 160 120 0 0 0 0\n")
    assert "camera model OPENCV" in fit(folder, "poses", "--colmap", model, expect=5)
    bones = {"format": "penumbra.bone_poses", "version": 1}
    (folder / "bones.json").write_text(json.dumps(bones))
    assert "penumbra.bone_poses" in fit(folder, "align", folder / "a.json", folder / "bones.json", expect=3)
    other = {"format": "penumbra.camera_poses", "camera": camera, "frames": [{**frames[0], "file": "other.jpg"}]}
    (folder / "c.json").write_text(json.dumps(other))
    assert "have 0 pictures in common" in fit(folder, "align", folder / "a.json", folder / "c.json", expect=3)
    assert "give one of them" in fit(folder, "poses", expect=1)


def main():
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        check_response(folder)
        check_camera(folder)
        check_align(folder)


main()
