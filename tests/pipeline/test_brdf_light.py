"""penumbra-fit brdf and light as a user runs them: files, figures, exit codes, nothing left behind on a failure."""
import json
import pathlib
import subprocess
import sys
import tempfile

import h5py
import numpy as np

BIN = pathlib.Path(sys.argv[1]).resolve()


def run(folder, *arguments):
    done = subprocess.run([BIN / "penumbra-fit", *arguments], cwd=folder, capture_output=True, text=True)
    return done.returncode, done.stdout, done.stderr


def write_hdr(path, rgbe):
    """Writes a flat Radiance file of [height, width, 4] bytes."""
    height, width, _ = rgbe.shape
    header = f"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {height} +X {width}\n".encode()
    path.write_bytes(header + rgbe.astype(np.uint8).tobytes())


def check_brdf(folder):
    spec = "ggx:alpha=0.3,f0=0.9,color=1/0.5/0.25"
    code, out, err = run(folder, "brdf", "--analytic", spec, "-o", "m.brdf.h5", "--report", "r.json")
    assert code == 0 and err == "", (code, err)
    with h5py.File(folder / "m.brdf.h5") as f:
        assert f.attrs["format"] == "penumbra.brdf" and f.attrs["name"] == spec
        assert f.attrs["sh_convention"] == "real-orthonormal-cs"
        slices, even = f["/reflectance/slices"][()], f["/reflectance/even_index"][()]
        assert json.loads(f.attrs["provenance"])["options"]["analytic"] == spec
        fit_error = f["/error"].attrs["fit"]
        lobes = f["/lobes"]
        assert list(lobes["model"]) == [7] and np.allclose(lobes["parameters"], [[0.3, 0.9, 0, 0]]), list(lobes["model"])
        assert np.allclose(lobes["color"], [[1, 0.5, 0.25]]) and lobes.attrs["error"] == 0
    assert slices.shape == (25, 15, 3) and list(even[:5]) == [0, 1, 3, 4, 6]
    assert np.allclose(slices[..., 1], slices[..., 0] / 2) and np.allclose(slices[..., 2], slices[..., 0] / 4)
    figures = json.loads((folder / "r.json").read_text())
    assert fit_error == figures["figures"]["fit"] and f"{fit_error:.4f}" in out, (fit_error, figures, out)
    first = (folder / "m.brdf.h5").read_bytes()
    for threads in ("1", "2", "8"):
        assert run(folder, "brdf", "--analytic", spec, "-o", "m.brdf.h5", "--threads", threads)[0] == 0
        assert (folder / "m.brdf.h5").read_bytes() == first, f"{threads} threads give other bytes"
    print("brdf: slices, figures, the same bytes for 1, 2 and 8 threads")


def check_operators(folder):
    """Checks sizes, what is stored, and that two ways to the same radiance agree as far as their errors say."""
    spec = "ward-gmd:ax=0.2,ay=0.5,color=1/0.5/0"
    for source, asked in (("slices", "8"), ("table", "8"), ("literal", "8"), ("slices", "16")):
        code, out, err = run(folder, "brdf", "--analytic", spec, "-o", "o.brdf.h5", "--operators", asked, "--operators-from",
                             source, "--report", "o.json")
        warning = "penumbra-pack refuses" if source == "literal" else "--operators 9 is the most" if asked == "16" else ""
        assert code == 0 and err.count("\n") == (warning != "") and warning in err, (code, err)
        figures = json.loads((folder / "o.json").read_text())["figures"]
        with h5py.File(folder / "o.brdf.h5") as f:
            u, w, index = f["/operators/u"][()], f["/operators/w"][()], f["/operators/view_index"][()]
            order = f["/operators"].attrs["order"]
            errors = dict(f["/error"].attrs)
            assert f["/operators"].attrs["source"] == source
            slices, even = f["/reflectance/slices"][()], f["/reflectance/even_index"][()]
        assert u.shape == (figures["operators"], order**2, 3) and w.shape == (len(u), len(index), 3)
        assert list(index) == (list(even) if source != "literal" else list(range(16)))
        assert np.allclose(u[..., 1], u[..., 0] / 2) and not u[..., 2].any()
        assert 0 < errors["shading_d5"] < errors["shading_a4"] < errors["shading_operators"] + 1e-9, errors
        size = figures["operators_bytes_per_channel"]
        assert size == len(u) * (16 * 16 + len(index)) * 4 and (size <= 10240 or asked == "16"), figures
        line = f"{len(u)} operators from {source}: shading error {errors['shading_operators']:.4f} (A4), "
        assert line + f"{errors['shading_operators_d5']:.4f} (D5), {size} bytes a channel\n" in out, out
        info = subprocess.run([BIN / "penumbra-bake", "info", "o.brdf.h5"], cwd=folder, capture_output=True, text=True)
        assert info.returncode == 0 and f"count {len(u)}, source {source}, order {order}" in info.stdout, info.stdout
        if asked == "16":  # all 15 terms of C
            assert f"{len(u)} operators instead of 16" in out and len(u) == 15, out
            assert np.allclose(np.einsum("bic,bec->iec", u, w), slices, atol=1e-9)
    first = (folder / "o.brdf.h5").read_bytes()
    for threads in ("1", "8"):
        assert run(folder, "brdf", "--analytic", spec, "-o", "o.brdf.h5", "--operators", "16", "--threads", threads)[0] == 0
        assert (folder / "o.brdf.h5").read_bytes() == first, f"{threads} threads give other bytes"
    (folder / "o.brdf.h5").unlink()
    print("operators: three sources, all terms of C are C, the same bytes for any number of threads")


def check_orders(folder):
    """Slices may have any order up to 8. The more bands the view has, the nearer the fit is."""
    fits = []
    for bands in (1, 3, 6, 8):
        code, out, err = run(folder, "brdf", "--analytic", "ggx:alpha=0.2", "--slice-order", str(bands), "--view-order", str(bands),
                             "-o", "j.brdf.h5")
        assert code == 0 and err == "", err
        with h5py.File(folder / "j.brdf.h5") as f:
            assert f["/reflectance/slices"].shape == (bands**2, bands * (bands + 1) // 2, 3)
            assert json.loads(f.attrs["provenance"])["options"]["view_order"] == bands
            errors = dict(f["/error"].attrs)
        fits.append(errors["shading_d5"])
    assert (np.diff(fits[:3]) < 0).all(), fits
    (folder / "j.brdf.h5").unlink()
    print("slices of orders 1, 3, 6, 8: shading error (D5)", np.round(fits, 4))


def check_names(folder):
    for arguments in (["brdf", "--analytic", "ggx"], ["light", "sky.hdr"]):
        code, out, err = run(folder, *arguments, "--name", "my own", "-o", "n.h5")
        with h5py.File(folder / "n.h5") as f:
            assert code == 0 and f.attrs["name"] == "my own" and out.startswith("my own: "), (code, out, err)
        for bad in ("", "a\nb", "a\x7f"):
            code, out, err = run(folder, *arguments, "--name", bad, "-o", "x.h5")
            assert code == 1 and "name" in err and err.count("\n") == 1 and not (folder / "x.h5").exists(), (bad, err)
        (folder / "n.h5").unlink()
    for verb, lines in (("brdf", ["ggx:alpha=0.3 (0.01..1),f0=0.9 (0..1)", "  lambert\n"]),
                        ("light", ["disc:direction=0/1/0,angle=0.267 (0.01..180),radiance=1 (0..1e+09)"])):
        out = run(folder, verb, "--help")[1]
        assert all(line in out for line in lines) and "Exit codes" in out, out
    print("names of one's own; --help lists the models' parameters")


def check_light(folder):
    # Radiance is (1, 2, 0.5) everywhere, as a byte c stands for c 2^(e-136).
    write_hdr(folder / "sky.hdr", np.broadcast_to(np.array([64, 128, 32, 130]), (4, 8, 4)))
    code, out, err = run(folder, "light", "sky.hdr", "-o", "e.light.h5", "--order", "3")
    assert code == 0 and err == "", (code, err)
    with h5py.File(folder / "e.light.h5") as f:
        assert f.attrs["format"] == "penumbra.light" and f.attrs["sh_order"] == 3
        sh, residual = f["/light/sh"][()], f["/light"].attrs["residual"]
        assert json.loads(f.attrs["provenance"])["inputs"][0]["name"] == "sky.hdr"
    assert sh.shape == (9, 3)
    assert np.allclose(sh[0], np.sqrt(4 * np.pi) * np.array([1, 2, 0.5])) and np.abs(sh[1:]).max() < 1e-9
    assert residual < 1e-6, residual
    print("light: a uniform sky has band 0 only")


def check_failures(folder):
    write_hdr(folder / "square.hdr", np.full((4, 4, 4), 128))
    (folder / "empty.exr").write_bytes(b"")
    (folder / "cut.hdr").write_bytes((folder / "sky.hdr").read_bytes()[:-3])
    before = sorted(p.name for p in folder.iterdir())
    cases = [
        (1, "--analytic", ["brdf", "-o", "x.h5"]),
        (1, "gloss", ["brdf", "--analytic", "gloss", "-o", "x.h5"]),
        (1, "alpha", ["brdf", "--analytic", "ggx:alpha=7", "-o", "x.h5"]),
        (1, "--operators", ["brdf", "--analytic", "ggx", "-o", "x.h5", "--operators", "17"]),
        (1, "guess", ["brdf", "--analytic", "ggx", "-o", "x.h5", "--operators", "8", "--operators-from", "guess"]),
        (1, "--operators", ["brdf", "--analytic", "ggx", "-o", "x.h5", "--operators-from", "table"]),
        (1, "--order", ["light", "sky.hdr", "-o", "x.h5", "--order", "9"]),
        (2, "none.exr", ["light", "none.exr", "-o", "x.h5"]),
        (2, "no/such", ["light", "sky.hdr", "-o", "no/such/x.h5"]),
        (2, "e.light.h5", ["light", "sky.hdr", "-o", "e.light.h5", "--no-clobber"]),
        (3, "empty.exr", ["light", "empty.exr", "-o", "x.h5"]),
        (3, "cut.hdr", ["light", "cut.hdr", "-o", "x.h5"]),
        (3, "4 x 4", ["light", "square.hdr", "-o", "x.h5"]),
        (0, "", ["light", "sky.hdr", "-o", "x.h5", "--dry-run"]),
        (0, "", ["brdf", "--analytic", "ggx", "-o", "x.h5", "--dry-run"]),
    ]
    for expected, named, arguments in cases:
        code, _, err = run(folder, *arguments)
        assert code == expected and named in err and err.count("\n") == (expected != 0), (arguments, code, err)
        assert sorted(p.name for p in folder.iterdir()) == before, arguments
    print(f"{len(cases)} failures and dry runs: exit codes, one line each, nothing left")


with tempfile.TemporaryDirectory() as name:
    check_brdf(pathlib.Path(name))
    check_operators(pathlib.Path(name))
    check_orders(pathlib.Path(name))
    check_light(pathlib.Path(name))
    check_names(pathlib.Path(name))
    check_failures(pathlib.Path(name))
