"""A small bake whose visibility is known, for tests of what reads bakes."""
import json

import h5py
import numpy as np


def bake_file(path, clips=3, frames=12):
    """Makes a bake of two bones of a ribbon that bends. Its visibility of order 3 follows the angle, with a little
    noise."""
    random = np.random.default_rng(4)
    rows = 20
    y = np.repeat(np.linspace(0, 1, rows), 2)
    rest = np.stack([np.tile([-0.1, 0.1], rows), y, 0 * y], 1)
    quads = [[2 * r, 2 * r + 1, 2 * r + 2, 2 * r + 1, 2 * r + 3, 2 * r + 2] for r in range(rows - 1)]
    upper = y > 0.5
    count = clips * frames
    angle = 0.8 * np.sin(0.4 * np.arange(count)) + 0.1 * random.normal(size=count)
    bones = np.zeros((count, 2, 3, 4))
    bones[:, :, :3, :3] = np.eye(3)
    c, s = np.cos(angle), np.sin(angle)
    bones[:, 1, 1, 1] = bones[:, 1, 2, 2] = c
    bones[:, 1, 1, 2], bones[:, 1, 2, 1] = -s, s
    bones[:, 1, 1, 3], bones[:, 1, 2, 3] = 0.5 * (1 - c), -0.5 * s
    which = upper.astype(int)
    moved = bones[:, which]  # [F, V, 3, 4]
    positions = np.einsum("fvij,vj->fvi", moved[..., :3], rest) + moved[..., 3]
    normal = np.array([0, 0, 1.0])
    normals = moved[..., :3] @ normal
    moments = random.normal(size=(1, len(rest), 9)) + s[:, None, None] * random.normal(size=(1, len(rest), 9))
    moments *= 0.05  # about E = 1/2, so that E stays in (0, 1): half of the first two bands of an open hemisphere
    moments[..., 0] += 0.5 * np.sqrt(np.pi)
    moments[..., 1:4] += 0.5 * np.sqrt(3 * np.pi) / 2 * normals[..., [1, 2, 0]] * [-1, 1, -1]
    with h5py.File(path, "w") as f:
        f.attrs.update(dict(format="penumbra.visibility", format_version=1, sh_convention="real-orthonormal-cs",
                            sh_order=3, quantity="hemisphere_visibility", frame="model", rays=16, seed=1, bounces=0))
        f.attrs["provenance"] = json.dumps(dict(tool="test", version="0", options={}, inputs=[]))
        f["mesh/triangles"] = np.array(quads, "u4").reshape(-1, 3)
        f["mesh/rest_positions"] = rest.astype("f4")
        f["mesh/rest_normals"] = np.tile(normal, (len(rest), 1)).astype("f4")
        f["mesh/source_vertex"] = np.arange(len(rest), dtype="u4")
        f["skin/joint_names"] = np.array(["root", "tip"], h5py.string_dtype())
        f["skin/parents"] = np.array([-1, 0], "i4")
        f["skin/joints"] = which[:, None].astype("u2")
        f["skin/weights"] = np.ones((len(rest), 1), "f4")
        f["frames/positions"], f["frames/normals"] = positions.astype("f4"), normals.astype("f4")
        f["frames/clip"] = np.repeat(np.arange(clips), frames).astype("u2")
        f["frames/time"] = np.tile(np.arange(frames) / 3.0, clips)
        f["clips/names"] = np.array([f"clip{c}" for c in range(clips)], h5py.string_dtype())
        f["frames/bones"] = bones.astype("f4")
        f["frames/pose"] = np.pad(angle[:, None], [(0, 0), (3, 2)]).astype("f4")
        f["frames/pose"].attrs["parameterisation"] = "joint_rotation_vectors"
        f["visibility/coefficients"] = moments.astype("f4")
