#!/usr/bin/python3
"""Puts the demo's character twice on a ground, and draws it by its model and by brute force.

demo_scene.py BIN_FOLDER DEMO_FOLDER HELD_OUT_CLIP LIGHT_FILE

Writes scene.json, and scene.png with both pictures, of which the left one is ray traced."""
import json
import pathlib
import shlex
import sys

import h5py
from PIL import Image, ImageDraw, ImageFont

from demo_pictures import held_out_frames, mean_radiance, over_grey, rmse, run

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
SIZE = (720, 540)


def posed(bake, clip, share):
    """Returns positions [V, 3] and seconds of the frame that lies a share of the clip after its start."""
    frames = held_out_frames(bake, clip, 99)
    vis_frame, _ = frames[min(int(share * len(frames)), len(frames) - 1)]
    with h5py.File(bake) as vis:
        return vis["frames/positions"][vis_frame].astype(float), float(vis["frames/time"][vis_frame])


def write_scene(folder, clip):
    """The middle of the held-out clip, and a second one beside it, half a turn away. Both stand on the ground."""
    positions, seconds = posed(folder / "character.vis.h5", clip, 0.5)
    low, high = positions.min(0), positions.max(0)
    middle, height, apart = (low + high) / 2, high[1] - low[1], 0.6 * (high - low)[[0, 2]].max()
    one = {"asset": "composed.pnb", "clip": clip, "time": seconds}
    place = lambda x, turned: [float(x - turned * middle[0]), float(-low[1]), float(-turned * middle[2])]
    scene = {"version": 1,
             "characters": [{**one, "position": place(-apart, 1)}, {**one, "position": place(apart, -1), "yaw": 180}],
             "ground": {"size": float(2.5 * height), "resolution": 256},
             "camera": "yaw=25,pitch=18"}
    (folder / "scene.json").write_text(json.dumps(scene, indent=1))


def draw_ours(bins, scene, look):
    ours = scene.with_name(scene.stem + "_ours.png")
    run(bins / "penumbra-player", "render", "--scene", scene, *look, "-o", ours)
    return ours


def draw_truth(bins, scene, look, samples, light=(), name="truth"):
    """Ray-traces the scene in its own light, or with --light in `light` in another one."""
    truth = scene.with_name(f"{scene.stem}_{name}.png")
    run(bins / "penumbra-bake", "reference", "--scene", scene, *look, *light, "--samples", samples, "-o", truth)
    return truth


def look_of(folder, size):
    return ["--size", f"{size[0]}x{size[1]}", "--exposure", f"{0.45 / max(mean_radiance(folder), 1e-6):.4g}"]


def side_by_side(pictures, titles, box):
    """A box of each picture side by side, each under its title."""
    width, height = box[2] - box[0], box[3] - box[1]
    sheet = Image.new("RGB", (len(pictures) * width, height + 26), (30, 31, 34))
    draw, font = ImageDraw.Draw(sheet), ImageFont.truetype("DejaVuSans.ttf", 15)
    for i, (picture, title) in enumerate(zip(pictures, titles)):
        sheet.paste(over_grey(picture).crop(box), (i * width, 26))
        draw.text((i * width + 10, 5), title, fill=(235, 235, 235), font=font)
    return sheet


def held_out_clip():
    """The held-out clip of the demo, or nothing where it never ran."""
    path = ROOT / "samples/sample.env"
    words = [shlex.split(line)[0].split("=", 1) for line in path.read_text().splitlines()[:-1]] if path.exists() else []
    return dict(words).get("HOLDOUT_CLIP")


def main():
    bins, folder, clip, light = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2]), sys.argv[3], sys.argv[4]
    write_scene(folder, clip)
    look = look_of(folder, SIZE)
    truth = draw_truth(bins, folder / "scene.json", look, 512, ["--light", light])
    ours = draw_ours(bins, folder / "scene.json", look)
    titles = ("truth (ray traced)", f"composed, RMSE {rmse(ours, truth):.1f} / 255")
    side_by_side((truth, ours), titles, (0, 0, *SIZE)).save(folder / "scene.png")


if __name__ == "__main__":
    main()
