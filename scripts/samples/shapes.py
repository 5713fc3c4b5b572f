"""Surfaces, rotations and weights of the samples. y up, metres; triangles run counter-clockwise seen from outside."""
import numpy as np


def capsule(start, end, radius, around=12, along=9):
    """Closed surface of the points at `radius` from the segment; outward triangles. Also each vertex' place on the
    segment in metres from `start` (negative and beyond the end on the caps)."""
    start, end = np.asarray(start, float), np.asarray(end, float)
    length = np.linalg.norm(end - start)
    axis = (end - start) / length
    side = np.cross(axis, [0, 0, 1] if abs(axis[2]) < 0.9 else [1, 0, 0])
    side /= np.linalg.norm(side)
    other = np.cross(axis, side)
    caps = along // 3  # rings on either cap, the rest on the straight part
    cap = np.arange(1, caps + 1) / (caps + 0.5) * np.pi / 2
    rings = [(-radius * np.cos(a), radius * np.sin(a)) for a in cap]
    rings += [(t, radius) for t in np.linspace(0, length, along - 2 * caps + 2)[1:-1]]
    rings += [(length + radius * np.cos(a), radius * np.sin(a)) for a in cap[::-1]]
    angle = 2 * np.pi * np.arange(around) / around
    circle = np.cos(angle)[:, None] * side + np.sin(angle)[:, None] * other
    points, places = [start - radius * axis], [-radius]
    for place, r in rings:
        points += list(start + place * axis + r * circle)
        places += [place] * around
    points.append(end + radius * axis)
    places.append(length + radius)
    return np.array(points), closed_tube(len(rings), around), np.array(places)


def closed_tube(rings, around):
    """Returns the triangles of a pole, `rings` of `around` vertices, and a pole."""
    triangles = []
    for i in range(around):
        j = (i + 1) % around
        triangles.append((0, 1 + j, 1 + i))
        for r in range(rings - 1):
            a, b = 1 + r * around, 1 + (r + 1) * around
            triangles += [(a + i, a + j, b + j), (a + i, b + j, b + i)]
        last = 1 + (rings - 1) * around
        triangles.append((last + i, last + j, last + around))
    return np.array(triangles, np.uint16)


def tube(height, radius, rings, around):
    """Makes a tube along +y from y = 0, closed by flat ends."""
    angle = 2 * np.pi * np.arange(around) / around
    circle = radius * np.stack([np.sin(angle), 0 * angle, np.cos(angle)], 1)
    heights = np.linspace(0, height, rings)
    points = np.concatenate([[[0, 0, 0]]] + [circle + [0, y, 0] for y in heights] + [[[0, height, 0]]])
    return points, closed_tube(rings, around)


def box(size):
    corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) * np.asarray(size) / 2
    faces = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    return corners, np.array([t for a, b, c, d in faces for t in ((a, b, c), (a, c, d))], np.uint16)


def turn(axis, degrees):
    """Returns quaternions x y z w about a coordinate axis, one for each angle."""
    half = np.radians(np.atleast_1d(np.asarray(degrees, float))) / 2
    q = np.zeros((len(half), 4))
    q[:, "xyz".index(axis)] = np.sin(half)
    q[:, 3] = np.cos(half)
    return q


def rotation(axis, degrees):
    """Returns a 4x4 matrix about a coordinate axis."""
    i = "xyz".index(axis)
    j, k = (i + 1) % 3, (i + 2) % 3
    m, a = np.eye(4), np.radians(degrees)
    m[j, j] = m[k, k] = np.cos(a)
    m[j, k], m[k, j] = -np.sin(a), np.sin(a)
    return m


def compose(a, b):
    """Multiplies quaternions a b, row by row."""
    v = a[:, 3:] * b[:, :3] + b[:, 3:] * a[:, :3] + np.cross(a[:, :3], b[:, :3])
    return np.hstack([v, a[:, 3:] * b[:, 3:] - (a[:, :3] * b[:, :3]).sum(1, keepdims=True)])


def translation_to(points):
    """Returns inverse bind matrices of joints that stand at `points` without rotation."""
    m = np.tile(np.eye(4), (len(points), 1, 1))
    m[:, :3, 3] = -np.asarray(points, float)
    return m


def two_bone_weights(points, bend_at=0.5, half_width=0.15):
    upper = np.clip((points[:, 1] - bend_at) / (2 * half_width) + 0.5, 0, 1)
    zero = np.zeros_like(upper)
    return np.tile([0, 1, 0, 0], (len(points), 1)), np.stack([1 - upper, upper, zero, zero], 1)
