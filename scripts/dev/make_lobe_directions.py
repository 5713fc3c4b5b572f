#!/usr/bin/python3
"""Prints the table of fit/light/fixed_lobe_directions.cpp as C++.

The table has 2n-1 directions for every order n with which each band's matrix of unit columns y_l(s) sqrt(4pi/(2l+1)) has
full rank and a small condition number. A random search from a fixed seed finds them in a minute or two. Order 4 is not
searched: tests/golden/zh_light_fit.json gives its seven."""
import json
import math
import pathlib

import numpy as np


def basis(order, directions):
    """Returns [directions, order^2], up to the sign of columns, on which conditions do not depend."""
    x, y, z = directions.T
    out = np.empty((len(directions), order * order))
    azimuth = x + 1j * y
    for m in range(order):
        start = math.prod(range(1, 2 * m, 2)) * azimuth**m
        before, legendre = np.zeros_like(z), np.ones_like(z)
        for l in range(m, order):
            if l > m:
                before, legendre = legendre, ((2 * l - 1) * z * legendre - (l + m - 1) * before) / (l - m)
            scale = math.sqrt((2 * l + 1) * math.factorial(l - m) / math.factorial(l + m) * (2 if m else 1))
            out[:, l * l + l + m] = scale * legendre * start.real
            if m:
                out[:, l * l + l - m] = scale * legendre * start.imag
    return out


def conditions(order, directions):
    y = basis(order, directions)
    values = [np.linalg.svd(y[:, l * l:(l + 1)**2], compute_uv=False) for l in range(order)]
    return [s[0] / max(s[-1], 1e-9) for s in values]


def search(order, random):
    best = (math.inf, None)
    for _ in range(4):
        directions = random.normal(size=(2 * order - 1, 3))
        directions /= np.linalg.norm(directions, axis=1, keepdims=True)
        value, step = max(conditions(order, directions)), 0.5
        for _ in range(6000):
            moved = directions + step * random.normal(size=directions.shape) * (random.random((len(directions), 1)) < 0.3)
            moved /= np.linalg.norm(moved, axis=1, keepdims=True)
            other = max(conditions(order, moved))
            if other < value:
                directions, value, step = moved, other, min(step * 1.5, 0.5)
            else:
                step = max(step * 0.985, 1e-3)
        best = min(best, (value, directions), key=lambda pair: pair[0])
    return best[1]


random = np.random.default_rng(1)
golden = pathlib.Path(__file__).parent.parent.parent / "tests/golden/zh_light_fit.json"
for order in range(1, 9):
    chosen = np.array(json.loads(golden.read_text())["exact7"]) if order == 4 else \
        np.array([[0.0, 0.0, 1.0]]) if order == 1 else search(order, random)
    print(f"// order {order}: condition {max(conditions(order, chosen)):.2f}")
    for x, y, z in chosen:
        print(f"{{{x:.17g}, {y:.17g}, {z:.17g}}},")
