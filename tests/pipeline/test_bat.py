"""A bat of DirectX from file to picture: its wings are membranes with the light behind them, with the shadows of what comes
through and without, beside brute force. Soft light first, then a sun. The bat is synthetic: no found one was at hand.

usage: test_bat.py BIN [FOLDER]    FOLDER keeps the pictures
"""
import os
import sys
import tempfile

import numpy as np
from PIL import Image

from programs import BIN, good

BAT = os.path.abspath(os.path.join(BIN, "..", "samples", "bat.x"))
SKIN = "membrane:rho=0.25/0.2/0.2,tau=0.45/0.25/0.2"
SOFT = "disc:direction=0.3/0.9/-0.4,angle=40,radiance=5+uniform:radiance=0.3"
SUN = "sun:direction=0.3/0.9/-0.4,angle=3,irradiance=5+uniform:radiance=0.3"
LOOK = ["--camera", "yaw=25,pitch=-55,distance=2.1,target=0/0/0", "--size", "320x200", "--exposure", 0.6, "--background",
        "0.2/0.2/0.2"]
FRAMES = 12, 23  # learned, held out


def make():
    good("bake", "visibility", BAT, "--two-sided", "--fps", 8, "--rays", 256, "--order", 5, "--blocks", 6, "-o", "bat.vis.h5")
    good("fit", "visibility", "bat.vis.h5", "--holdout", "flap#6", "--model", "linear", "-o", "bat.model.h5")
    for name, spec in (("own", SKIN), ("open", SKIN + ",back=open")):
        good("fit", "brdf", "--analytic", spec, "--name", name, "-o", name + ".brdf.h5")
    good("fit", "light", "--analytic", SOFT, "--order", 4, "--name", "soft", "-o", "soft.light.h5")
    good("fit", "light", "--analytic", SUN, "--order", 4, "--name", "sun", "--factor", "-o", "sun.light.h5")
    good("pack", "asset", "bat.model.h5", "--brdf", "own.brdf.h5", "--brdf", "open.brdf.h5", "--light", "soft.light.h5",
         "--light", "sun.light.h5", "-o", "bat.pnb")
    good("pack", "truth", "bat.vis.h5", "-o", "bat.truth.pnb")


def linear(path):
    value = np.asarray(Image.open(path).convert("RGB"), float) / 255
    return np.where(value <= 0.04045, value / 12.92, ((value + 0.055) / 1.055) ** 2.4)


def drawn(frame, name, light, *words):
    good("player", "render", "bat.pnb", "--truth", "bat.truth.pnb", "--clip", "all", "--frames", f"{frame}:{frame + 1}",
         "--light", light, *LOOK, *words, "-o", name + ".%02d.png")
    return linear(f"{name}.{frame:02d}.png")


def traced(frame, name, light, *words):
    path = f"{name}.{frame:02d}.png"
    good("bake", "reference", "bat.vis.h5", "--frame", frame, "--brdf", SKIN, "--light", light, *words, "--samples", 400,
         *LOOK, "-o", path)
    return linear(path)


def error(picture, truth):
    """Returns the relative RMSE over pixels that either covers fully: edges depend on how pixels are sampled."""
    inside = np.abs(truth - truth[0, 0]).sum(2) > 1e-3
    for axis in (0, 1):
        for step in (-1, 1):
            inside &= np.roll(inside, step, axis)
    return float(np.sqrt(((picture - truth)[inside] ** 2).mean() / (truth[inside] ** 2).mean()))


def check(light, spec, bounds, *words):
    """`bounds`: of baked visibility, of the model; and what an unshadowed back is worse than."""
    for frame in FRAMES:
        truth = traced(frame, light + ".truth", spec, *words)
        baked = error(drawn(frame, light + ".baked", light, "--brdf", "own", "--source", "truth"), truth)
        model = error(drawn(frame, light + ".model", light, "--brdf", "own"), truth)
        gpu = error(drawn(frame, light + ".gpu", light, "--brdf", "own", "--path", "glsl"), truth)
        unshadowed = error(drawn(frame, light + ".open", light, "--brdf", "open", "--source", "truth"), truth)
        print(f"{light}, frame {frame}: baked {baked:.3f}, model {model:.3f}, GPU {gpu:.3f}, unshadowed {unshadowed:.3f}")
        assert baked < bounds[0] and model < bounds[1] and gpu < bounds[1] and unshadowed > bounds[2], (light, frame)


def main():
    with tempfile.TemporaryDirectory() as work:
        os.chdir(sys.argv[2] if len(sys.argv) > 2 else work)
        make()
        check("soft", SOFT, (0.08, 0.1, 0.2), "--light-order", 4)
        check("sun", SUN, (0.06, 0.06, 0.2))


main()
