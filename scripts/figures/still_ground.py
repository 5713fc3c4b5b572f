"""A square of points of a ground under a character: what counted rays and penumbra-player probe say of them."""
import csv
import json
import subprocess
import sys

import h5py
import numpy as np

import ambient


def call(arguments, program, *words):
    command = [f"{arguments.bin}/{program}", *map(str, words), "-q"]
    if subprocess.run(command).returncode != 0:
        sys.exit(" ".join(command))


def clip_names(f, bake, clips):
    """The names of all clips of an open bake, which must have `clips`."""
    names = [name.decode() for name in f["clips/names"][:]]
    for clip in clips:
        if clip not in names:
            sys.exit(f"{bake}: no clip {clip}; it has {', '.join(names)}")
    return names


def grid(side, half, middle, height):
    """side x side points [side^2, 3] of a horizontal square."""
    xs = np.linspace(-half, half, side)
    x, z = np.meshgrid(xs, xs, indexing="ij")
    return np.stack([middle[0] + x.ravel(), np.full(side * side, height), middle[2] + z.ravel()], 1)


def grid_faces(side):
    corners = np.arange(side * side).reshape(side, side)
    a, b, c, d = (corners[i:side - 1 + i, j:side - 1 + j].ravel() for i, j in ((0, 0), (0, 1), (1, 0), (1, 1)))
    return np.concatenate([np.stack([a, b, c], 1), np.stack([b, d, c], 1)]).astype(np.int32)


def true_ambient(arguments, bake, side, grounds, positions, triangles):
    """E [F, points] of a ground a frame by counted rays, with the posed character as occluder. `bake` is made if it is not
    there."""
    if not bake.exists():
        mesh, occluder = arguments.work / "ground.npz", arguments.work / "occluder.npz"
        np.savez(mesh, fps=np.float32(30), verts=np.float32(grounds), faces=grid_faces(side))
        np.savez(occluder, fps=np.float32(30), verts=np.float32(positions), faces=triangles.astype(np.int32))
        call(arguments, "penumbra-bake", "visibility", mesh, "--occluder", occluder, "--rays", arguments.rays, "-o", bake)
    with h5py.File(bake) as f:
        n, v = f["frames/normals"][:].astype(float), f["visibility/coefficients"][:].astype(float)
    return ambient.of_hemisphere(n, v)


def probed(arguments, character, points, normals, columns, cast="product"):
    """Columns [points, columns] of what penumbra-player probe says of points beside one character of a scene."""
    scene, listed, out = (arguments.work / name for name in ("scene.json", "points.csv", "probe.csv"))
    scene.write_text(json.dumps({"version": 1, "characters": [character]}))
    rows = np.concatenate([points, np.broadcast_to(normals, points.shape)], 1)
    listed.write_text("x,y,z,nx,ny,nz\n" + "".join("%.9g,%.9g,%.9g,%.9g,%.9g,%.9g\n" % tuple(row) for row in rows))
    call(arguments, "penumbra-player", "probe", scene, "--points", listed, "-o", out, "--cast", cast)
    with open(out) as f:
        return np.array([[float(row[column]) for column in columns] for row in csv.DictReader(f)])


def character_of(asset, clip, seconds, casts=None):
    """A character of a scene; `casts` as there, None for what the asset casts by of itself."""
    character = {"asset": str(asset.resolve()), "clip": clip, "time": seconds}
    return character | {"casts": casts} if casts else character


def probed_ambient(arguments, asset, ground, clip, seconds, casts=None):
    """E [points] of the ground under the asset at a time of a clip."""
    return probed(arguments, character_of(asset, clip, seconds, casts), ground, [0, 1, 0], ["E"])[:, 0]
