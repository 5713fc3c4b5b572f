#!/usr/bin/python3
"""Light that bounces, beside path tracing: one frame of a bake of transfer, diffuse.

compare_bounces.py BIN_FOLDER X.transfer.vis.h5 LIGHT.light.h5 OUT_FOLDER [--asset X.pnb] [--clip C --frame N] ...

Prints the relative error of the radiance of the baked transfer against penumbra-bake reference --bounces, over the
pixels that both cover but for silhouettes, inner ones too, and over those of them to whose colour one vertex gives
0.95: between vertices the transfer is only as fine as the mesh.

--split also prints what the errors consist of, from a run of a quarter of the samples, from a second bake with another
seed (--second-bake), and over pixels at several distances from vertices. With --asset it also prints FLIP of the
player's picture with and without light that bounces against the same reference, over the pixels of the character, and
writes OUT_FOLDER/sheet.png: direct light | all light | path tracing. The first material of the asset must be a lambert
of the same albedo."""
import pathlib
import subprocess
import sys

import h5py
import numpy as np
from PIL import Image

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent))
import flip
from picture_sheet import compare, frame_of_file, over_grey
from usage import ArgumentParser


def run(*command):
    subprocess.run([str(c) for c in command], check=True, stdout=subprocess.DEVNULL)


class Camera:
    """sh/camera.h, with everything given."""

    def __init__(self, positions, yaw=30, pitch=10, zoom=1, fov=35):
        low, high = positions.min(0), positions.max(0)
        self.target, self.fov = (low + high) / 2, np.radians(fov)
        radius = np.linalg.norm(high - low) / 2
        self.distance = radius / np.sin(self.fov / 2) / zoom
        y, p = np.radians(yaw), np.radians(pitch)
        back = np.array([np.sin(y) * np.cos(p), np.sin(p), np.cos(y) * np.cos(p)])
        self.eye, self.forward = self.target + self.distance * back, -back
        self.right = np.cross(self.forward, [0, 1, 0])
        self.right /= np.linalg.norm(self.right)
        self.up = np.cross(self.right, self.forward)
        self.scale = 2 * self.distance * np.tan(self.fov / 2)  # width of the picture at the target
        self.text = (f"yaw={yaw},pitch={pitch},fov={fov},distance={self.distance:.6g},"
                     f"target={'/'.join(f'{t:.6g}' for t in self.target)}")

    def project(self, positions, size):
        d = positions - self.eye
        depth = d @ self.forward
        scale = size / 2 / np.tan(self.fov / 2)
        return np.stack([size / 2 + scale * (d @ self.right) / depth, size / 2 - scale * (d @ self.up) / depth], 1), depth


def facing(camera, positions, triangles):
    """The triangles whose fronts the camera sees."""
    a, b, c = (positions[triangles[:, i]] for i in range(3))
    return triangles[np.einsum("ti,ti->t", np.cross(b - a, c - a), camera.eye - a) > 0]


def draw(camera, positions, triangles, values, size):
    """Interpolates values of vertices over the pixels, nearest triangles in front. NaN where there is none. The second
    picture has the largest share of one vertex, the third the depth."""
    at, depth = camera.project(positions, size)
    nearest = np.full((size, size), np.inf)
    image, share = np.full((size, size, 3), np.nan), np.zeros((size, size))
    for corners in triangles:
        p, z = at[corners], depth[corners]
        low = np.maximum(np.floor(p.min(0)).astype(int), 0)
        high = np.minimum(np.ceil(p.max(0)).astype(int), size)
        area = np.cross(p[1] - p[0], p[2] - p[0])
        if (low >= high).any() or area == 0:
            continue
        y, x = np.mgrid[low[1]:high[1], low[0]:high[0]]
        q = np.stack([x + 0.5, y + 0.5], -1) - p[0]
        u = (q[..., 0] * (p[2] - p[0])[1] - q[..., 1] * (p[2] - p[0])[0]) / area
        v = ((p[1] - p[0])[0] * q[..., 1] - (p[1] - p[0])[1] * q[..., 0]) / area
        weights = np.stack([1 - u - v, u, v], -1) / z  # perspective
        z_here = 1 / weights.sum(-1)
        box = (slice(low[1], high[1]), slice(low[0], high[0]))
        seen = (u >= 0) & (v >= 0) & (u + v <= 1) & (z_here < nearest[box])
        nearest[box][seen] = z_here[seen]
        weights = weights[seen] * z_here[seen][:, None]
        image[box][seen] = weights @ values[corners]
        share[box][seen] = weights.max(1)
    return image, share, nearest


def away_from_edges(depth, pixel):
    """The pixels of whose neighbourhood of 3 x 3 no two differ in depth by more than 12 pixels' width: there a part of
    the body stands before another, and what a pixel shows is chance."""
    around = np.stack([np.roll(depth, (dy, dx), (0, 1)) for dy in (-1, 0, 1) for dx in (-1, 0, 1)])
    return np.isfinite(around).all(0) & (np.ptp(np.nan_to_num(around, posinf=0), 0) < 12 * pixel)


def inner(mask):
    """The pixels whose eight neighbours are in the mask too."""
    out = mask.copy()
    for dy in (-1, 0, 1):
        for dx in (-1, 0, 1):
            out &= np.roll(mask, (dy, dx), (0, 1))
    return out


def baked_radiance(vis, frame, light, albedo, bounces):
    n2 = min(vis["visibility/coefficients"].shape[2], len(light))
    t = vis["visibility/coefficients"][frame][:, None, :].astype(np.float64).repeat(3, 1)
    if bounces > 0:
        t += vis["visibility/indirect"][frame]
    return np.maximum(0, np.einsum("vci,ic->vc", t[..., :n2], light[:n2]) * albedo / np.pi)


def srgb(linear):
    return np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)


def root(square):
    return f"{np.sqrt(max(square, 0)):.4f}"


def print_split(pictures, share):
    """Prints the parts of the error at vertices, as relative errors that add up as squares.

    `pictures` has the linear pictures "found", "true", "quarter" (true with a quarter of the samples) and, with a second
    bake, "second". The square of the noise of N samples falls at least as c / N, so that the errors of two N bound it."""
    found, true = pictures["found"], pictures["true"]
    for least in (0, 0.9, 0.95, 0.98):
        mask = pictures["both"] & (share > least)
        energy = (true[mask] ** 2).sum()
        square = lambda a, b: ((a - b)[mask] ** 2).sum() / energy
        total, noise = square(found, true), (square(found, pictures["quarter"]) - square(found, true)) / 3
        # An 8-bit step lies between two values of sRGB: what it costs is measured on the other picture.
        rounding = square(found, flip.linear(np.round(255 * srgb(np.clip(found, 0, 1))) / 255))
        bake = square(found, pictures["second"]) / 2 if "second" in pictures else 0
        rest = total - noise - rounding - bake
        print(f"  weight of a vertex > {least}, {mask.sum()} pixels: {root(total)} = noise of paths, at most {root(noise)}, "
              f"8-bit steps {root(rounding)}, noise of the bake {root(bake)}, rest, at least {root(rest)}; "
              f"mean {(found[mask].sum() / true[mask].sum() - 1):+.4f}")


def main():
    parser = ArgumentParser(__doc__)
    for name in ("bin", "vis", "light", "out"):
        parser.add_argument(name, type=pathlib.Path)
    parser.add_argument("--asset", type=pathlib.Path)
    parser.add_argument("--clip", help="default: the first clip")
    parser.add_argument("--frame", type=int, default=0)
    parser.add_argument("--albedo", default="0.6/0.5/0.4")
    parser.add_argument("--bounces", type=int, default=3, help="of the bake, or 0 to compare direct light alone")
    parser.add_argument("--size", type=int, default=256)
    parser.add_argument("--samples", type=int, default=256)
    parser.add_argument("--split", action="store_true")
    parser.add_argument("--second-bake", type=pathlib.Path)
    parser.add_argument("--yaw", type=float, default=30)
    parser.add_argument("--pitch", type=float, default=10)
    parser.add_argument("--zoom", type=float, default=1)
    arguments = parser.parse_args()
    out, size = arguments.out, arguments.size
    out.mkdir(parents=True, exist_ok=True)
    albedo = np.array([float(c) for c in arguments.albedo.split("/")])
    with h5py.File(arguments.light) as file:
        light = file["light/sh"][()]
    with h5py.File(arguments.vis) as vis:
        names = [n.decode() if isinstance(n, bytes) else n for n in vis["clips/names"][:]]
        clip = arguments.clip or names[0]
        frame = frame_of_file(arguments.vis, clip, arguments.frame)
        positions, triangles = vis["frames/positions"][frame].astype(np.float64), vis["mesh/triangles"][()]
        two_sided = vis.attrs.get("two_sided", 0)
        values = baked_radiance(vis, frame, light, albedo, arguments.bounces)
    camera = Camera(positions, arguments.yaw, arguments.pitch, arguments.zoom)
    exposure = 0.8 / np.percentile(values.max(1), 99.5)
    common = ["--size", f"{size}x{size}", "--camera", camera.text, "--exposure", f"{exposure:.6g}"]
    truth = out / "truth.png"

    def trace(samples, path):
        run(arguments.bin / "penumbra-bake", "reference", arguments.vis, "--frame", frame, "--brdf",
            f"lambert:color={arguments.albedo}", "--light", arguments.light, "--light-order", int(np.sqrt(len(light))),
            "--samples", samples, "-o", path,
            *(["--bounces", arguments.bounces, "--albedo", arguments.albedo] if arguments.bounces else []), *common)
        return np.asarray(Image.open(path).convert("RGBA"), float) / 255

    traced = trace(arguments.samples, truth)
    if two_sided:  # a back has triangles of its own
        triangles = facing(camera, positions, triangles)
    found, share, depth = draw(camera, positions, triangles, values, size)
    found, true = found * exposure, flip.linear(traced[..., :3])
    both = inner((traced[..., 3] > 0.999) & np.isfinite(found[..., 0])) & away_from_edges(depth, camera.scale / size)
    error = lambda mask: np.sqrt(((found - true)[mask] ** 2).sum() / (true[mask] ** 2).sum())
    near = both & (share > 0.95)
    print(f"{arguments.vis.name} {clip} {arguments.frame}: radiance of baked transfer, relative error {error(both):.4f} "
          f"over {both.sum()} pixels, {error(near):.4f} over the {near.sum()} at vertices")
    if arguments.split:
        pictures = {"found": found, "true": true, "both": both,
                    "quarter": flip.linear(trace(arguments.samples // 4, out / "quarter.png")[..., :3])}
        if arguments.second_bake:
            with h5py.File(arguments.second_bake) as second:
                again = baked_radiance(second, frame, light, albedo, arguments.bounces)
            pictures["second"] = draw(camera, positions, triangles, again, size)[0] * exposure
        print_split(pictures, share)
    if not arguments.asset:
        return
    pictures = {}
    for shown in ("direct", "both"):
        pictures[shown] = out / f"{shown}.png"
        run(arguments.bin / "penumbra-player", "render", arguments.asset, "--clip", clip, "--frame", arguments.frame,
            "--bounces", shown, "--path", "cpu", "-o", pictures[shown], *common)
        figures = compare(pictures[shown], truth, (0, 0, size, size))
        print(f"  {shown:6} light: FLIP {figures['flip']:.4f}, RMSE {figures['rmse']:.2f} / 255")
    sheet = Image.new("RGB", (3 * size, size))
    for i, path in enumerate((pictures["direct"], pictures["both"], truth)):
        sheet.paste(over_grey(path), (i * size, 0))
    sheet.quantize(256, method=Image.Quantize.MEDIANCUT, dither=Image.Dither.FLOYDSTEINBERG).save(out / "sheet.png",
                                                                                                optimize=True)


if __name__ == "__main__":
    main()
