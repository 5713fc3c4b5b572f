# Other people's tools: h5py reads what a bake writes, under the published names; and what h5py writes (its own older file
# version, text of variable length, gzip) our programs read.
# Usage: test_h5py.py BIN_FOLDER
import json
import subprocess
import sys
import tempfile
from pathlib import Path

import h5py
import numpy as np

BIN = Path(sys.argv[1]).resolve()
ROOT = Path(__file__).resolve().parents[2]

DATASETS = {  # name: (type, axes)
    "/mesh/triangles": ("uint32", "T3"),
    "/mesh/rest_positions": ("float32", "V3"),
    "/mesh/rest_normals": ("float32", "V3"),
    "/mesh/source_vertex": ("uint32", "R"),
    "/mesh/slot_of_vertex": ("uint16", "V"),
    "/skin/parents": ("int32", "J"),
    "/skin/joints": ("uint16", "VK"),
    "/skin/weights": ("float32", "VK"),
    "/frames/positions": ("float32", "FV3"),
    "/frames/normals": ("float32", "FV3"),
    "/frames/clip": ("uint16", "F"),
    "/frames/time": ("float64", "F"),
    "/frames/bones": ("float32", "FJ34"),
    "/frames/pose": ("float32", "FP"),
    "/visibility/coefficients": (None, "FVN"),
}


def run(*arguments):
    result = subprocess.run([str(a) for a in arguments], capture_output=True, text=True, timeout=300)
    assert result.returncode == 0, (arguments, result.stderr)
    return result


def check_layout(path, coefficient_type):
    with h5py.File(path) as file:
        attributes = dict(file.attrs)
        assert attributes["format"] == "penumbra.visibility" and attributes["format_version"] == 1
        assert attributes["sh_convention"] == "real-orthonormal-cs" and attributes["sh_order"] == 3
        assert attributes["quantity"] == "hemisphere_visibility" and attributes["frame"] == "model"
        assert attributes["rays"] == 32 and attributes["seed"] == 5 and attributes["bounces"] == 0
        provenance = json.loads(attributes["provenance"])
        assert provenance["tool"] == "penumbra-bake visibility" and len(provenance["inputs"][0]["sha256"]) == 64
        size = {"3": 3, "4": 4, "N": 9}
        for name, (kind, axes) in DATASETS.items():
            data = file[name]
            assert data.dtype == (kind or coefficient_type), (name, data.dtype)
            assert len(data.shape) == len(axes), (name, data.shape)
            for axis, length in zip(axes, data.shape):
                assert size.setdefault(axis, length) == length, (name, axis, length)
            assert np.isfinite(data[...]).all(), name
        assert file["/skin/joint_names"].shape == (size["J"],) and len(file["/clips/names"].asstr()[...]) == 3
        assert file["/frames/pose"].attrs["parameterisation"] == "joint_rotation_vectors"
        assert np.allclose(file["/skin/weights"][...].sum(axis=1), 1, atol=1e-6)
        # Skinning by the stored matrices gives the stored positions.
        joints, weights = file["/skin/joints"][...], file["/skin/weights"][...]
        matrices = (file["/frames/bones"][1][joints] * weights[:, :, None, None]).sum(axis=1)
        rest = np.c_[file["/mesh/rest_positions"][...], np.ones(size["V"])]
        assert np.abs(np.einsum("vij,vj->vi", matrices, rest) - file["/frames/positions"][1]).max() < 1e-6
        return file["/visibility/coefficients"][...]


def copy_as_h5py_does(source, target):
    with h5py.File(source) as file, h5py.File(target, "w") as out:
        for key, value in file.attrs.items():
            out.attrs[key] = value

        def copy(name, item):
            if not isinstance(item, h5py.Dataset):
                return
            text = item.dtype.kind == "S"
            data = list(item.asstr()[...]) if text else item[...]
            options = {"dtype": h5py.string_dtype()} if text else {"compression": "gzip"}
            copied = out.create_dataset(name, data=data, **options)
            for key, value in item.attrs.items():
                copied.attrs[key] = value

        file.visititems(copy)
        del out["/mesh/rest_normals"]  # not in the published layout


def main():
    with tempfile.TemporaryDirectory(prefix="penumbra_h5py_") as name:
        folder = Path(name)
        run(sys.executable, ROOT / "scripts" / "samples" / "make_samples.py", folder / "samples")
        options = ["--fps", "3", "--order", "3", "--rays", "32", "--seed", "5"]
        for precision in ("f32", "f16"):
            run(BIN / "penumbra-bake", "visibility", folder / "samples" / "bend.glb", "-o", folder / f"{precision}.vis.h5",
                "--precision", precision, *options)
        exact = check_layout(folder / "f32.vis.h5", "float32")
        assert (check_layout(folder / "f16.vis.h5", "float16") == exact.astype(np.float16)).all()

        copy_as_h5py_does(folder / "f16.vis.h5", folder / "copy.vis.h5")
        figures = []
        for file in ("f16.vis.h5", "copy.vis.h5"):
            run(BIN / "penumbra-bake", "info", folder / file, "--all", "--report", folder / "info.json")
            figures.append(json.loads((folder / "info.json").read_text())["figures"])
            del figures[-1]["file"], figures[-1]["bytes"]
        assert figures[0] == figures[1], figures
    print("h5py: ok")


main()
