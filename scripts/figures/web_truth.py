#!/usr/bin/python3
"""Writes the ray-traced truth of one clip as small as a web page wants it (runtime/web/demo).

The moments of a bake of order 5 say exactly what the transfer of order 4 is: the integrals of visibility times cosine
times y_i. OUT is the gzip of a u32 (the length of what follows), a JSON text {clip, times [F] in seconds, vertices,
order, scales [16]} and bytes [16, vertices, F]. Vertices are those of the source file, in its order. A number is its
byte times the scale of its coefficient, where the bytes of a vertex are sums of the differences from frame to frame,
modulo 256 and as signed numbers."""
import gzip
import json
import pathlib
import struct
import sys

import h5py
import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent))
from spherical_harmonics import basis, sphere_grid
from usage import ArgumentParser

ORDER = 4


def cosine_products():
    """Returns [16, 3, 25]: integrals of y_i y_j times the x, y and z of the direction, by an exact quadrature."""
    directions, weights = sphere_grid(8, 16)
    y = basis(5, directions)
    return np.einsum("s,si,sx,sj->ixj", weights, y[:, :ORDER**2], directions, y)


def transfer_of(bake, frame, products):
    moments = bake["visibility/coefficients"][frame].astype(float)
    normals = bake["frames/normals"][frame].astype(float)
    if moments.shape[1] < 25:
        raise SystemExit("web_truth.py: the bake must have order 5")
    return np.einsum("vx,ixj,vj->vi", normals, products, moments[:, :25])


def main():
    parser = ArgumentParser(description=__doc__)
    parser.add_argument("bake", help="X.vis.h5 of order 5")
    parser.add_argument("-o", "--output", required=True)
    parser.add_argument("--clip", required=True)
    parser.add_argument("--every", type=int, default=2, help="keep one frame of so many (default 2)")
    args = parser.parse_args()
    with h5py.File(args.bake) as bake:
        names = [n.decode() if isinstance(n, bytes) else n for n in bake["clips/names"][:]]
        if args.clip not in names:
            raise SystemExit(f"web_truth.py: {args.bake} has no clip '{args.clip}'")
        frames = np.flatnonzero(bake["frames/clip"][:] == names.index(args.clip))[::args.every]
        times = bake["frames/time"][:][frames]
        source = bake["mesh/source_vertex"][:]
        products = cosine_products()
        transfer = np.stack([transfer_of(bake, int(f), products) for f in frames])[:, source]  # [F, vertices, 16]
    scales = np.abs(transfer).max((0, 1)) / 127
    numbers = np.rint(transfer / scales).astype(np.int16)
    numbers[1:] -= numbers[:-1].copy()
    about = json.dumps({"clip": args.clip, "times": (times - times[0]).round(6).tolist(), "vertices": len(source),
                        "order": ORDER, "scales": scales.tolist()}).encode()
    body = numbers.astype(np.int8).transpose(2, 1, 0).tobytes()
    with open(args.output, "wb") as file:
        file.write(gzip.compress(struct.pack("<I", len(about)) + about + body, 9, mtime=0))


if __name__ == "__main__":
    main()
