#!/usr/bin/python3
"""The model beside brute force: one held-out frame, every material under every light, FLIP and RMSE of each pair.

picture_sheet.py BIN_FOLDER X.vis.h5 X.model.h5 CLIP FRAME OUT_FOLDER --material SPEC... --light ENV...

A material is an analytic BRDF ("ggx:alpha=0.3"), or the path of a measured one (.binary is MERL, anything else a
table); a light an analytic one ("sky:elevation=20") or the path of a picture.
Writes OUT_FOLDER/sheet.png, and with --csv appends a row a pair. Both sides have the same camera, exposure (a light's
mean radiance becomes mid grey) and full-resolution silhouette. FLIP is the mean over the pixels that either side's
character covers (flip_crop: over the crop, empty background included), RMSE is in 8-bit steps over those that both
cover."""
import csv
import pathlib
import subprocess
import sys

import h5py
import numpy as np
from PIL import Image, ImageDraw, ImageFont

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent))
import flip
from usage import ArgumentParser


def run(*command):
    subprocess.run([str(c) for c in command], check=True, stdout=subprocess.DEVNULL)


def frame_of_file(vis_path, clip, frame):
    with h5py.File(vis_path) as vis:
        names = [n.decode() if isinstance(n, bytes) else n for n in vis["clips/names"][:]]
        frames = np.flatnonzero(vis["frames/clip"][:] == names.index(clip)) if clip in names else []
    if frame >= len(frames):
        sys.exit(f"picture_sheet: {vis_path} has no frame {frame} of a clip {clip}; its clips are {', '.join(names)}")
    return int(frames[frame])


def is_file(spec):
    if "/" in spec and ":" not in spec and not pathlib.Path(spec).exists():
        sys.exit(f"picture_sheet: there is no {spec}")
    return pathlib.Path(spec).exists()


def material_arguments(spec):
    if not is_file(spec):
        return ["--analytic", spec], ["--brdf", spec]
    option = "--merl" if spec.endswith(".binary") else "--table"
    return [option, spec], [option, spec]


def stored_name(path):
    with h5py.File(path) as file:
        name = file.attrs["name"]
        return name.decode() if isinstance(name, bytes) else name


def mean_radiance(path):
    with h5py.File(path) as light:
        return float((light["light/sh"][0] / np.sqrt(4 * np.pi)).mean())


def prepare(arguments, out):
    """Fits materials and lights and packs them with the model. Returns their names in the asset, and each light's
    mean."""
    brdfs, lights = [], []
    for i, spec in enumerate(arguments.material):
        brdfs.append(out / f"material{i}.brdf.h5")
        run(arguments.bin / "penumbra-fit", "brdf", *material_arguments(spec)[0], "-o", brdfs[-1])
    for i, picture in enumerate(arguments.light):
        lights.append(out / f"light{i}.light.h5")
        source = [picture] if is_file(picture) else ["--analytic", picture]
        run(arguments.bin / "penumbra-fit", "light", *source, "-o", lights[-1], "--order", arguments.order, "--window",
            arguments.window)
    inputs = [a for path in brdfs for a in ("--brdf", path)] + [a for path in lights for a in ("--light", path)]
    run(arguments.bin / "penumbra-pack", "asset", arguments.model, *inputs, "-o", out / "sheet.pnb")
    return [stored_name(p) for p in brdfs], [stored_name(p) for p in lights], [mean_radiance(p) for p in lights]


def over_grey(path):
    picture = Image.open(path).convert("RGBA")
    return Image.alpha_composite(Image.new("RGBA", picture.size, (60, 60, 60, 255)), picture).convert("RGB")


def compare(model_path, truth_path, box):
    a, b = (np.asarray(Image.open(p).convert("RGBA"), float) for p in (truth_path, model_path))
    covered = (a[..., 3] > 254) & (b[..., 3] > 254)
    crops = [np.asarray(over_grey(p).crop(box), float) / 255 for p in (truth_path, model_path)]
    values = flip.flip_map(*crops)
    figure = np.maximum(a[..., 3], b[..., 3])[box[1]:box[3], box[0]:box[2]] > 0
    return {"flip": float(values[figure].mean()), "flip_crop": float(values.mean()),
            "rmse": float(np.sqrt(((a - b)[covered][:, :3] ** 2).mean()))}


def render_pairs(arguments, out):
    brdfs, lights, means = prepare(arguments, out)
    vis_frame = frame_of_file(arguments.vis, arguments.clip, arguments.frame)
    pairs = {}
    for m, spec in enumerate(arguments.material):
        for l, picture in enumerate(arguments.light):
            common = ["--size", f"{arguments.size}x{arguments.size}", "--camera", arguments.camera,
                      "--exposure", f"{0.4 / max(means[l], 1e-6):.4g}"]
            model, truth = out / f"model_{m}_{l}.png", out / f"truth_{m}_{l}.png"
            run(arguments.bin / "penumbra-player", "render", out / "sheet.pnb", "--clip", arguments.clip, "--frame",
                arguments.frame, "--brdf", brdfs[m], "--light", lights[l], "-o", model, *common)
            run(arguments.bin / "penumbra-bake", "reference", arguments.vis, "--frame", vis_frame,
                *material_arguments(spec)[1], "--tangents", arguments.model, "--light", picture,
                "--samples", arguments.samples, "-o", truth, *common)
            pairs[m, l] = (model, truth)
    return brdfs, lights, pairs


def common_box(pairs, size, margin=12):
    boxes = np.array([Image.open(truth).convert("RGBA").getchannel("A").getbbox() for _, truth in pairs.values()])
    low, high = boxes[:, :2].min(0) - margin, boxes[:, 2:].max(0) + margin
    return tuple(int(v) for v in (*np.maximum(low, 0), *np.minimum(high, size)))


def draw_sheet(brdfs, lights, pairs, figures, box, path):
    font = ImageFont.truetype("DejaVuSans.ttf", 14)
    bar, gap = 22, 10
    width, height = max(box[2] - box[0], 180), box[3] - box[1]  # a title needs 360 pixels
    sheet = Image.new("RGB", ((2 * width + gap) * len(lights) - gap, bar + (height + 2 * bar) * len(brdfs)), (30, 31, 34))
    draw = ImageDraw.Draw(sheet)
    for l, light in enumerate(lights):
        x = l * (2 * width + gap)
        draw.text((x + 8, 3), f"{light}: model | brute force", fill=(235, 235, 235), font=font)
        for m, brdf in enumerate(brdfs):
            y = bar + m * (height + 2 * bar)
            for side, picture in enumerate(pairs[m, l]):
                sheet.paste(over_grey(picture).crop(box), (x + side * width, y))
            draw.text((x + 8, y + height + 3), brdf[:60], fill=(200, 200, 200), font=font)
            value = figures[m, l]
            draw.text((x + 8, y + height + bar - 1), f"FLIP {value['flip']:.3f}, RMSE {value['rmse']:.1f} / 255",
                      fill=(255, 214, 120), font=font)
    sheet.quantize(256, method=Image.Quantize.MEDIANCUT, dither=Image.Dither.FLOYDSTEINBERG).save(path, optimize=True)


def append_rows(arguments, commit, brdfs, lights, figures):
    head = ["commit", "model", "clip", "frame", "size", "samples", "order", "window", "material", "light", "flip", "flip_crop",
            "rmse"]
    new = not arguments.csv.exists()
    with open(arguments.csv, "a", newline="") as file:
        rows = csv.writer(file, lineterminator="\n")
        if new:
            rows.writerow(head)
        for (m, l), value in figures.items():
            rows.writerow([commit, arguments.model.name, arguments.clip, arguments.frame, arguments.size, arguments.samples,
                           arguments.order, arguments.window, brdfs[m], lights[l], f"{value['flip']:.4f}",
                           f"{value['flip_crop']:.4f}", f"{value['rmse']:.2f}"])


def main():
    parser = ArgumentParser(__doc__)
    for name, kind in (("bin", pathlib.Path), ("vis", pathlib.Path), ("model", pathlib.Path), ("clip", str), ("frame", int),
                       ("out", pathlib.Path)):
        parser.add_argument(name, type=kind)
    parser.add_argument("--material", action="append", required=True)
    parser.add_argument("--light", action="append", required=True)
    parser.add_argument("--order", type=int, default=4, help="SH bands of the model's lights")
    parser.add_argument("--window", default="auto", help="against ringing of the model's lights, as in penumbra-fit light")
    parser.add_argument("--camera", default="yaw=30,pitch=10")
    parser.add_argument("--size", type=int, default=420)
    parser.add_argument("--csv", type=pathlib.Path, help="append a row a pair")
    parser.add_argument("--samples", type=int, default=1024, help="shadow rays a pixel of the brute force")
    arguments = parser.parse_args()
    arguments.out.mkdir(parents=True, exist_ok=True)
    commit = subprocess.run(["git", "rev-parse", "--short", "HEAD"], capture_output=True, text=True).stdout.strip()
    brdfs, lights, pairs = render_pairs(arguments, arguments.out)
    box = common_box(pairs, arguments.size)
    figures = {key: compare(*pair, box) for key, pair in pairs.items()}
    draw_sheet(brdfs, lights, pairs, figures, box, arguments.out / "sheet.png")
    for (m, l), value in figures.items():
        print(f"{brdfs[m][:40]:40} {lights[l]:24} FLIP {value['flip']:.4f}  RMSE {value['rmse']:.2f}")
    if arguments.csv:
        append_rows(arguments, commit, brdfs, lights, figures)


if __name__ == "__main__":
    main()
