"""penumbra-fit light on every kind of light, good and bad, as a user runs it: layouts, analytic lights, lobes, windows, exit
codes; penumbra-bake info shows what is in the file. PENUMBRA_DATA adds the light probe of data/lights in two layouts."""
import json
import math
import os
import pathlib
import struct
import subprocess
import sys
import tempfile

import h5py
import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "scripts" / "figures"))
from spherical_harmonics import basis  # noqa: E402

BIN = pathlib.Path(sys.argv[1]).resolve()


def run(folder, *arguments, program="penumbra-fit"):
    done = subprocess.run([BIN / program, *map(str, arguments)], cwd=folder, capture_output=True, text=True)
    return done.returncode, done.stdout, done.stderr


def write_exr(path, pixels):
    """Writes a scanline OpenEXR file of floats without compression; pixels [height, width, 3]."""
    height, width, _ = pixels.shape

    def attribute(name, kind, value):
        return name.encode() + b"\0" + kind.encode() + b"\0" + struct.pack("<i", len(value)) + value

    channels = b"".join(c + b"\0" + struct.pack("<iBxxxii", 2, 0, 1, 1) for c in (b"B", b"G", b"R")) + b"\0"
    box = struct.pack("<4i", 0, 0, width - 1, height - 1)
    header = struct.pack("<2i", 20000630, 2) + attribute("channels", "chlist", channels) + \
        attribute("compression", "compression", b"\0") + attribute("dataWindow", "box2i", box) + \
        attribute("displayWindow", "box2i", box) + attribute("lineOrder", "lineOrder", b"\0") + \
        attribute("pixelAspectRatio", "float", struct.pack("<f", 1)) + \
        attribute("screenWindowCenter", "v2f", struct.pack("<2f", 0, 0)) + \
        attribute("screenWindowWidth", "float", struct.pack("<f", 1)) + b"\0"
    row = 8 + width * 12
    offsets = struct.pack(f"<{height}Q", *(len(header) + 8 * height + y * row for y in range(height)))
    rows = b"".join(struct.pack("<2i", y, width * 12) + pixels[y, :, ::-1].T.astype("<f4").tobytes() for y in range(height))
    path.write_bytes(header + offsets + rows)


def fibonacci(n):
    i = np.arange(n)
    z, q = 1 - (2 * i + 1) / n, i * math.pi * (3 - math.sqrt(5))
    return np.stack([np.sqrt(1 - z * z) * np.cos(q), np.sqrt(1 - z * z) * np.sin(q), z], -1)


def read(path):
    with h5py.File(path) as f:
        lobes = {key: f["/light/lobes"][key][()] for key in f["/light/lobes"]} if "lobes" in f["/light"] else {}
        lobes.update(f["/light/lobes"].attrs if lobes else {})
        return f["/light/sh"][()], dict(f["/light"].attrs), lobes, json.loads(f.attrs["provenance"])["options"]


def check_layouts(folder):
    for width, height, arguments in ((16, 8, []), (12, 16, []), (16, 12, []), (15, 15, ["--layout", "angular"]),
                                     (15, 15, ["--layout", "ball"])):
        write_exr(folder / "p.exr", np.broadcast_to(np.array([1, 2, 0.5]), (height, width, 3)))
        code, out, err = run(folder, "light", "p.exr", "-o", "e.light.h5", "--order", 6, *arguments)
        assert code == 0 and err == "", (width, height, code, err)
        sh, attributes, _, options = read(folder / "e.light.h5")
        assert np.allclose(sh[0], math.sqrt(4 * math.pi) * np.array([1, 2, 0.5]), atol=1e-6), sh[0]
        assert np.abs(sh[1:]).max() < 1e-6 and attributes["residual"] < 1e-3, (options, np.abs(sh[1:]).max())
        assert not arguments or options["layout"] == arguments[1]
    print("uniform pictures of every layout have band 0 only")


def check_analytic(folder):
    code, out, err = run(folder, "light", "--analytic", "directional:direction=0/1/0,irradiance=3", "--analytic",
                         "uniform:radiance=1/2/3", "-o", "e.light.h5", "--order", 4)
    assert code == 0 and err == "", err
    sh, attributes, _, options = read(folder / "e.light.h5")
    expected = 3 * basis(4, np.array([[0.0, 1.0, 0.0]]))[0][:, None] * np.ones(3)
    expected[0] += math.sqrt(4 * math.pi) * np.array([1, 2, 3])
    assert np.allclose(sh, expected, atol=1e-12) and attributes["residual"] == 1
    assert options["analytic"].startswith("directional:direction=0/1/0,irradiance=3/3/3+uniform"), options
    code, out, err = run(folder, "light", "--analytic", "sky:elevation=20,albedo=0.2+overcast", "-o", "e.light.h5")
    with h5py.File(folder / "e.light.h5") as f:
        assert code == 0 and f.attrs["name"] == "sky:elevation=20,albedo=0.2+overcast", err
    print("analytic lights: a delta is its basis; several add up")


def check_lobes(folder):
    random = np.random.default_rng(3)
    write_exr(folder / "noise.exr", random.random((32, 64, 3))**8 * 50)
    residuals = {}
    for fit in ("greedy", "joint"):
        for lobes in (1, 3, 7):
            code, out, err = run(folder, "light", "noise.exr", "-o", "l.light.h5", "--lobes", lobes, "--lobe-fit", fit)
            assert code == 0, err
            sh, _, stored, _ = read(folder / "l.light.h5")
            rebuilt = np.zeros_like(sh)
            for d, z in zip(stored["directions"], stored["coefficients"]):
                y = basis(4, d[None])[0]
                for l in range(4):
                    band = slice(l * l, (l + 1)**2)
                    rebuilt[band] += math.sqrt(4 * math.pi / (2 * l + 1)) * np.outer(y[band], z[l])
            residual = np.linalg.norm(sh - rebuilt) / np.linalg.norm(sh)
            assert abs(residual - stored["residual"]) < 1e-9 and stored["mode"] == fit and f"{residual:.4f}" in out
            assert stored["coefficients"].shape == (lobes, 4, 3)
            residuals[fit, lobes] = residual
    assert residuals["joint", 3] < residuals["greedy", 3] and residuals["joint", 7] < 1e-3, residuals
    code, out, err = run(folder, "light", "noise.exr", "-o", "l.light.h5", "--lobe-fit", "fixed", "--order", 5)
    assert code == 0 and read(folder / "l.light.h5")[2]["residual"] < 1e-6
    assert read(folder / "l.light.h5")[2]["directions"].shape == (9, 3)
    code, out, _ = run(folder, "info", "l.light.h5", program="penumbra-bake")
    assert code == 0 and "lobes" in out and "fixed" in out, out
    assert run(folder, "light", "noise.exr", "-o", "l.light.h5", "--lobes", 0)[0] == 0
    assert read(folder / "l.light.h5")[2] == {}
    # A light has band 0 only, or is black: then it has lobes of nothing, and no NaN.
    for value in (0, 2.5):
        write_exr(folder / "flat.exr", np.full((4, 8, 3), value))
        code, out, err = run(folder, "light", "flat.exr", "-o", "f.light.h5")
        sh, attributes, lobes, _ = read(folder / "f.light.h5")
        assert code == 0 and np.isfinite(lobes["coefficients"]).all() and lobes["residual"] < 1e-6, (value, err, lobes)
        assert attributes["residual"] < 1e-3 and np.abs(sh[1:]).max() < 1e-6
    first = None
    for threads in (1, 2, 8):
        assert run(folder, "light", "noise.exr", "-o", "t.light.h5", "--threads", threads)[0] == 0
        first = first or (folder / "t.light.h5").read_bytes()
        assert (folder / "t.light.h5").read_bytes() == first, f"{threads} threads give other bytes"
    print("lobes:", ", ".join(f"{fit} {n}: {r:.3f}" for (fit, n), r in residuals.items()))


def check_sun(folder):
    """With one pixel of 1e5, the default leaves no radiance below -1% of the mean, and says what it did."""
    directions = fibonacci(20000)
    for sky in (0, 0.3, 5):
        pixels = np.full((64, 128, 3), float(sky))
        pixels[20, 37] = 1e5
        write_exr(folder / "sun.exr", pixels)
        code, out, err = run(folder, "light", "sun.exr", "-o", "s.light.h5", "--report", "r.json")
        assert code == 0 and "(37, 20)" in out and "window" in out, (out, err)
        sh = read(folder / "s.light.h5")[0]
        least = ((basis(4, directions) @ sh) / (sh[0] / math.sqrt(4 * math.pi))).min()
        window = json.loads((folder / "r.json").read_text())["figures"]["window"]
        assert -0.0101 < least <= 0 and abs(least - window["least_radiance_after"]) < 2e-3, (least, window)
        assert window["least_radiance_before"] < -1
        assert err == "", err
        code, out, err = run(folder, "light", "sun.exr", "-o", "n.light.h5", "--window", "none")
        assert code == 0 and err.count("\n") == 1 and "warning: sun.exr rings down to -" in err, err
        assert "--window always" in err and "no window" not in out, (out, err)
        assert np.allclose(read(folder / "n.light.h5")[0][0], sh[0])
    with h5py.File(folder / "s.light.h5") as f:
        weights = f["/light/window"][()]
    assert weights[0] == 1 and (np.diff(weights) < 0).all()
    code, out, _ = run(folder, "info", "s.light.h5", program="penumbra-bake")
    assert "window" in out
    print(f"a sun of one pixel: least radiance {100 * least:.2f}% of the mean, band weights {np.round(weights, 3)}")


def check_warnings(folder):
    """What shows in pictures is said on stderr, also with -q. What does not show is not said."""
    spot = np.full((64, 128, 3), 1.0)
    spot[20:23, 37:40] = 1e4  # too large for the window of a hot pixel
    write_exr(folder / "spot.exr", spot)
    write_exr(folder / "black.exr", np.zeros((4, 8, 3)))
    for warning, arguments in (
        ("sun rings down to -400.0% of the mean", ["--analytic", "sun"]),  # a delta: 16 Legendre-weighted terms
        ("spot.exr rings down to -", ["spot.exr"]),
        ("black.exr is black", ["black.exr"]),
        ("--window does nothing at order 1", ["--analytic", "sun", "--order", "1", "--window", "always"]),
        ("", ["--analytic", "sun", "--order", "1"]),
        ("", ["--analytic", "sun", "--window", "always"]),
        ("", ["--analytic", "overcast"]),
    ):
        code, out, err = run(folder, "light", *arguments, "-q", "-o", "w.light.h5")
        assert code == 0 and out == "" and err.count("\n") == (warning != "") and warning in err, (arguments, out, err)
    # One pixel after resampling, and 2 x 2, are sharp spots that no lens makes.
    for kernel in (np.ones((2, 2)), np.outer([.2, 1, .2], [.2, 1, .2]), np.outer([.3, .7], [.6, .4])):
        pixels = np.full((64, 128, 3), 1.0)
        rows, columns = np.ix_(range(20, 20 + len(kernel)), (126 + np.arange(kernel.shape[1])) % 128)  # across the seam
        pixels[rows, columns] += 1e5 * kernel[..., None]
        write_exr(folder / "spot.exr", pixels)
        code, out, err = run(folder, "light", "spot.exr", "-o", "w.light.h5")
        assert code == 0 and err == "" and "a window (" in out and ("the spot around it" in out), (out, err)
    out = run(folder, "light", "--analytic", "sun", "-o", "w.light.h5")[1]
    assert "the residual is detail finer than SH of order 4" in out, out
    print("warnings: ringing, black lights, a window at order 1; sharp spots get a window")


def check_failures(folder):
    good = np.ones((8, 16, 3))
    bad = {name: good.copy() for name in ("nan", "negative", "infinite")}
    bad["nan"][3, 5, 1] = math.nan
    bad["negative"][2, 7, 0] = -4
    bad["infinite"][1, 2, 2] = math.inf
    for name, pixels in bad.items():
        write_exr(folder / f"{name}.exr", pixels)
    write_exr(folder / "good.exr", good)
    write_exr(folder / "square.exr", np.ones((9, 9, 3)))
    write_exr(folder / "wide.exr", np.ones((5, 13, 3)))
    photo = np.ones((6, 8, 3))
    photo[0, 0] = 3
    write_exr(folder / "photo.exr", photo)
    before = sorted(p.name for p in folder.iterdir())
    cases = [
        (3, "(5, 3)", ["nan.exr"]),
        (3, "(2, 1)", ["infinite.exr"]),
        (3, "(7, 2)", ["negative.exr"]),
        (3, "13 x 5", ["wide.exr"]),
        (3, "9 x 9", ["square.exr"]),
        (3, "corners", ["photo.exr"]),
        (3, "16 x 8", ["good.exr", "--layout", "ball"]),
        (3, "16 x 8", ["good.exr", "--layout", "cube"]),
        (3, "9 x 9", ["square.exr", "--layout", "latlong"]),
        (1, "--layout", ["good.exr", "--layout", "probe"]),
        (1, "--order", ["good.exr", "--order", "9"]),
        (1, "--order", ["good.exr", "--order", "0"]),
        (1, "--lobes", ["good.exr", "--lobes", "8"]),
        (1, "--lobes", ["good.exr", "--lobe-fit", "fixed", "--lobes", "3"]),
        (1, "--lobe-fit", ["good.exr", "--lobe-fit", "best"]),
        (1, "--window", ["good.exr", "--window", "hann"]),
        (1, "--window", ["good.exr", "--window", "-1"]),
        (1, "--analytic", []),
        (1, "--analytic", ["good.exr", "--analytic", "sky"]),
        (1, "--layout", ["--analytic", "sky", "--layout", "ball"]),
        (1, "'lamp'", ["--analytic", "lamp"]),
        (1, "good.exr is a file: a picture is given without", ["--analytic", "good.exr"]),
        (3, "e.light.h5: is HDF5, as fitted lights are", ["e.light.h5"]),
        (1, "turbidty", ["--analytic", "sky:turbidty=3"]),
        (1, "turbidity must be a number from 2 to 10", ["--analytic", "sky:turbidity=30"]),
        (1, "radiance", ["--analytic", "disc:radiance=-1"]),
        (1, "direction", ["--analytic", "directional:direction=0/0/0"]),
        (0, "", ["good.exr", "--dry-run"]),
        (0, "", ["--analytic", "sky", "--dry-run"]),
    ]
    for expected, named, arguments in cases:
        code, _, err = run(folder, "light", *arguments, "-o", "x.light.h5")
        assert code == expected and named in err and err.count("\n") == (expected != 0), (arguments, code, err)
        assert sorted(p.name for p in folder.iterdir()) == before, arguments
    print(f"{len(cases)} failures and dry runs: exit codes, one line each, nothing left")


def check_reference(folder):
    """Ray-traced pictures take the same lights: a picture of any layout, and analytic lights. Bad ones are named."""
    rig = BIN.parent / "samples" / "bend.glb"
    code, _, err = run(folder, "visibility", rig, "-o", "b.vis.h5", "--frames", "0:1", "--rays", 64, program="penumbra-bake")
    assert code == 0, err
    write_exr(folder / "ball.exr", np.ones((9, 9, 3)))
    pictures = []
    for light in (["ball.exr", "--layout", "ball"], ["uniform"], ["sky:elevation=40+directional:direction=1/1/1,irradiance=2"]):
        code, out, err = run(folder, "reference", "b.vis.h5", "--frame", 0, "--light", *light, "--size", "24x24", "--samples", 64,
                             "-o", "r.png", program="penumbra-bake")
        assert code == 0, (light, err)
        pictures.append((folder / "r.png").read_bytes())
    assert len(set(pictures)) == 3
    (folder / "r.png").unlink()
    for expected, named, light in ((1, "turbidty", ["sky:turbidty=1"]), (1, "--layout", ["sky", "--layout", "ball"]),
                                   (2, "none.exr", ["none.exr"]), (3, "9 x 9", ["ball.exr"])):
        code, _, err = run(folder, "reference", "b.vis.h5", "--frame", 0, "--light", *light, "-o", "r.png",
                           program="penumbra-bake")
        assert code == expected and named in err and not (folder / "r.png").exists(), (light, code, err)
    print("bake reference: pictures of other layouts and analytic lights")


def check_probe(folder):
    """One light probe as angular map and as lat-long picture gives the same SH, without any rotation between them."""
    if "PENUMBRA_DATA" not in os.environ:
        print("PENUMBRA_DATA is not set: no light probe")
        return
    lights = pathlib.Path(os.environ["PENUMBRA_DATA"]) / "lights"
    sh = []
    for name, layout in (("galileo_angular.hdr", "angular"), ("galileo_latlong.hdr", "latlong")):
        code, _, err = run(folder, "light", lights / name, "--layout", layout, "--order", 6, "-o", "g.light.h5")
        assert code == 0, err
        sh.append(read(folder / "g.light.h5")[0])
    for order in (1, 2, 4, 6):  # measured: 0.2% to 0.5%, two resamplings of one picture
        difference = np.linalg.norm((sh[0] - sh[1])[:order**2]) / np.linalg.norm(sh[1][:order**2])
        assert difference < 0.01, (order, difference)
    print(f"light probe as angular map and as lat-long: SH differ by {100 * difference:.2f}%")


with tempfile.TemporaryDirectory() as name:
    for check in (check_layouts, check_analytic, check_lobes, check_sun, check_warnings, check_failures, check_reference, check_probe):
        check(pathlib.Path(name))
