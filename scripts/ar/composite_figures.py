#!/usr/bin/python3
"""FLIP and RMSE of composites inside touched.png, and how light the ground is around the character's middle.

composite_figures.py FOLDER NAME     of the pictures NAME.*.png and NAME.*.exr that check_composite made
"""
import json
import pathlib
import sys

import numpy as np
from PIL import Image

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent))
from ar.exr_reader import read_exr  # noqa: E402
from figures.flip import flip_map  # noqa: E402


def codes(path):
    return np.asarray(Image.open(path).convert("RGB"), float) / 255


def ground_points(truth):
    """Of every pixel, in metres of the character."""
    camera = truth["camera"]
    rotation, translation, (width, height) = np.array(camera["R"]), np.array(camera["t"]), camera["size"]
    x, y = np.meshgrid(np.arange(width), np.arange(height))
    rays = np.stack([(x - camera["cx"]) / camera["f"], (y - camera["cy"]) / camera["f"], np.ones(x.shape)], -1) @ rotation
    eye = -rotation.T @ translation
    far = np.where(rays[..., 2] < 0, -eye[2] / np.minimum(rays[..., 2], -1e-9), 1e9)
    return (eye + rays * far[..., None]) / truth["world_scale"]


def main():
    folder, name = pathlib.Path(sys.argv[1]), sys.argv[2]
    truth = json.loads((folder / "truth.json").read_text())
    touched = np.asarray(Image.open(folder / "touched.png").convert("L")) > 127
    reference = codes(f"{name}.truth.png")
    print(f"{name}: FLIP and RMSE inside touched.png, linear light without the sensor's noise")
    for key, what in (("ours", "true character, our ground"), ("no_bounce", "without light from the character"),
                      ("no_shadow", "without shadow"), ("own", "our character, our ground")):
        picture = codes(f"{name}.{key}.png")
        rmse = np.sqrt(((255 * (picture - reference))[touched] ** 2).mean())
        print(f"  {what:34s} {flip_map(reference, picture)[touched].mean():.4f} {rmse:6.2f}")
    middle = np.load(folder / "character.npz")["positions_marker"].mean(0)
    away = np.linalg.norm(ground_points(truth)[..., :2] - middle[:2], axis=-1)
    free = np.asarray(Image.open(folder / "truth_alpha.png").convert("L")) == 0
    plate = read_exr(f"{name}.plate.exr")
    for most in (0.15, 0.3, 0.6):
        near = free & (away < most)
        row = [read_exr(f"{name}.{key}.exr")[near].sum(0) / plate[near].sum(0) for key in ("truth", "own", "shadow_alone")]
        print(f"  light within {most:.2f} m over that of the plate: truth {row[0].round(3)} ours {row[1].round(3)} "
              f"shadow alone {row[2].round(3)}, off by {np.abs(row[1] - row[0]).max():.3f}")


if __name__ == "__main__":
    main()
