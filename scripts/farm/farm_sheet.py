#!/usr/bin/python3
"""Makes a picture of held-out frames of an asset.

It has baked truth, model and ambient error side by side, then every material under every light.

farm_sheet.py PLAYER BAKE X.pnb X.truth.pnb --light E.light.h5... -o SHEET.png [--frames 3] [--size 320]
              [--camera ...]"""
import io
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import time

sys.path.insert(0, os.path.dirname(os.path.dirname(os.path.realpath(__file__))))
from farm.ending import end_with
from farm.stamps import write_whole
from usage import ArgumentParser

BAR = 24  # pixels of a line of text
GREY = (58, 60, 64, 255)


def import_modules():
    """Imports the modules of other packages here, where end_with() tells of a missing one."""
    global h5py, np, Image, ImageDraw, ImageFont
    import h5py
    import numpy as np
    from PIL import Image, ImageDraw, ImageFont


def run(*words):
    result = subprocess.run([str(w) for w in words], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    if result.returncode != 0:
        raise SystemExit(result.stderr.strip())


def info(bake, path, folder):
    run(bake, "info", path, "--report", folder / "info.json")
    return json.loads((folder / "info.json").read_text())["figures"]


def exposures(files):
    """Returns light name -> exposure that makes its mean radiance mid grey."""
    found = {}
    for path in files:
        with h5py.File(path) as light:
            mean = float((light["light/sh"][0] / np.sqrt(4 * np.pi)).mean())
        found[path.name.removesuffix(".light.h5")] = 0.45 / max(mean, 1e-6)
    return found


def picture(arguments, folder, *words):
    path = folder / "picture.png"
    run(arguments.player, "render", arguments.asset, "-o", path, "--size", f"{arguments.size}x{arguments.size}",
        "--camera", arguments.camera, *words)
    return Image.open(path).convert("RGBA").copy()


def rmse(a, b):
    """Returns the root mean square difference in 8-bit steps over the pixels that both pictures cover."""
    a, b = np.asarray(a, float), np.asarray(b, float)
    covered = (a[..., 3] > 254) & (b[..., 3] > 254)
    return float(np.sqrt(((a - b)[covered][:, :3] ** 2).mean())) if covered.any() else None


def chosen_frames(clips, count):
    """Returns (clip, frame) of `count` frames spread over every held-out clip."""
    return [(clip["name"], int(frame)) for clip in clips
            for frame in sorted(set(np.linspace(0, clip["frames"] - 1, count + 2).round().astype(int)[1:-1]))]


def compare_rows(arguments, folder, frames, material, light, exposure):
    """Draws a row for each frame: truth, model, error; and returns the figures of each."""
    rows, figures = [], []
    for clip, frame in frames:
        at = ["--clip", clip, "--frame", frame]
        look = [*at, "--brdf", material, "--light", light, "--exposure", f"{exposure:.4g}"]
        truth = picture(arguments, folder, *look, "--source", "truth", "--truth", arguments.truth)
        model = picture(arguments, folder, *look)
        error = picture(arguments, folder, *at, "--channel", "error", "--truth", arguments.truth)
        off = rmse(model, truth)
        figures.append({"clip": clip, "frame": frame, "image_rmse": off})
        distance = "" if off is None else f": RMSE {off:.1f} / 255"
        rows.append([(truth, f"{clip} {frame}: truth"), (model, f"model{distance}"), (error, "ambient error, yellow 0.25")])
    return rows, figures


def looks_rows(arguments, folder, frame, materials, exposure_of):
    """Draws a row for each light and a column for each material, at one frame."""
    at = ["--clip", frame[0], "--frame", frame[1]]
    return [[(picture(arguments, folder, *at, "--brdf", m, "--light", l, "--exposure", f"{e:.4g}"), f"{m}, {l}")
             for m in materials] for l, e in exposure_of.items()]


def draw_sheet(rows, size, path):
    font = ImageFont.truetype("DejaVuSans.ttf", 13)
    sheet = Image.new("RGB", (size * max(map(len, rows)), (size + BAR) * len(rows)), (30, 31, 34))
    draw = ImageDraw.Draw(sheet)
    for r, row in enumerate(rows):
        for c, (image, title) in enumerate(row):
            over = Image.alpha_composite(Image.new("RGBA", image.size, GREY), image).convert("RGB")
            sheet.paste(over, (c * size, r * (size + BAR) + BAR))
            draw.text((c * size + 8, r * (size + BAR) + 4), title, fill=(235, 235, 235), font=font)
    png = io.BytesIO()
    sheet.save(png, "PNG")
    write_whole(str(path), png.getvalue())


def main():
    parser = ArgumentParser(__doc__)
    for name in ("player", "bake", "asset", "truth"):
        parser.add_argument(name)
    parser.add_argument("--light", action="append", type=pathlib.Path, required=True)
    parser.add_argument("--frames", type=int, default=3, help="frames of each held-out clip")
    parser.add_argument("--size", type=int, default=320)
    parser.add_argument("--camera", default="yaw=35,pitch=12")
    parser.add_argument("--report", type=pathlib.Path)
    parser.add_argument("-o", "--output", type=pathlib.Path, required=True)
    arguments = parser.parse_args()
    import_modules()
    start = time.monotonic()
    exposure_of = exposures(arguments.light)
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        materials = [m["name"] for m in info(arguments.bake, arguments.asset, folder)["materials"]]
        frames = chosen_frames(info(arguments.bake, arguments.truth, folder)["clips"], arguments.frames)
        light, exposure = next(iter(exposure_of.items()))
        rows, figures = compare_rows(arguments, folder, frames, materials[0], light, exposure)
        rows += looks_rows(arguments, folder, frames[len(frames) // 2], materials, exposure_of)
    draw_sheet(rows, arguments.size, arguments.output)
    if arguments.report:
        report = {"schema": "penumbra.report", "schema_version": 1, "tool": "farm_sheet.py", "verb": "sheet", "exit_code": 0,
                  "output": str(arguments.output), "seconds": time.monotonic() - start,
                  "figures": {"material": materials[0], "light": light, "frames": figures}}
        write_whole(str(arguments.report), json.dumps(report, indent=1))


if __name__ == "__main__":
    end_with(main)
