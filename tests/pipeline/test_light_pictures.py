"""penumbra-fit light on pictures as renderers write them, against a projection of its own: numpy converts the colours,
mends and fills the pixels, and sums them over the sphere. Layers, parts and cubes of files have unit tests."""
import json
import math
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
ORDER = 4
W, H = 64, 32


def write_exr(path, channels, data=None, display=None, chromaticities=None):
    """Writes uncompressed floats; channels {name: [rows, columns]}, windows as x0, y0, x1, y1."""
    rows, columns = next(iter(channels.values())).shape
    data = data or (0, 0, columns - 1, rows - 1)

    def attribute(name, kind, value):
        return name.encode() + b"\0" + kind.encode() + b"\0" + struct.pack("<i", len(value)) + value

    names = sorted(channels)
    header = struct.pack("<2i", 20000630, 2) + attribute("channels", "chlist", b"".join(
        n.encode() + b"\0" + struct.pack("<iBxxxii", 2, 0, 1, 1) for n in names) + b"\0")
    if chromaticities:
        header += attribute("chromaticities", "chromaticities", struct.pack("<8f", *chromaticities))
    header += attribute("compression", "compression", b"\0") + attribute("dataWindow", "box2i", struct.pack("<4i", *data)) + \
        attribute("displayWindow", "box2i", struct.pack("<4i", *(display or data))) + \
        attribute("lineOrder", "lineOrder", b"\0") + attribute("pixelAspectRatio", "float", struct.pack("<f", 1)) + \
        attribute("screenWindowCenter", "v2f", struct.pack("<2f", 0, 0)) + \
        attribute("screenWindowWidth", "float", struct.pack("<f", 1)) + b"\0"
    size = 4 * columns * len(names)
    offsets = struct.pack(f"<{rows}Q", *(len(header) + 8 * rows + y * (8 + size) for y in range(rows)))
    lines = b"".join(struct.pack("<2i", data[1] + y, size) +
                     b"".join(channels[n][y].astype("<f4").tobytes() for n in names) for y in range(rows))
    path.write_bytes(header + offsets + lines)


def rgb(pixels):
    return {name: pixels[:, :, i] for i, name in enumerate("RGB")}


def project(pixels, fine=6):
    """SH of pixels of constant radiance, by fine x fine midpoints in each, [16, 3]."""
    rows, columns = pixels.shape[:2]
    t = math.pi * (np.arange(rows * fine) + 0.5) / (rows * fine)
    p = 2 * math.pi * ((np.arange(columns * fine) + 0.5) / (columns * fine) - 0.5)
    t, p = np.meshgrid(t, p, indexing="ij")
    weight = np.sin(t) * math.pi / (rows * fine) * 2 * math.pi / (columns * fine)
    d = np.stack([np.sin(t) * np.cos(p), np.cos(t), np.sin(t) * np.sin(p)], -1).reshape(-1, 3)
    radiance = pixels.repeat(fine, 0).repeat(fine, 1).reshape(-1, 3)
    return basis(ORDER, d).T @ (radiance * weight.reshape(-1, 1))


def to_rec709(rx, ry, gx, gy, bx, by, wx, wy):
    """The matrix of other primaries, white points adapted by Bradford."""
    def xyz(x, y):
        return np.array([x / y, 1, (1 - x - y) / y])

    def to_xyz(points, white):
        m = np.array([[x, y, 1 - x - y] for x, y in points]).T
        return m * np.linalg.solve(m, xyz(*white))

    cones = np.array([[.8951, .2664, -.1614], [-.7502, 1.7135, .0367], [.0389, -.0685, 1.0296]])
    d65 = (.3127, .3290)
    adapt = np.linalg.inv(cones) @ np.diag(cones @ xyz(*d65) / (cones @ xyz(wx, wy))) @ cones
    rec709 = to_xyz([(.64, .33), (.3, .6), (.15, .06)], d65)
    return np.linalg.inv(rec709) @ adapt @ to_xyz([(rx, ry), (gx, gy), (bx, by)], (wx, wy))


def fit(folder, name, *options):
    out = folder / "out.light.h5"
    out.unlink(missing_ok=True)
    done = subprocess.run([BIN / "penumbra-fit", "light", folder / name, "--order", str(ORDER), "--window", "none", "--lobes",
                           "0", "--report", folder / "report.json", "-o", out, *options], capture_output=True, text=True)
    if done.returncode:
        assert not out.exists()
        return None, done.stderr
    with h5py.File(out) as file:
        return file["light/sh"][:], done.stdout + done.stderr


def check(folder, name, expected, *options, tolerance=1e-3):
    got, text = fit(folder, name, *options)
    assert got is not None, text
    error = np.abs(got - expected).max() / np.abs(expected).max()
    assert error < tolerance, f"{name}: {error:.5f}"
    return text


def check_colors(folder, pixels):
    aces = (.713, .293, .165, .830, .128, .044, .32168, .33767)
    saturated = pixels * [1, .02, .01]
    write_exr(folder / "aces.exr", rgb(saturated), chromaticities=aces)
    unclipped = project(saturated @ to_rec709(*aces).T)
    assert "acescg" in check(folder, "aces.exr", unclipped)
    write_exr(folder / "plain.exr", rgb(saturated))
    check(folder, "plain.exr", unclipped, "--colorspace", "ACEScg")
    check(folder, "plain.exr", project(saturated))
    assert "warning" in check(folder, "aces.exr", project(saturated), "--colorspace", "srgb-linear")
    got, text = fit(folder, "plain.exr", "--colorspace", "adobe")
    assert got is None and "--colorspace" in text and "acescg" in text, text


# One pixel of NaN, as the mean of the eight around it; one of infinity at the seam.
def check_repair(folder, pixels):
    bad = pixels.copy()
    bad[3, 5] = np.nan
    bad[20, 0, 1] = np.inf
    write_exr(folder / "nan.exr", rgb(bad))
    got, text = fit(folder, "nan.exr")
    assert got is None and "(5, 3)" in text and "repair" in text, text
    for y, x in ((3, 5), (20, 0)):
        around = [bad[y + j, (x + i) % W] for j in (-1, 0, 1) for i in (-1, 0, 1) if (i, j) != (0, 0)]
        bad[y, x] = np.mean(around, 0)
    assert "2 pixels" in check(folder, "nan.exr", project(bad), "--repair")
    assert json.loads((folder / "report.json").read_text())["figures"]["repaired_pixels"] == 2


# A display window of which the file has a part, and a whole picture in a larger frame.
def check_windows(folder, pixels):
    write_exr(folder / "crop.exr", rgb(pixels[4:20, 10:50]), (10, 4, 49, 19), (0, 0, W - 1, H - 1))
    got, text = fit(folder, "crop.exr")
    assert got is None and "40 x 16 at (10, 4)" in text and "fill" in text, text
    for fill, options in ((0, ["--fill"]), (.25, ["--fill", ".25/.25/.25"])):
        filled = np.full_like(pixels, fill)
        filled[4:20, 10:50] = pixels[4:20, 10:50]
        check(folder, "crop.exr", project(filled), *options)
    write_exr(folder / "frame.exr", rgb(pixels), (0, 0, W - 1, H - 1), (0, 0, W - 1, H + 7))
    check(folder, "frame.exr", project(pixels))
    check(folder, "frame.exr", project(pixels), "--fill")
    write_exr(folder / "odd.exr", rgb(pixels[:, :-1]))
    check(folder, "odd.exr", project(pixels[:, :-1]))


def check_layers(folder, pixels):
    gray = pixels[:, :, :1].repeat(3, 2)
    write_exr(folder / "y.exr", {"Y": pixels[:, :, 0]})
    check(folder, "y.exr", project(gray))
    named = {f"a.{c}": v for c, v in rgb(pixels).items()} | {f"b.{c}": v for c, v in rgb(gray).items()}
    write_exr(folder / "layers.exr", named)
    got, text = fit(folder, "layers.exr")
    assert got is None and "several pictures" in text and "a, b" in text, text
    check(folder, "layers.exr", project(gray), "--layer", "b")
    got, text = fit(folder, "layers.exr", "--layer", "c")
    assert got is None and "--layer" in text and "a, b" in text, text


def main():
    pixels = np.random.default_rng(4).gamma(2., .5, (H, W, 3))
    pixels[8, 40] = 300, 250, 200
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        for part in (check_colors, check_repair, check_windows, check_layers):
            part(folder, pixels)
    print("pictures of lights agree with numpy")


main()
