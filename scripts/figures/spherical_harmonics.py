"""Real spherical harmonics, orthonormal and with the Condon-Shortley sign, as sh/sh_basis.h has them, and grids to sum by."""
from math import factorial

import numpy as np


def basis(order, directions):
    """Values [..., order^2] at unit directions [..., 3]."""
    x, y, z = np.moveaxis(np.asarray(directions, float), -1, 0)
    out = np.empty(x.shape + (order * order,))
    around = np.ones_like(x, dtype=complex)  # (x + i y)^m
    first = np.ones_like(x)                  # P_m^m / sin^m
    for m in range(order):
        below, here = np.zeros_like(x), first
        for l in range(m, order):
            scale = np.sqrt((2 * l + 1) / (4 * np.pi) * factorial(l - m) / factorial(l + m)) * (np.sqrt(2) if m else 1)
            out[..., l * (l + 1) + m] = scale * here * around.real
            if m:
                out[..., l * (l + 1) - m] = scale * here * around.imag
            below, here = here, ((2 * l + 1) * z * here - (l + m) * below) / (l + 1 - m)
        around = around * (x + 1j * y)
        first = -(2 * m + 1) * first
    return out


def sphere_grid(rings, around, hemisphere=False):
    """Directions [rings * around, 3] and weights, exact for polynomials of degree 2 rings - 1 and around - 1."""
    z, weight = np.polynomial.legendre.leggauss(rings)
    if hemisphere:
        z, weight = (z + 1) / 2, weight / 2
    angle = 2 * np.pi * np.arange(around) / around
    sine = np.sqrt(1 - z * z)
    s = np.stack([np.outer(sine, np.cos(angle)), np.outer(sine, np.sin(angle)), np.outer(z, np.ones(around))], -1)
    return s.reshape(-1, 3), np.repeat(weight * 2 * np.pi / around, around)
