#!/usr/bin/python3
"""LDR-FLIP, the perceived difference of two pictures that one flips between: 0 = none, 1 = the largest.

flip.py REFERENCE.png TEST.png [--ppd 67] [--map MAP.png]     prints the mean

Andersson, Nilsson, Akenine-Moeller, Oskarsson, Astrom, Fairchild: FLIP: A Difference Evaluator for Alternating Images,
HPG 2020. Constants are the paper's; the default of 67 pixels a degree is a 0.7 m wide 4K display seen from 0.7 m.
Pictures are 8-bit sRGB; alpha is laid over the same grey in both."""
import pathlib
import sys

import numpy as np
from PIL import Image

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent))
from usage import ArgumentParser

XYZ_FROM_RGB = np.array([[10135552 / 24577794, 8788810 / 24577794, 4435075 / 24577794],
                         [2613072 / 12288897, 8788810 / 12288897, 887015 / 12288897],
                         [1425312 / 73733382, 8788810 / 73733382, 70074185 / 73733382]])  # linear sRGB, D65
WHITE = XYZ_FROM_RGB.sum(axis=1)
GREY = 60 / 255
QC, PC, PT, QF, FEATURE_WIDTH = 0.7, 0.4, 0.95, 0.5, 0.082
# Contrast sensitivity of achromatic, red-green and blue-yellow: Gaussians (a, b), a sqrt(pi/b) exp(-pi^2 d^2 / b).
SENSITIVITY = [[(1, 0.0047)], [(1, 0.0053)], [(34.1, 0.04), (13.5, 0.025)]]


def linear(srgb):
    return np.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4)


def opponent(rgb):
    """Converts linear RGB to YyCxCz."""
    x, y, z = np.moveaxis(rgb @ XYZ_FROM_RGB.T / WHITE, -1, 0)
    return np.stack([116 * y - 16, 500 * (x - y), 200 * (y - z)], axis=-1)


def from_opponent(ycc):
    y = (ycc[..., 0] + 16) / 116
    xyz = np.stack([ycc[..., 1] / 500 + y, y, y - ycc[..., 2] / 200], axis=-1) * WHITE
    return xyz @ np.linalg.inv(XYZ_FROM_RGB).T


def hunt_lab(rgb):
    """Converts linear RGB to CIELAB whose chroma is scaled by lightness (Hunt effect)."""
    t = rgb @ XYZ_FROM_RGB.T / WHITE
    f = np.where(t > (6 / 29) ** 3, np.cbrt(t), t / (3 * (6 / 29) ** 2) + 4 / 29)
    lightness = 116 * f[..., 1] - 16
    chroma = 0.01 * lightness[..., None] * np.stack([500 * (f[..., 0] - f[..., 1]), 200 * (f[..., 1] - f[..., 2])], -1)
    return np.concatenate([lightness[..., None], chroma], axis=-1)


def hyab(a, b):
    return np.abs(a[..., 0] - b[..., 0]) + np.linalg.norm(a[..., 1:] - b[..., 1:], axis=-1)


def convolve(plane, kernel, axis):
    """Convolves in one dimension, with repeated edges."""
    radius = len(kernel) // 2
    padded = np.pad(plane, [(radius, radius) if a == axis else (0, 0) for a in (0, 1)], mode="edge")
    size = plane.shape[axis]
    return sum(k * np.take(padded, range(i, i + size), axis=axis) for i, k in enumerate(kernel[::-1]))


def sensitivity_filtered(ycc, ppd):
    radius = int(np.ceil(3 * np.sqrt(max(b for lobes in SENSITIVITY for _, b in lobes) / (2 * np.pi ** 2)) * ppd))
    d = np.arange(-radius, radius + 1) / ppd
    planes = []
    for c, lobes in enumerate(SENSITIVITY):
        kernels = [(a * np.sqrt(np.pi / b), np.exp(-np.pi ** 2 * d ** 2 / b)) for a, b in lobes]
        total = sum(scale * g.sum() ** 2 for scale, g in kernels)
        planes.append(sum(scale / total * convolve(convolve(ycc[..., c], g, 0), g, 1) for scale, g in kernels))
    return np.stack(planes, axis=-1)


def features(lightness, ppd, point):
    """Returns the magnitude of edges, or of points."""
    deviation = 0.5 * FEATURE_WIDTH * ppd
    x = np.arange(-np.ceil(3 * deviation), np.ceil(3 * deviation) + 1)
    gaussian = np.exp(-x ** 2 / (2 * deviation ** 2))
    derivative = (x ** 2 / deviation ** 2 - 1) * gaussian if point else -x * gaussian
    smooth = gaussian / gaussian.sum()
    derivative = np.where(derivative < 0, derivative / -derivative[derivative < 0].sum(),
                          derivative / derivative[derivative > 0].sum())
    return np.hypot(*(convolve(convolve(lightness, derivative, axis), smooth, 1 - axis) for axis in (0, 1)))


def flip_map(reference, test, ppd=67.0):
    """Returns FLIP of every pixel. Pictures are sRGB in [0, 1], [height, width, 3]."""
    ycc = [opponent(linear(picture)) for picture in (reference, test)]
    lab = [hunt_lab(np.clip(from_opponent(sensitivity_filtered(image, ppd)), 0, 1)) for image in ycc]
    largest = hyab(*(hunt_lab(np.array(c, float)) for c in ([0, 1, 0], [0, 0, 1]))) ** QC
    color, knee = hyab(*lab) ** QC, PC * largest
    color = np.where(color < knee, PT / knee * color, PT + (color - knee) / (largest - knee) * (1 - PT))
    lightness = [(image[..., 0] + 16) / 116 for image in ycc]
    feature = np.maximum(*(np.abs(features(lightness[0], ppd, point) - features(lightness[1], ppd, point))
                           for point in (False, True)))
    return np.clip(color, 0, 1) ** (1 - np.clip(feature / np.sqrt(2), 0, 1) ** QF)


def read_srgb(path):
    picture = np.asarray(Image.open(path).convert("RGBA"), float) / 255
    return picture[..., :3] * picture[..., 3:] + GREY * (1 - picture[..., 3:])


def main():
    parser = ArgumentParser(__doc__)
    parser.add_argument("reference")
    parser.add_argument("test")
    parser.add_argument("--ppd", type=float, default=67.0, help="pixels a degree of the viewer's eye")
    parser.add_argument("--map", help="grey picture of the differences")
    arguments = parser.parse_args()
    reference, test = read_srgb(arguments.reference), read_srgb(arguments.test)
    if reference.shape != test.shape:
        sys.exit(f"flip: {arguments.reference} and {arguments.test} differ in size")
    values = flip_map(reference, test, arguments.ppd)
    if arguments.map:
        Image.fromarray((255 * values).round().astype(np.uint8)).save(arguments.map)
    print(f"{values.mean():.4f}")


if __name__ == "__main__":
    main()
