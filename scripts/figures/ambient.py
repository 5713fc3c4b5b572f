"""Ambient visibility of SH coefficients in the model frame: E = 1/pi integral of V max(n.s, 0) over the sphere."""
import numpy as np


def of_hemisphere(normals, moments):
    """E of hemisphere moments [..., n] of V around the normals [..., 3], by band 1. It is exact, because the moments
    are those of V above the horizon alone, where n.s needs no clamp."""
    x, y, z = np.moveaxis(normals, -1, 0)
    return 2 / np.sqrt(3 * np.pi) * (-x * moments[..., 3] - y * moments[..., 1] + z * moments[..., 2])


def of_mirrored(normals, coefficients):
    """E of the mirrored function [..., n], by bands 0, 2 and 4, which hold all but 0.3% of the cosine."""
    x, y, z = np.moveaxis(normals, -1, 0)
    z2 = z * z
    band2 = np.stack([1.0925484 * x * y, -1.0925484 * y * z, 0.3153916 * (3 * z2 - 1), -1.0925484 * x * z,
                      0.5462742 * (x * x - y * y)], -1)
    band4 = np.stack([2.5033430 * x * y * (x * x - y * y), -1.7701308 * y * z * (3 * x * x - y * y),
                      0.9461747 * x * y * (7 * z2 - 1), -0.6690466 * y * z * (7 * z2 - 3),
                      0.1057855 * (35 * z2 * z2 - 30 * z2 + 3), -0.6690466 * x * z * (7 * z2 - 3),
                      0.4730873 * (x * x - y * y) * (7 * z2 - 1), -1.7701308 * x * z * (x * x - 3 * y * y),
                      0.6258357 * (x * x * (x * x - 3 * y * y) - y * y * (3 * x * x - y * y))], -1)
    zonal = [np.sqrt(np.pi) / 2, np.sqrt(5 * np.pi) / 8, -np.sqrt(np.pi) / 16]  # |cos| / 2
    bands = [0.2820948 * coefficients[..., 0], (band2 * coefficients[..., 4:9]).sum(-1),
             (band4 * coefficients[..., 16:25]).sum(-1)]
    return sum(w * np.sqrt(4 * np.pi / (2 * l + 1)) * b for w, l, b in zip(zonal, (0, 2, 4), bands)) / np.pi
