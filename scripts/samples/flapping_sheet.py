"""A sheet that flaps, as point caches of NumPy: the same frames as tests/formats/flapping_sheet.h has by formula."""
import os

import numpy as np

from samples.gltf import Gltf, primitive

COLUMNS, ROWS, FRAMES = 7, 5, 13
SEAM, SLIT = 3, 5  # columns whose vertices are there twice: the seam's stay together, the slit's part


def sheet():
    """Returns positions [13,45,3] (metres, y up) and quads [24,4]."""
    place = [(i, j) for j in range(ROWS) for i in range(COLUMNS)]
    place += [(column, j) for column in (SEAM, SLIT) for j in range(ROWS)]
    i, j = np.array(place, float).T
    u, v = i / (COLUMNS - 1), j / (ROWS - 1)
    phase = np.arange(FRAMES)[:, None] / (FRAMES - 1)
    opening = np.where(np.arange(len(place)) >= ROWS * (COLUMNS + 1), 0.05, 0.0)
    z = 0.3 * u * np.sin(2 * np.pi * phase + 3 * u + v) + opening * phase
    verts = np.stack([np.broadcast_to(1.2 * u, z.shape), np.broadcast_to(v, z.shape), z], 2)

    def vertex(column, row, side):  # side 1: of the quad to the right
        if side == 1 and column in (SEAM, SLIT):
            return ROWS * (COLUMNS + (SEAM, SLIT).index(column)) + row
        return row * COLUMNS + column

    quads = [
        (vertex(c, r, 1), vertex(c + 1, r, 0), vertex(c + 1, r + 1, 0), vertex(c, r + 1, 1))
        for r in range(ROWS - 1)
        for c in range(COLUMNS - 1)
    ]
    return verts, np.array(quads, np.int32)


def write_sheets(folder):
    verts, quads = sheet()
    triangles = quads[:, [0, 1, 2, 0, 2, 3]].reshape(-1, 3)
    path = lambda name: os.path.join(folder, name)
    np.savez_compressed(path("sheet.npz"), verts=verts.astype(np.float32), faces=quads, fps=np.float32(12), note="x")
    np.savez(path("sheet_f64.npz"), verts=verts.astype(">f8"), faces=triangles.astype(np.int64), rest=verts[6])
    low = verts.min()
    step = (verts.max() - low) / 65535
    quantised = np.round((verts - low) / step).astype(np.uint16)
    times = np.arange(FRAMES) ** 2 / 144
    np.savez_compressed(
        path("sheet_q.npz"), verts_q=quantised, q_lo=low, q_step=step, faces=triangles.astype(np.uint32), times=times
    )
    z_up_cm = np.stack([verts[..., 0], -verts[..., 2], verts[..., 1]], 2) * 100
    np.save(path("sheet_z_cm.npy"), z_up_cm)
    np.save(path("sheet_faces.npy"), quads)
    sheet_morph().save(path("sheet_morph.glb"))


def sheet_morph():
    """The frames as morph targets of a node that turns and moves: "flap", and "lift", which also lifts the node by 1 m.

    Every other target is sparse. Clip "lift" goes from the first frame to the last, both with flat splines."""
    verts, quads = sheet()
    triangles = quads[:, [0, 1, 2, 0, 2, 3]]
    # before scale 2, 90 degrees about y, shift
    own = np.stack([-verts[..., 2], verts[..., 1] - 0.25, verts[..., 0]], 2) / 2
    own = own.astype(np.float32)
    g = Gltf()
    shape = primitive(g, own[0], triangles)
    rows = np.flatnonzero(np.any(own != own[0], axis=(0, 2)))
    shape["targets"] = [
        {"POSITION": g.accessor(d) if f % 2 else g.sparse_accessor(None, rows, d[rows])}
        for f, d in enumerate(own[1:] - own[0])
    ]
    holder = g.node("holder", scale=[2, 2, 2])
    half = float(np.sqrt(0.5))
    node = g.node("sheet", holder, mesh=g.mesh(shape), translation=[0, 0.125, 0], rotation=[0, half, 0, half])
    one_hot = np.eye(FRAMES)[:, 1:]
    g.clip("flap", (node, "weights", np.arange(FRAMES) / 12, one_hot.reshape(-1)))
    flat = np.zeros((2, 3, FRAMES - 1))
    flat[:, 1] = one_hot[[0, -1]]
    g.clip(
        "lift",
        (node, "weights", [0, 1], flat.reshape(-1), "CUBICSPLINE"),
        (node, "translation", [0, 1], np.array([[0, 0.125, 0], [0, 0.625, 0]])),
    )
    return g
