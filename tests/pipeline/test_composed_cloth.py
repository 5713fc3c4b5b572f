"""Cloth with a ball, as a composed model: the ball is exact, and the cloth's own folds are learned; bad input.

usage: test_composed_cloth.py BIN
"""
import json
import os
import sys
import tempfile

import h5py
import numpy as np

from programs import must, refused

BIN = sys.argv[1]
BAKE, FIT, PACK = (os.path.join(BIN, f"penumbra-{name}") for name in ("bake", "fit", "pack"))
FRAMES = 60


def grid_faces(across, along):
    corner = np.arange(across * along).reshape(along, across)
    a, b, c, d = corner[:-1, :-1], corner[:-1, 1:], corner[1:, :-1], corner[1:, 1:]
    return np.concatenate([np.stack([a, b, d], -1).reshape(-1, 3), np.stack([a, d, c], -1).reshape(-1, 3)])


def write_sheet(path):
    """A sheet of folds whose height rises and falls."""
    x, z = np.meshgrid(np.linspace(-1, 1, 17), np.linspace(-1, 1, 17))
    frames = []
    for f in range(FRAMES):
        height = (0.1 + 0.08 * np.sin(0.4 * f)) * np.cos(9 * x) + 0.05 * np.sin(0.23 * f) * np.sin(3 * z)
        frames.append(np.stack([x, height, z], -1).reshape(-1, 3))
    np.savez(path, verts=np.array(frames, "f4"), faces=grid_faces(17, 17), fps=30)


def ball_mesh(radius):
    """A ball of 12 x 24 quads, closed at its poles by repeated corners."""
    theta, phi = np.meshgrid(np.linspace(0, np.pi, 13), np.linspace(0, 2 * np.pi, 24, endpoint=False), indexing="ij")
    points = radius * np.stack([np.sin(theta) * np.cos(phi), np.cos(theta), np.sin(theta) * np.sin(phi)], -1)
    ring = np.arange(13 * 24).reshape(13, 24)
    a, b = ring[:-1], np.roll(ring[:-1], -1, 1)
    c, d = ring[1:], np.roll(ring[1:], -1, 1)
    faces = np.concatenate([np.stack([a, b, d], -1)[1:].reshape(-1, 3), np.stack([a, d, c], -1)[:-1].reshape(-1, 3)])
    return points.reshape(-1, 3), faces


def ball_centers():
    f = np.arange(FRAMES)
    return np.stack([0.8 * np.sin(0.11 * f), 0.55 + 0.1 * np.cos(0.3 * f), 0.6 * np.cos(0.17 * f)], -1)


def write_ball(path, centers, turn=0.0):
    points, faces = ball_mesh(0.25)
    points = points + [0.03, 0, 0]  # the table's point is not the middle of the mesh
    frames = []
    for f, center in enumerate(centers):
        c, s = np.cos(turn * f), np.sin(turn * f)
        frames.append(points @ np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]]) + center)
    np.savez(path, verts=np.array(frames, "f4"), faces=faces, fps=30)


def write_table(path, centers, name="ball"):
    with open(path, "w") as table:
        table.write(f"frame,{name}.x,{name}.y,{name}.z\n")
        for f, point in enumerate(centers.tolist()):
            table.write(",".join(map(str, [f, *point])) + "\n")


def make_inputs():
    write_sheet("sheet.npz")
    centers = ball_centers()
    write_ball("ball.npz", centers)
    write_ball("turning.npz", centers, turn=0.1)
    write_ball("still.npz", centers[:1])
    write_table("ball.csv", centers)
    write_table("other.csv", centers * 2)
    write_table("named.csv", centers, "sphere")


def bake(out, *words):
    must(BAKE, "visibility", "sheet.npz", "--two-sided", "--local", "--rays", 128, "--blocks", 4, "-o", out, *words)


def fit(vis, out, *words):
    must(FIT, "visibility", vis, "-o", out, "--holdout", "sheet#4", "--report", out + ".json", *words)
    with open(out + ".json") as report:
        return json.load(report)["figures"]


def check_fit():
    figures = fit("sheet.vis.h5", "composed.model.h5", "--model", "composed", "--fields", "ball.fields.h5")
    additive = fit("sheet.vis.h5", "additive.model.h5")
    composed, parts = figures["held_out"]["relative_error"], figures["composed"]
    print("held out: composed", composed, "additive", additive["held_out"]["relative_error"])
    # .30 and .68 were measured. With the true folds the ball leaves .08.
    assert composed < 0.5 * additive["held_out"]["relative_error"], (composed, additive)
    assert parts["true_local"]["held_out"]["relative_error"] < 0.12, parts
    with h5py.File("composed.model.h5") as model:
        joints = len(model["skin/joint_names"])
        assert model["parts/joint"][:].tolist() == [joints - 1], "the ball moves with its input"


def check_run_time():
    """The asset's evaluator and the fit's predictions agree."""
    must(PACK, "asset", "composed.model.h5", "--precision", "f32", "-o", "sheet.pnb")
    must(FIT, "predict", "composed.model.h5", "sheet.vis.h5", "-o", "prediction.vis.h5")
    must(PACK, "check", "sheet.pnb", "sheet.vis.h5", "--model", "composed.model.h5", "--report", "check.json")
    with open("check.json") as report:
        figures = json.load(report)["figures"]
    with open("composed.model.h5.json") as report:
        fitted = json.load(report)["figures"]["held_out"]["relative_error"]
    total = figures["held_out"]["relative_error"]
    assert abs(total - fitted) < 0.01, (total, fitted)


def check_info(fields, motion, joint, *composed):
    """penumbra-bake info tells how an occluder moves, in its fields, in a model with them and in its asset."""
    def info(path):
        must(BAKE, "info", path, "--report", "info.json")
        with open("info.json") as report:
            return json.load(report)["figures"]

    assert info(fields)["occluder"] == motion
    for path in composed:
        (name,) = info(path)["part_joints"]
        assert name.startswith(joint), (path, name)


def check_still():
    bake("still.vis.h5", "--occluder", "still.npz")
    must(BAKE, "fields", "still.npz", "--rays", 128, "-o", "still.fields.h5")
    figures = fit("still.vis.h5", "still.model.h5", "--model", "composed", "--fields", "still.fields.h5")
    assert figures["composed"]["true_local"]["held_out"]["relative_error"] < 0.2, figures
    with h5py.File("still.model.h5") as model:
        assert model["parts/joint"][:].tolist() == [65535]
    must(PACK, "asset", "still.model.h5", "--precision", "i8", "-o", "still.pnb")
    must(PACK, "check", "still.pnb", "still.vis.h5")


def check_bad_input():
    fields = [BAKE, "fields", "-o", "bad.fields.h5", "--rays", 16, "--cells", 4]
    refused(3, "turns or bends", *fields, "turning.npz", "--inputs", "ball.csv")
    refused(3, "moves with no point", *fields, "ball.npz", "--inputs", "other.csv")
    must(*fields, "ball.npz")
    composed = [FIT, "visibility", "sheet.vis.h5", "-o", "bad.model.h5", "--model", "composed", "--fields"]
    refused(1, "moves; its fields need inputs", *composed, "bad.fields.h5")
    must(*fields, "still.npz")
    refused(3, "is not an occluder that", *composed, "bad.fields.h5")
    must(*fields, "ball.npz", "--inputs", "named.csv")
    refused(3, "input 'sphere'", *composed, "bad.fields.h5")
    with h5py.File("bad.model.h5", "w") as broken, h5py.File("composed.model.h5") as model:
        for name in model:
            model.copy(name, broken)
        broken.attrs.update(model.attrs)
        broken["parts/joint"][0] = 4000
    refused(3, "/parts/joint", PACK, "asset", "bad.model.h5", "-o", "bad.pnb")


def main():
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        make_inputs()
        bake("sheet.vis.h5", "--occluder", "ball.npz", "--inputs", "ball.csv")
        must(BAKE, "fields", "ball.npz", "--inputs", "ball.csv", "-o", "ball.fields.h5")
        check_fit()
        check_run_time()
        check_info("ball.fields.h5", "follows ball", "ball", "composed.model.h5", "sheet.pnb")
        check_still()
        check_info("still.fields.h5", "stands still", "(still)", "still.model.h5", "still.pnb")
        check_bad_input()


if __name__ == "__main__":
    main()
