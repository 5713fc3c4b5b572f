"""Automatic exposure of penumbra-player render (also of scenes) and penumbra-bake reference: a bright and a dark light
both give a picture that is neither white nor black, and what is compared has one exposure.

usage: test_exposure.py BIN
"""
import csv
import json
import os
import sys
import tempfile

import numpy as np
from PIL import Image

from programs import good, run_tool as run

BIN = os.path.abspath(sys.argv[1])
RIG = os.path.join(BIN, "..", "samples", "capsule_man.glb")
LOOK = ["--size", "96x96", "--camera", "yaw=30,pitch=10"]
LIGHTS = {"dark": 1e-3, "plain": 1.0, "bright": 5e3}  # mean radiance


def read(path):
    with open(path, "rb") as file:
        return file.read()


def exposure_of(report):
    with open(report) as file:
        return json.load(file)["figures"]["exposure"]


def write_probe(path, radiance):
    """Writes a lat-long Radiance picture, half of which is 8 times as bright as the other half."""
    mantissa, exponent = np.frexp(radiance)
    pixel = lambda power: bytes([round(256 * mantissa)] * 3 + [exponent + 128 + power])
    with open(path, "wb") as file:
        file.write(b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 4 +X 8\n" + (4 * pixel(1) + 4 * pixel(-2)) * 4)


def make_assets():
    good("bake", "visibility", RIG, "-o", "x.vis.h5", "--fps", 4, "--rays", 64)
    good("fit", "visibility", "x.vis.h5", "-o", "x.model.h5", "--holdout", "squat", "--clusters", 13)
    good("fit", "brdf", "--analytic", "lambert:color=0.7/0.6/0.5", "-o", "clay.brdf.h5")
    lights = []
    for name, radiance in LIGHTS.items():
        write_probe(name + ".hdr", radiance)
        good("fit", "light", name + ".hdr", "--name", name, "-o", name + ".light.h5")
        lights += ["--light", name + ".light.h5"]
    good("pack", "asset", "x.model.h5", "--brdf", "clay.brdf.h5", *lights, "-o", "x.pnb")
    good("pack", "truth", "x.vis.h5", "-o", "x.truth.pnb")


def luminance(path):
    """Returns the linear luminance of the pixels that are covered by half or more."""
    rgba = np.asarray(Image.open(path).convert("RGBA"), float) / 255
    srgb = rgba[rgba[..., 3] >= 0.5][:, :3]
    return np.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4) @ [0.2126, 0.7152, 0.0722]


def check_shown(path, what):
    """Neither white nor black: the 90th percentile is at 0.6, few pixels are cut, and half are above a dark grey."""
    values = luminance(path)
    assert values.size > 300, (what, values.size)
    assert abs(np.percentile(values, 90) - 0.6) < 0.05, (what, np.percentile(values, 90))
    assert (values > 0.99).mean() < 0.1 and np.median(values) > 0.05, (what, (values > 0.99).mean(), np.median(values))


def check_render():
    """The brightness of the light cancels; --exposure fixes the factor, and the printed one gives the same bytes."""
    pictures, factors = {}, {}
    for name, radiance in LIGHTS.items():
        words = ["player", "render", "x.pnb", "--light", name, *LOOK]
        said = good(*words, "-o", "a.png", "--report", "r.json").stdout
        check_shown("a.png", name)
        pictures[name], factors[name] = np.asarray(Image.open("a.png"), int), exposure_of("r.json")
        printed = said.split("--exposure ")[1].split()[0]
        good(*words, "-o", "b.png", "--exposure", printed)
        assert read("b.png") == read("a.png"), name
    for name in LIGHTS:
        assert np.abs(pictures[name] - pictures["plain"]).max() <= 2, name
    assert 4e6 < factors["dark"] / factors["bright"] < 6e6, factors
    words = ["player", "render", "x.pnb", *LOOK, "--exposure", 1]
    good(*words, "--light", "bright", "-o", "white.png")
    good(*words, "--light", "dark", "-o", "black.png")
    assert luminance("white.png").min() > 0.99 and luminance("black.png").max() < 0.01, "these lights need an exposure"


def check_linear_and_other_channels():
    """EXR stays linear, and the exposure is a setting of shaded pictures alone."""
    good("player", "render", "x.pnb", *LOOK, "--light", "bright", "-o", "a.exr", "--report", "r.json")
    with open("r.json") as file:
        assert "exposure" not in json.load(file)["figures"]
    good("player", "render", "x.pnb", *LOOK, "--light", "bright", "--exposure", 3, "-o", "b.exr")
    assert read("a.exr") == read("b.exr")
    for value in (0, -1, "inf", "nan"):
        assert run("player", "render", "x.pnb", *LOOK, "--exposure", value, "-o", "no.png").returncode == 1, value
        assert run("bake", "reference", "x.vis.h5", "--frame", 0, "--exposure", value, "-o", "no.png").returncode == 1, value


def check_background():
    """A background keeps its colour under any light."""
    look = [*LOOK, "--background", "0.2/0.4/0.6", "--light"]
    good("player", "render", "x.pnb", *look, "bright", "-o", "a.png")
    good("bake", "reference", "x.vis.h5", "--frame", 0, "--samples", 64, *look, "bright.hdr", "-o", "b.png")
    for path in ("a.png", "b.png"):
        assert Image.open(path).convert("RGB").getpixel((0, 0)) == (124, 170, 203), path


def check_overlays():
    """A lobe in a picture under a bright light is not black."""
    look = [*LOOK, "--light", "bright"]
    good("player", "render", "x.pnb", *look, "-o", "a.png")
    good("player", "render", "x.pnb", *look, "--lobe", 40, "-o", "b.png")
    a, b = (np.asarray(Image.open(path).convert("RGB"), int) for path in ("a.png", "b.png"))
    lobe = (a != b).any(-1)
    assert lobe.sum() > 50 and b[lobe].mean() > 60, (lobe.sum(), b[lobe].mean())


def check_sequence():
    """One exposure for all frames and all slices, of the first frame of the chosen clips."""
    look = [*LOOK, "--light", "bright", "--report", "r.json"]
    good("player", "render", "x.pnb", *look, "--clip", "squat", "--frame", 0, "-o", "one.png")
    first = exposure_of("r.json")
    good("player", "render", "x.pnb", *look, "--clip", "squat", "-o", "s.%d.png")
    assert exposure_of("r.json") == first or abs(exposure_of("r.json") / first - 1) < 0.1, "another camera at most"
    whole = exposure_of("r.json")
    good("player", "render", "x.pnb", *look, "--clip", "squat", "--frames", "3:6:2", "-o", "t.%d.png")
    assert exposure_of("r.json") == whole and read("t.3.png") == read("s.3.png") and read("t.5.png") == read("s.5.png")


def check_pairs():
    """Model and truth have the exposure of the truth, in pictures, on sheets and in the figures."""
    look = [*LOOK, "--light", "bright", "--truth", "x.truth.pnb", "--clip", "squat", "--frames", "0:2", "--report", "r.json"]
    look += ["--framing", "clips"]
    good("player", "measure", "x.pnb", *look, "--flip", "--csv", "auto.csv", "--sheet", "auto.png")
    factor = exposure_of("r.json")
    good("player", "render", "x.pnb", *look, "-o", "m.%d.png")
    assert exposure_of("r.json") == factor
    good("player", "render", "x.pnb", *look, "-o", "t.%d.png", "--source", "truth")
    assert exposure_of("r.json") == factor
    check_shown("t.0.png", "truth")
    good("player", "measure", "x.pnb", *look, "--flip", "--csv", "fixed.csv", "--sheet", "fixed.png", "--exposure", f"{factor:.4g}")
    assert read("auto.csv") == read("fixed.csv") and read("auto.png") == read("fixed.png")
    # Figures of visibility do not depend on the exposure.
    good("player", "measure", "x.pnb", *look, "--flip", "--csv", "other.csv", "--exposure", 1)
    rows = [list(csv.DictReader(open(path))) for path in ("auto.csv", "other.csv")]
    for a, b in zip(*rows):
        for key in ("ambient_error_mean", "ambient_error_max", "rms_v", "relative_error", "out_of_range"):
            assert a[key] == b[key], key


def check_reference():
    """Brute force exposes alike, so the printed factor makes a pair with the player's picture."""
    for name in LIGHTS:
        words = ["bake", "reference", "x.vis.h5", "--frame", 0, *LOOK, "--light", name + ".hdr", "--samples", 64]
        said = good(*words, "-o", "a.png", "--report", "r.json").stdout
        check_shown("a.png", name)
        good(*words, "-o", "b.png", "--exposure", said.split("--exposure ")[1].split()[0])
        assert read("a.png") == read("b.png"), name
        good(*words, "-o", "a.exr")
        good(*words, "-o", "b.exr", "--exposure", 3)
        assert read("a.exr") == read("b.exr"), name


def check_scene():
    for light in ("bright", "dark"):
        with open("s.json", "w") as file:
            json.dump({"version": 1, "characters": [{"asset": "x.pnb", "clip": "squat"}], "light": {"name": light},
                       "ground": {"size": 3, "resolution": 32}}, file)
        for tool, words in (("player", ["render"]), ("bake", ["reference", "--samples", 32, "--brdf", "lambert"])):
            good(tool, *words, "--scene", "s.json", "--size", "96x96", "-o", "a.png", "--report", "r.json")
            check_shown("a.png", (tool, light))
            good(tool, *words, "--scene", "s.json", "--size", "96x96", "-o", "b.png", "--exposure", exposure_of("r.json"))
            assert read("a.png") == read("b.png"), (tool, light)


with tempfile.TemporaryDirectory() as folder:
    os.chdir(folder)
    make_assets()
    check_render()
    check_linear_and_other_channels()
    check_background()
    check_overlays()
    check_sequence()
    check_pairs()
    check_reference()
    check_scene()
    os.chdir("/")
print("ok")
