#!/usr/bin/python3
"""Writes a synthetic sky as Radiance HDR: blue dome, grey ground, one warm sun. Ours, no third-party content.

make_sky.py OUT.hdr [WIDTH]"""
import sys

import numpy as np


def sky(width):
    """Returns radiance [height, width, 3] of a lat-long picture: y up, middle of the picture +x, growing u towards
    +z."""
    height = width // 2
    theta = np.pi * (np.arange(height) + 0.5) / height
    phi = 2 * np.pi * ((np.arange(width) + 0.5) / width - 0.5)
    t, p = np.meshgrid(theta, phi, indexing="ij")
    direction = np.stack([np.sin(t) * np.cos(p), np.cos(t), np.sin(t) * np.sin(p)], -1)
    up = direction[..., 1:2]
    dome = np.where(up > 0, 0.25 + 0.35 * (1 - up), 0.12) * np.array([0.75, 0.9, 1.2])
    sun = np.array([0.5, 0.7, 0.5])
    sun /= np.linalg.norm(sun)
    return dome + 12 * np.exp(-((1 - direction @ sun) / 0.03) ** 2)[..., None] * np.array([1.1, 1.0, 0.8])


def write_rgbe(path, radiance):
    """Encodes uncompressed RGBE: value = (byte + 0.5) / 256 * 2^(exponent - 128) (Ward, Graphics Gems II)."""
    largest = np.maximum(radiance.max(-1), 1e-38)
    mantissa, exponent = np.frexp(largest)
    rgb = radiance * (mantissa * 256 / largest)[..., None]
    pixels = np.concatenate([rgb, (exponent + 128)[..., None]], -1).astype(np.uint8)
    height, width = largest.shape
    with open(path, "wb") as out:
        out.write(b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n" + f"-Y {height} +X {width}\n".encode() + pixels.tobytes())


if __name__ == "__main__":
    if len(sys.argv) not in (2, 3):
        sys.exit(__doc__)
    write_rgbe(sys.argv[1], sky(int(sys.argv[2]) if len(sys.argv) == 3 else 256))
