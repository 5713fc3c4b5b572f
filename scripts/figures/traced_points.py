"""What counted rays say of points anywhere: each is a triangle that is too small to hide anything."""
import h5py
import numpy as np

from still_ground import call

TINY = 1e-5  # metres


def unit(v):
    return v / np.linalg.norm(v, axis=-1, keepdims=True)


def frames_of(normals):
    """Rows tangent, bitangent, normal [V, 3, 3]."""
    n = unit(normals)
    t = unit(np.cross(np.where(np.abs(n[:, :1]) < 0.7, [[1.0, 0, 0]], [[0, 1.0, 0]]), n))
    return np.stack([t, np.cross(n, t), n], 1)


def tiny_triangles(points, normals):
    """Corners [3 * points, 3]; the first of three is the point."""
    t, b = np.moveaxis(frames_of(normals)[:, :2], 1, 0)
    return np.stack([points, points + TINY * t, points + TINY * b], 1).reshape(-1, 3)


def baked(arguments, bake, receivers, faces, occluders, other_faces):
    """Normals and moments [F, V, 25] of the hemispheres of posed meshes [F, V, 3], made if `bake` is not there."""
    if not bake.exists():
        words = []
        for name, positions, triangles in (("own", receivers, faces), ("other", occluders, other_faces)):
            if positions is None:
                continue
            mesh = arguments.work / f"{name}.npz"
            np.savez(mesh, fps=np.float32(30), verts=np.float32(positions), faces=np.int32(triangles))
            words += ["--occluder", mesh] if words else [mesh]
        call(arguments, "penumbra-bake", "visibility", *words, "--rays", arguments.rays, "-o", bake)
    with h5py.File(bake) as f:
        of_source = f["mesh/source_vertex"][:]
        return [f[name][:].astype(float)[:, of_source] for name in ("frames/normals", "visibility/coefficients")]
