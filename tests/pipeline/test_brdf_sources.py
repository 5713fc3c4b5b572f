"""Materials from every kind of source, as a user gives them to penumbra-fit brdf and penumbra-bake reference.

usage: test_brdf_sources.py BIN
"""
import json
import os
import pathlib
import struct
import subprocess
import sys
import tempfile

import h5py
import numpy as np
from PIL import Image

from ribbon_bake import bake_file

BIN = pathlib.Path(sys.argv[1]).resolve()
FITS = "material,kD_r,kD_g,kD_b,A_r,A_g,A_b,B,C,ior\nred,0.5,0.1,0,0,0,0,1,1,1.5\nshiny,0,0,0,30,30,20,1000,1.2,1.5\n"
TABLE = "penumbra-brdf-table 1\nsymmetry isotropic\ntheta_i 2\ntheta_o 2\nphi 2\n" + 8 * "0.1 0.2 0.3\n"


def run(folder, tool, *arguments):
    done = subprocess.run([BIN / f"penumbra-{tool}", *map(str, arguments)], cwd=folder, capture_output=True, text=True)
    return done.returncode, done.stdout, done.stderr


def merl(red):
    """Writes a MERL file that is Lambertian, with `red` in its first channel's cell (0, 0, 0)."""
    cells = 90 * 90 * 180
    planes = [np.full(cells, f * 1500 / scale / np.pi) for f, scale in ((0.5, 1), (0.25, 1.15), (0.125, 1.66))]
    planes[0][0] = red
    return struct.pack("<3i", 90, 90, 180) + np.concatenate(planes).tobytes()


def scattered(value):
    rows = [f"{ti} 0 {to} {phi} {value} {value} {value}" for ti in (.2, .7, 1.2) for to in (.2, .7, 1.2)
            for phi in (0, 1.5, 3.1)]
    return "# grey\n3\n450 550 650\n" + "\n".join(rows) + "\n"


def slices_of(folder, *arguments, warning=""):
    code, out, err = run(folder, "fit", "brdf", *arguments, "-o", "m.brdf.h5", "--report", "r.json", "--depfile", "m.d")
    assert code == 0 and err.count("\n") == (warning != "") and warning in err, (arguments, code, err)
    with h5py.File(folder / "m.brdf.h5") as f:
        provenance = json.loads(f.attrs["provenance"])
        return f["/reflectance/slices"][()], f.attrs["name"], provenance, json.loads((folder / "r.json").read_text())


def check_sources(folder):
    (folder / "paint.binary").write_bytes(merl(0.5 * 1500 / np.pi))
    (folder / "grey.brdf").write_text(scattered(0.1))
    (folder / "fits.csv").write_text(FITS)
    (folder / "own.txt").write_text(TABLE)
    lambert = slices_of(folder, "--analytic", "lambert")[0]
    for arguments, name, albedo in [(["--merl", "paint.binary"], "paint.binary", [0.5, 0.25, 0.125]),
                                    (["--table", "grey.brdf"], "grey.brdf", [0.1 * np.pi] * 3),
                                    (["--table", "fits.csv", "--material", "red"], "fits.csv:red", [0.5, 0.1, 0]),
                                    (["--table", "own.txt"], "own.txt", np.pi * np.array([0.1, 0.2, 0.3]))]:
        slices, stored, provenance, report = slices_of(folder, *arguments)
        assert stored == name and provenance["inputs"][0]["name"] == arguments[1], (stored, provenance)
        assert arguments[1] in (folder / "m.d").read_text()
        assert np.allclose(slices, lambert * albedo, atol=3e-6), (name, np.abs(slices - lambert * albedo).max())
        assert np.allclose([report["figures"][f"albedo_{c}"] for c in "rgb"], albedo, atol=3e-6)
        first = (folder / "m.brdf.h5").read_bytes()
        for threads in (1, 8):
            slices_of(folder, *arguments, "--threads", threads)
            assert (folder / "m.brdf.h5").read_bytes() == first, (name, threads)
    print("MERL, scattered, fitted and tabulated Lambertians are Lambertian; same bytes for 1 and 8 threads")


def check_warnings(folder):
    figures = slices_of(folder, "--analytic", "lambert:color=1/2/1", warning="albedo is 2.000")[3]["figures"]
    assert abs(figures["albedo_max"] - 2) < 1e-9, figures
    (folder / "noisy.brdf").write_text(scattered(0.1).replace("0.1 0.1 0.1\n", "-0.01 0.1 0.1\n", 2))
    figures = slices_of(folder, "--table", "noisy.brdf", warning="2 negative values")[3]["figures"]
    assert figures["clamped"] == 2 and figures["samples"] == 27, figures
    hole = np.frombuffer(merl(1), "f8", offset=12).copy().reshape(3, 90, 90, 180)
    hole[:, 10, 10, 20:160] = -1
    (folder / "hole.binary").write_bytes(struct.pack("<3i", 90, 90, 180) + hole.tobytes())
    figures = slices_of(folder, "--merl", "hole.binary", warning="70 cells above the horizon")[3]["figures"]
    assert figures["unmeasured"] == 70, figures
    print("warnings: energy gain with the albedo, clamped values, cells without measurement")


def check_failures(folder):
    (folder / "short.binary").write_bytes(merl(1)[:-8])
    (folder / "nan.binary").write_bytes(merl(np.nan))
    (folder / "nan.brdf").write_text(scattered("nan"))
    (folder / "minus.txt").write_text(TABLE.replace("0.2", "-0.2", 1))
    (folder / "noise.txt").write_bytes(bytes(range(256)) * 40)
    (folder / "columns.csv").write_text(FITS + "odd,1,2\n")
    (folder / "line\nbreak.txt").write_text("nothing")
    before = sorted(p.name for p in folder.iterdir())
    cases = [
        (3, "paint.binary: is a file of the MERL database, not a table", ["--table", "paint.binary"]),
        (3, "noise.txt: binary, not a known table", ["--table", "noise.txt"]),
        (3, "m.brdf.h5: is HDF5, as fitted materials are", ["--table", "m.brdf.h5"]),
        (3, "line break.txt", ["--table", "line\nbreak.txt"]),
        (1, "paint.binary is a file: merl and table", ["--analytic", "paint.binary"]),
        (1, "--analytic: give exactly one", []),
        (1, "exactly one", ["--analytic", "ggx", "--table", "own.txt"]),
        (1, "'gloss': use one of lambert, oren-nayar", ["--analytic", "gloss"]),
        (1, "no 'roughness': use color, alpha, f0", ["--analytic", "ggx:roughness=0.1"]),
        (1, "sigma must be a number from 0", ["--analytic", "oren-nayar:sigma=-1"]),
        (1, "use one of red, shiny", ["--table", "fits.csv", "--material", "blue"]),
        (1, "red, shiny", ["--table", "fits.csv"]),
        (1, "--material", ["--table", "own.txt", "--material", "red"]),
        (1, "--material", ["--analytic", "ggx", "--material", "red"]),
        (2, "none.binary", ["--merl", "none.binary"]),
        (2, "folder", ["--table", "."]),
        (3, "short.binary: has 34992004 bytes, a MERL file has 34992012", ["--merl", "short.binary"]),
        (3, "own.txt", ["--merl", "own.txt"]),
        (3, "nan.binary: channel R of cell theta_h 0, theta_d 0, phi_d 0 is NaN", ["--merl", "nan.binary"]),
        (3, "nan.brdf: line 4: a spectral value is 'nan'", ["--table", "nan.brdf"]),
        (3, "minus.txt: line 6: channel G of cell 0 is negative", ["--table", "minus.txt"]),
        (3, "noise.txt", ["--table", "noise.txt"]),
        (3, "columns.csv: line 4", ["--table", "columns.csv", "--material", "red"]),
        (3, "too abruptly", ["--analytic", "ward:ax=0.01,ay=10"]),
    ]
    for expected, named, arguments in cases:
        code, _, err = run(folder, "fit", "brdf", *arguments, "-o", "x.h5")
        assert code == expected and named in err and err.count("\n") == 1, (arguments, code, err)
        assert sorted(p.name for p in folder.iterdir()) == before, arguments
    print(f"{len(cases)} failures: exit codes, one line that names file and field, nothing left")


def reference(folder, *arguments):
    code, _, err = run(folder, "bake", "reference", "r.vis.h5", "--frame", 3, "--size", "32x32", "--samples", 512,
                       "--camera", "yaw=20", "-q", "-o", "out.png", *arguments)
    return code, err, np.asarray(Image.open(folder / "out.png"), float) if code == 0 else None


def check_reference(folder):
    bake_file(folder / "r.vis.h5")
    rgbe = np.zeros((16, 32, 4), np.uint8)  # light from one side of the sky only
    rgbe[2:8, 4:16] = [128, 128, 128, 130]
    (folder / "sky.hdr").write_bytes(b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 16 +X 32\n" + rgbe.tobytes())
    code, _, err = run(folder, "fit", "visibility", "r.vis.h5", "-o", "r.model.h5", "--model", "linear",
                       "--convention", "D3")
    assert code == 0, err
    red = reference(folder, "--brdf", "lambert:color=0.5/0.1/0")[2]
    assert red.max() > 100 and (reference(folder, "--table", "fits.csv", "--material", "red")[2] == red).all()
    for arguments in (["--table", "fits.csv", "--material", "shiny"], ["--merl", "paint.binary"], ["--table", "grey.brdf"]):
        assert np.abs(reference(folder, *arguments)[2] - red).max() > 20, arguments
    # Tangents of the model turn the frames of an isotropic material, which changes only the noise.
    sky = ["--light", "sky.hdr", "--brdf", "ggx"]
    plain, carried = [reference(folder, *sky, *more)[2] for more in ([], ["--tangents", "r.model.h5"])]
    assert plain.max() > 50 and np.abs(plain - carried).mean() < 1, (plain.max(), np.abs(plain - carried).mean())
    with h5py.File(folder / "r.vis.h5", "r+") as f:
        f["mesh/rest_positions"][0] += 0.25
    for expected, named, arguments in [(1, "exactly one", ["--brdf", "ggx", "--merl", "paint.binary"]),
                                       (1, "--brdf: no BRDF 'gloss'", ["--brdf", "gloss"]),
                                       (2, "none.csv", ["--table", "none.csv"]),
                                       (3, "r.model.h5: /mesh", ["--tangents", "r.model.h5"]),
                                       (3, "nan.binary", ["--merl", "nan.binary"])]:
        code, err, _ = reference(folder, *arguments)
        assert code == expected and named in err and err.count("\n") == 1, (arguments, code, err)
    print("reference pictures of all sources; a model's tangents; failures")


def check_real(folder, data):
    for name in ("acryl_blue", "krylon_blue", "cayman"):
        figures = slices_of(folder, "--table", data / "brdf" / f"{name}.brdf")[3]["figures"]
        assert figures["samples"] == 1439 and figures["refinement"] < 1e-3, (name, figures)
        assert figures["albedo_b"] >= figures["albedo_r"], (name, figures)  # all three are blue
    for material in ("chrome", "blue-acrylic", "white-fabric"):
        slices_of(folder, "--table", data / "brdf" / "merl_abc_fits.csv", "--material", material)
    print("measurements of real paints")


with tempfile.TemporaryDirectory() as name:
    check_sources(pathlib.Path(name))
    check_warnings(pathlib.Path(name))
    check_failures(pathlib.Path(name))
    check_reference(pathlib.Path(name))
    if "PENUMBRA_DATA" in os.environ:
        check_real(pathlib.Path(name), pathlib.Path(os.environ["PENUMBRA_DATA"]))
