"""What stands beside characters in pictures of scenes, made by formulas: a bench, a ball, a cloth that falls over the
ball, and a man of capsules who sits down. y up, metres."""
import pathlib
import sys

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent))
from samples.capsule_man import BODY, capsule_man
from samples.gltf import Gltf, primitive
from samples.shapes import compose, turn

BENCH = (1.3, 0.42, 0.46)  # metres: wide, high, deep; as high as the man of capsules sits
BALL_RADIUS = 0.35
SEAT = 0.56  # height of the hips' joint of the man who sits


def edges_with_rims(length, step, rim):
    """Places along an edge, with narrow strips at both ends, where the normals of a box turn."""
    inner = np.linspace(rim, length - rim, max(2, int(round((length - 2 * rim) / step)) + 1))
    return np.concatenate([[0], inner, [length]])


def box_grid(size, step=0.04, rim=0.012):
    """A box that stands on the ground, as (points, triangles), fine enough for shadows that are kept at its
    vertices."""
    points, triangles, count = [], [], 0
    for axis in range(3):
        across, along = (axis + 1) % 3, (axis + 2) % 3
        u, v = np.meshgrid(*(edges_with_rims(size[k], step, rim) for k in (across, along)), indexing="ij")
        corner = np.arange(u.size).reshape(u.shape)
        quads = np.stack([corner[:-1, :-1], corner[1:, :-1], corner[1:, 1:], corner[:-1, 1:]], -1).reshape(-1, 4)
        for high in (False, True):
            side = np.empty((u.size, 3))
            side[:, axis], side[:, across], side[:, along] = high * size[axis], u.ravel(), v.ravel()
            points.append(side - [size[0] / 2, 0, size[2] / 2])
            outward = quads if high else quads[:, ::-1]
            triangles.append(count + outward[:, [0, 1, 2, 0, 2, 3]].reshape(-1, 3))
            count += u.size
    return np.concatenate(points), np.concatenate(triangles)


def ball_grid(radius, rows=40):
    """A ball that stands on the ground, as (points, triangles)."""
    columns = 2 * rows
    polar, around = np.pi * np.arange(1, rows) / rows, 2 * np.pi * np.arange(columns) / columns
    ring = lambda a: np.stack([np.sin(a) * np.sin(around), np.full(columns, np.cos(a)), np.sin(a) * np.cos(around)], 1)
    points = np.concatenate([[[0, 1, 0]], *(ring(a) for a in polar), [[0, -1, 0]]]) * radius + [0, radius, 0]
    i, j = np.arange(columns), (np.arange(columns) + 1) % columns
    triangles, last = [np.stack([0 * i, 1 + i, 1 + j], 1)], 1 + (rows - 2) * columns
    for first in range(1, last, columns):
        below = first + columns
        triangles += [np.stack([first + i, below + i, below + j], 1), np.stack([first + i, below + j, first + j], 1)]
    triangles.append(np.stack([last + i, 0 * i + last + columns, last + j], 1))
    return points, np.concatenate(triangles)


def write_still(path, name, mesh):
    """Writes a mesh without skeleton or clips."""
    g = Gltf()
    g.node(name, mesh=g.mesh(primitive(g, *mesh)))
    g.save(path)


def write_sitting_man(path):
    """The man of capsules, of finer ones than the sample's, with one more clip, "sit": he sits down on a bench, leans
    forward and puts his hands on his knees."""
    g = capsule_man(around=24, along=27)
    node = {entry["name"]: i for i, entry in enumerate(g.json["nodes"]) if entry["name"] in BODY}
    t = np.linspace(0, 2, 21)
    down = np.sin(np.pi * np.minimum(t, 1) / 2) ** 2

    def joint(name, *turns):
        q = turn(turns[0][0], turns[0][1] * down)
        for axis, degrees in turns[1:]:
            q = compose(q, turn(axis, degrees * down))
        return node[name], "rotation", t, q

    channels = [joint("spine", ("x", 22)), joint("head", ("x", -8), ("y", 25))]
    for side, sign in (("L", 1), ("R", -1)):
        channels += [joint("thigh." + side, ("y", 14 * sign), ("x", -88)), joint("shin." + side, ("x", 84)),
                     joint("foot." + side, ("x", 4)),
                     joint("upper_arm." + side, ("y", -30 * sign), ("z", -62 * sign)),
                     joint("lower_arm." + side, ("y", -55 * sign))]
    low = np.stack([0 * t, 0.96 + (SEAT - 0.96) * down, 0 * t], 1)
    g.clip("sit", *channels, (node["hips"], "translation", t, low))
    g.save(path)


class Cloth:
    """A square of cloth by position-based dynamics (Mueller et al. 2007). Springs keep the lengths of threads, of the
    diagonals of squares, and of two squares in a row, which resists bending. The cloth does not meet itself."""

    def __init__(self, side, points, height):
        self.n, self.distance = points, side / (points - 1)
        x = np.linspace(-side / 2, side / 2, points)
        i, j = np.meshgrid(x, x, indexing="ij")
        # A small turn and slope, so that the folds of the corners differ.
        a = 0.3
        self.now = np.stack([i * np.cos(a) - j * np.sin(a), height + 0.02 * i, i * np.sin(a) + j * np.cos(a)], -1)
        self.before = self.now.copy()

    def springs(self):
        """Yields (di, dj, stiffness, start, step, along_i): springs between (i, j) and (i + di, j + dj). Those of one
        entry are on every step-th line from `start` on. They share no point, so they are solved at once."""
        for di, dj, stiffness in ((1, 0, 1), (0, 1, 1), (1, 1, 0.5), (1, -1, 0.5), (2, 0, 0.25), (0, 2, 0.25)):
            step = 2 * max(di, abs(dj))
            for start in range(step):
                yield di, dj, stiffness, start, step, di != 0

    def solve(self):
        n = self.n
        for di, dj, stiffness, start, step, along_i in self.springs():
            lines = np.arange(start, n - (di if along_i else abs(dj)), step)
            if along_i:
                low, high = max(0, -dj), n - max(0, dj)
                a, b = np.ix_(lines, np.arange(low, high)), np.ix_(lines + di, np.arange(low, high) + dj)
            else:
                a, b = np.ix_(np.arange(n), lines), np.ix_(np.arange(n), lines + dj)
            between = self.now[b] - self.now[a]
            length = np.linalg.norm(between, axis=-1, keepdims=True)
            rest = self.distance * np.hypot(di, dj)
            move = 0.5 * stiffness * (1 - rest / np.maximum(length, 1e-9)) * between
            self.now[a] += move
            self.now[b] -= move

    def collide(self, gap, rub):
        """Keeps the cloth `gap` away from ball and ground, where it rubs."""
        out = self.now - [0, BALL_RADIUS, 0]
        far = np.linalg.norm(out, axis=-1, keepdims=True)
        inside = far < BALL_RADIUS + gap
        self.now = np.where(inside, [0, BALL_RADIUS, 0] + out / far * (BALL_RADIUS + gap), self.now)
        low = self.now[..., 1:2] < gap
        self.now[..., 1] = np.maximum(self.now[..., 1], gap)
        self.before = np.where(inside | low, self.before + rub * (self.now - self.before), self.before)

    def step(self, seconds):
        velocity = 0.995 * (self.now - self.before)
        self.before = self.now
        self.now = self.now + velocity + [0, -9.81 * seconds**2, 0]
        for _ in range(10):
            self.solve()
        self.collide(gap=0.012, rub=0.5)


def write_draped_cloth(path, frames=72, fps=30, steps=5):
    """Writes a cloth of 1.25 m that falls over the ball from just above it, as a point cache."""
    cloth = Cloth(side=1.25, points=45, height=2 * BALL_RADIUS + 0.06)
    positions = []
    for _ in range(frames):
        positions.append(cloth.now.reshape(-1, 3).copy())
        for _ in range(steps):
            cloth.step(1 / (fps * steps))
    corner = (np.arange(cloth.n - 1)[:, None] * cloth.n + np.arange(cloth.n - 1)).ravel()
    a, b, c, d = corner, corner + 1, corner + cloth.n, corner + cloth.n + 1
    faces = np.concatenate([np.stack([a, b, d], 1), np.stack([a, d, c], 1)])
    np.savez_compressed(path, verts=np.array(positions, np.float32), faces=faces.astype(np.int32), fps=np.float32(fps))
