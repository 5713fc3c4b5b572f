#!/usr/bin/python3
"""Renders held-out frames as ray-traced truth and by three models, and lays them out as a contact sheet.

demo_pictures.py BIN_FOLDER DEMO_FOLDER HELD_OUT_CLIP LIGHT_FILE

Writes contact_sheet.png and pictures.json (image RMSE against truth, in 8-bit sRGB steps over the character's
pixels)."""
import json
import pathlib
import subprocess
import sys

import h5py
import numpy as np
from PIL import Image, ImageDraw, ImageFont

SIZE = 600
CAMERA = "yaw=35,pitch=12"
MATERIAL = "lambert:color=0.75/0.7/0.65"
MODELS = ["paper", "additive", "composed"]
COLUMNS = ["truth", *MODELS, "error_additive", "error_composed"]
TITLES = {"truth": "truth (ray traced)", "paper": "paper: joint angles, A4", "additive": "additive, D5",
          "composed": "composed, D5", "error_additive": "ambient error, additive",
          "error_composed": "ambient error, composed"}


def held_out_frames(vis_path, clip, count):
    """Returns `count` frames spread over the clip, as (frame of the file, frame of the clip)."""
    with h5py.File(vis_path) as vis:
        names = [n.decode() if isinstance(n, bytes) else n for n in vis["clips/names"][:]]
        frames = np.flatnonzero(vis["frames/clip"][:] == names.index(clip))
    chosen = np.linspace(0, len(frames) - 1, count + 2).round().astype(int)[1:-1]
    return [(int(frames[i]), int(i)) for i in chosen]


def mean_radiance(folder):
    """Returns the mean radiance of the light from its SH. The exposure makes it mid grey for every light."""
    with h5py.File(folder / "sky.light.h5") as light:
        return float((light["light/sh"][0] / np.sqrt(4 * np.pi)).mean())


def run(*command):
    subprocess.run([str(c) for c in command], check=True, stdout=subprocess.DEVNULL)


def render_row(bins, folder, clip, light, exposure, vis_frame, clip_frame):
    common = ["--size", f"{SIZE}x{SIZE}", "--camera", CAMERA, "--exposure", f"{exposure:.4g}"]
    out = {name: folder / f"{name}_{clip_frame:03d}.png" for name in COLUMNS}
    run(bins / "penumbra-bake", "reference", folder / "character.vis.h5", "--frame", vis_frame, "--brdf", MATERIAL,
        "--samples", 2048, "--light", light, "-o", out["truth"], *common)
    for model in MODELS:
        base = [bins / "penumbra-player", "render", folder / f"{model}.pnb", "--clip", clip, "--frame", clip_frame]
        run(*base, "-o", out[model], *common)
        if f"error_{model}" in out:
            run(*base, "-o", out[f"error_{model}"], *common[:4], "--channel", "error", "--truth",
                folder / "character.truth.pnb")
    return out


def over_grey(path):
    picture = Image.open(path).convert("RGBA")
    grey = Image.new("RGBA", picture.size, (58, 60, 64, 255))
    return Image.alpha_composite(grey, picture).convert("RGB")


def rmse(path, truth_path):
    """Returns the root mean square difference in 8-bit steps over the pixels that both pictures cover."""
    a, b = (np.asarray(Image.open(p).convert("RGBA"), float) for p in (path, truth_path))
    covered = (a[..., 3] > 254) & (b[..., 3] > 254)
    return float(np.sqrt(((a - b)[covered][:, :3] ** 2).mean()))


def common_box(rows, margin=16):
    """Returns the box that holds the character in every picture."""
    boxes = np.array([Image.open(pictures["truth"]).convert("RGBA").getchannel("A").getbbox() for _, pictures in rows])
    low, high = boxes[:, :2].min(0) - margin, boxes[:, 2:].max(0) + margin
    return (*np.maximum(low, 0), *np.minimum(high, SIZE))


def contact_sheet(rows, errors, path):
    font = ImageFont.truetype("DejaVuSans.ttf", 15)
    bar, box = 26, common_box(rows)
    width, height = max(box[2] - box[0], 230), box[3] - box[1]  # a title needs 230 pixels
    sheet = Image.new("RGB", (width * len(COLUMNS), bar + (height + bar) * len(rows)), (30, 31, 34))
    draw = ImageDraw.Draw(sheet)
    for c, name in enumerate(COLUMNS):
        draw.text((c * width + 10, 5), TITLES[name], fill=(235, 235, 235), font=font)
        for r, (frame, pictures) in enumerate(rows):
            y = bar + r * (height + bar)
            sheet.paste(over_grey(pictures[name]).crop(box), (c * width, y))
            label = f"held-out frame {frame}" if name == "truth" else \
                f"RMSE {errors[frame][name]:.1f} / 255" if name in errors[frame] else "dark blue 0, yellow 0.25"
            draw.text((c * width + 10, y + height + 4), label, fill=(200, 200, 200), font=font)
    sheet.save(path)


def main():
    bins, folder, clip, light = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2]), sys.argv[3], sys.argv[4]
    exposure = 0.45 / max(mean_radiance(folder), 1e-6)
    rows, errors = [], {}
    for vis_frame, clip_frame in held_out_frames(folder / "character.vis.h5", clip, 3):
        pictures = render_row(bins, folder, clip, light, exposure, vis_frame, clip_frame)
        errors[clip_frame] = {m: rmse(pictures[m], pictures["truth"]) for m in MODELS}
        rows.append((clip_frame, pictures))
    contact_sheet(rows, errors, folder / "contact_sheet.png")
    means = {m: float(np.mean([e[m] for e in errors.values()])) for m in MODELS}
    (folder / "pictures.json").write_text(json.dumps({"image_rmse": means, "frames": errors}, indent=1))


if __name__ == "__main__":
    main()
