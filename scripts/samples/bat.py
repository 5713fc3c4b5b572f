"""A bat: a body, and two wings that are thin sheets and flap. No bat of DirectX with a free licence was at hand."""
import numpy as np

from samples.text_formats import Bones

SPAN, WRIST = 0.9, 0.42  # metres from the middle to the tip and to the wrist
RIGHT = 1


def body(around=16, rings=9):
    """Returns points and triangles of an ellipsoid along z, closed."""
    points = [[0, 0, -0.22]]
    for i in range(1, rings):
        t = np.pi * i / rings
        for a in 2 * np.pi * np.arange(around) / around:
            points.append([0.07 * np.sin(t) * np.cos(a), 0.07 * np.sin(t) * np.sin(a), -0.22 * np.cos(t)])
    points.append([0, 0, 0.22])
    ring = lambda i, a: 1 + (i - 1) * around + a % around
    last = len(points) - 1
    triangles = []
    for a in range(around):
        triangles.append([0, ring(1, a + 1), ring(1, a)])
        triangles.append([last, ring(rings - 1, a), ring(rings - 1, a + 1)])
        for i in range(1, rings - 1):
            triangles += [[ring(i, a), ring(i, a + 1), ring(i + 1, a + 1)], [ring(i, a), ring(i + 1, a + 1), ring(i + 1, a)]]
    return np.array(points), np.array(triangles)


def wing(side, columns=19, rows=9):
    """Returns points and triangles of a wing whose upper side is its front; its trailing edge has three bays."""
    u, v = np.meshgrid(np.linspace(0, 1, columns), np.linspace(0, 1, rows), indexing="ij")
    x = 0.05 + (SPAN - 0.05) * u
    front = 0.16 - 0.1 * u**2 + 0.06 * np.sin(np.pi * u)
    back = -0.16 + 0.18 * u**3 + 0.06 * np.abs(np.sin(3 * np.pi * u))
    z = front + (back - front) * v
    y = 0.03 * np.sin(np.pi * v) * (1 - u)
    points = np.stack([side * x, y, z], 2).reshape(-1, 3)
    i, j = np.meshgrid(np.arange(columns - 1), np.arange(rows - 1), indexing="ij")
    corner = (i * rows + j).ravel()
    triangles = np.concatenate(
        [np.stack([corner, corner + rows, corner + 1], 1), np.stack([corner + 1, corner + rows, corner + rows + 1], 1)]
    )
    return points, triangles if side == RIGHT else triangles[:, ::-1]


def turned(angle, place):
    """Returns a turn about z, then a move."""
    m = np.eye(4)
    c, s = np.cos(angle), np.sin(angle)
    m[:2, :2] = [[c, -s], [s, c]]
    m[:3, 3] = place
    return m


def bat(frames=37, seconds=3.0):
    names = ["body", "arm_right", "hand_right", "arm_left", "hand_left"]
    parents = [-1, 0, 1, 0, 3]
    places = [np.zeros(3)] + [np.array([side * x, 0, 0]) for side in (1, -1) for x in (0.05, WRIST - 0.05)]
    points, triangles = body()
    weights = np.zeros((len(points), 5))
    weights[:, 0] = 1
    for side, arm in ((RIGHT, 1), (-1, 3)):
        more, faces = wing(side)
        triangles = np.concatenate([triangles, faces + len(points)])
        points = np.concatenate([points, more])
        of_wing = np.zeros((len(more), 5))
        hand = np.clip((np.abs(more[:, 0]) - WRIST) / 0.16 + 0.5, 0, 1)
        root = np.clip(1 - (np.abs(more[:, 0]) - 0.05) / 0.06, 0, 1)
        of_wing[:, 0], of_wing[:, arm], of_wing[:, arm + 1] = root, (1 - root) * (1 - hand), hand * (1 - root)
        weights = np.concatenate([weights, of_wing])
    times = np.linspace(0, seconds, frames)
    # Strokes grow from a glide to a full beat; the hands lag behind the arms.
    size = np.radians(15 + 40 * times / seconds)
    beat, lag = np.sin(2 * np.pi * times), np.sin(2 * np.pi * times - 1.1)
    local = [[turned(0, [0, -0.05 * b, 0]) for b in beat]]
    for side, first in ((1, 1), (-1, 3)):
        local.append([turned(side * s * b, places[first]) for s, b in zip(size, beat)])
        local.append([turned(side * 0.9 * s * b, places[first + 1]) for s, b in zip(size, lag)])
    rest = [turned(0, place) for place in places]
    return Bones(points, triangles, weights, names, parents, times, local, rest)
