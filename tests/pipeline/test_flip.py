# scripts/figures/flip.py: what must hold of FLIP by its definition.
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "scripts" / "figures"))
import flip  # noqa: E402


def flat(r, g, b):
    return np.broadcast_to(np.array([r, g, b], float), (48, 48, 3))


random = np.random.default_rng(3).random((48, 48, 3))
brighter = np.clip(random + 0.05, 0, 1)
assert flip.flip_map(random, random).max() == 0
assert np.array_equal(flip.flip_map(random, brighter), flip.flip_map(brighter, random))
# The scale ends at green against blue. Between flat pictures there are no features, so it is colour alone.
assert np.allclose(flip.flip_map(flat(0, 1, 0), flat(0, 0, 1)), 1)
steps = [flip.flip_map(flat(0.5, 0.5, 0.5), flat(g, g, g)).mean() for g in (0.5, 0.52, 0.6, 0.8, 1)]
assert steps[0] == 0 and all(a < b for a, b in zip(steps, steps[1:])), steps
# A flat pair has a closed form: |L1 - L2|^0.7 on the lower piece of the scale (grey has no chroma).
lightness = [116 * np.cbrt(flip.linear(np.array(g))) - 16 for g in (0.5, 0.52)]
largest = flip.hyab(flip.hunt_lab(np.array([0, 1.0, 0])), flip.hunt_lab(np.array([0, 0, 1.0]))) ** 0.7
assert np.isclose(steps[1], abs(lightness[1] - lightness[0]) ** 0.7 * 0.95 / (0.4 * largest), rtol=1e-6)
# Tables of the primaries of sRGB have these CIELAB colours under D65. The script scales their chroma by L / 100.
for rgb, (lightness, a, b) in (([0, 1, 0], (87.735, -86.183, 83.179)), ([0, 0, 1], (32.297, 79.188, -107.860))):
    expected = [lightness, lightness / 100 * a, lightness / 100 * b]
    assert np.allclose(flip.hunt_lab(np.array(rgb, float)), expected, rtol=3e-4), (rgb, expected)
# A thin line is seen, and less so from farther away (more pixels a degree).
line = flat(0.5, 0.5, 0.5).copy()
line[:, 24] = 0.9
near, far = (flip.flip_map(flat(0.5, 0.5, 0.5), line, ppd).max() for ppd in (30, 120))
assert 0 < far < near, (far, near)
print("flip: ok")
