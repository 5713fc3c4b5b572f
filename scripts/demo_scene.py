#!/usr/bin/python3
"""Puts the demo's character twice on a ground, and draws it by its model and by brute force.

demo_scene.py BIN_FOLDER DEMO_FOLDER HELD_OUT_CLIP LIGHT_FILE

Writes scene.json, and scene.png with both pictures, of which the left one is ray traced."""
import json
import pathlib
import sys

import h5py
import numpy as np
from PIL import Image, ImageDraw, ImageFont

from demo_pictures import MATERIAL, held_out_frames, mean_radiance, over_grey, rmse, run

SIZE = (720, 540)


def write_scene(folder, clip):
    """The middle of the held-out clip, and a second one beside it, half a turn away. Both stand on the ground."""
    (vis_frame, _), = held_out_frames(folder / "character.vis.h5", clip, 1)
    with h5py.File(folder / "character.vis.h5") as vis:
        positions, seconds = vis["frames/positions"][vis_frame].astype(float), float(vis["frames/time"][vis_frame])
    low, high = positions.min(0), positions.max(0)
    middle, height, apart = (low + high) / 2, high[1] - low[1], 0.6 * (high - low)[[0, 2]].max()
    one = {"asset": "composed.pnb", "clip": clip, "time": seconds}
    place = lambda x, turned: [float(x - turned * middle[0]), float(-low[1]), float(-turned * middle[2])]
    scene = {"version": 1,
             "characters": [{**one, "position": place(-apart, 1)}, {**one, "position": place(apart, -1), "yaw": 180}],
             "ground": {"size": float(2.5 * height), "resolution": 256},
             "camera": "yaw=25,pitch=18"}
    (folder / "scene.json").write_text(json.dumps(scene, indent=1))


def main():
    bins, folder, clip, light = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2]), sys.argv[3], sys.argv[4]
    write_scene(folder, clip)
    common = ["--scene", folder / "scene.json", "--size", f"{SIZE[0]}x{SIZE[1]}",
              "--exposure", f"{0.45 / max(mean_radiance(folder), 1e-6):.4g}"]
    truth, ours = folder / "scene_truth.png", folder / "scene_ours.png"
    run(bins / "penumbra-bake", "reference", *common, "--light", light, "--brdf", MATERIAL, "--samples", 512, "-o", truth)
    run(bins / "penumbra-player", "render", *common, "-o", ours)
    sheet = Image.new("RGB", (2 * SIZE[0], SIZE[1] + 26), (30, 31, 34))
    draw, font = ImageDraw.Draw(sheet), ImageFont.truetype("DejaVuSans.ttf", 15)
    for x, picture, title in ((0, truth, "truth (ray traced)"), (SIZE[0], ours, f"composed, RMSE {rmse(ours, truth):.1f} / 255")):
        sheet.paste(over_grey(picture), (x, 26))
        draw.text((x + 10, 5), title, fill=(235, 235, 235), font=font)
    sheet.save(folder / "scene.png")


if __name__ == "__main__":
    main()
