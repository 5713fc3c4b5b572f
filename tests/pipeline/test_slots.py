# Materials of parts: from the nodes and materials of a glTF file through bake, fit and pack to the player, whose
# pictures are those of ray tracing with the same materials.
# Usage: test_slots.py BIN_FOLDER
import json
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
from PIL import Image

BIN = Path(sys.argv[1]).resolve()
RIG = BIN.parent / "samples" / "props.glb"
RED, BLUE = "lambert:color=0.8/0.1/0.1", "phong:exponent=10,color=0.1/0.1/0.8"
VIEW = ["--size", "160x160", "--camera", "yaw=30,pitch=10", "--exposure", "0.5"]


def run(tool, *words, code=0):
    result = subprocess.run([BIN / f"penumbra-{tool}", *map(str, words)], capture_output=True, text=True, timeout=300)
    assert result.returncode == code, (tool, words, result.returncode, result.stderr)
    return result


def picture(path):
    return np.asarray(Image.open(path).convert("RGBA"), float)


def main(folder):
    run("bake", "visibility", RIG, "-o", folder / "x.vis.h5", "--fps", 4, "--rays", 256)
    slots = run("bake", "info", folder / "x.vis.h5").stdout
    slots = next(line for line in slots.splitlines() if line.split()[:1] == ["slots"]).split(None, 1)[1].split(", ")
    assert len(slots) > 1, slots
    assert "body/default" in slots, slots
    chosen = "body"
    run("fit", "visibility", folder / "x.vis.h5", "-o", folder / "x.model.h5", "--model", "linear")
    for name, spec in (("red", RED), ("blue", BLUE)):
        run("fit", "brdf", "--analytic", spec, "-o", folder / f"{name}.brdf.h5")
    (folder / "white.hdr").write_bytes(b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 4 +X 8\n" + bytes((128, 128, 128, 129)) * 32)
    brdfs = ["--brdf", folder / "red.brdf.h5", "--brdf", folder / "blue.brdf.h5"]
    run("fit", "light", folder / "white.hdr", "-o", folder / "e.light.h5")
    pack = ["asset", folder / "x.model.h5", *brdfs, "--light", folder / "e.light.h5"]
    run("pack", *pack, "-o", folder / "plain.pnb")
    run("pack", *pack, "--slot", f"{chosen}=phong", "-o", folder / "slots.pnb")

    def render(asset, name, *options):
        run("player", "render", folder / asset, "-o", folder / name, "--source", "model", *VIEW, *options)
        return picture(folder / name)

    red, blue = render("plain.pnb", "red.png"), render("plain.pnb", "blue.png", "--brdf", "phong")
    mixed = render("slots.pnb", "mixed.png")
    assert np.array_equal(mixed, render("plain.pnb", "same.png", "--slot", f"{chosen}=phong"))
    glsl = render("slots.pnb", "glsl.png", "--path", "glsl")
    assert np.abs(glsl - mixed).max() <= 2, np.abs(glsl - mixed).max()
    # Every pixel is as in one of the two pictures of one material, and both occur.
    from_red, from_blue = (np.abs(mixed - p).max(-1) <= 1 for p in (red, blue))
    covered = mixed[..., 3] > 254
    assert (from_red & ~from_blue & covered).sum() > 100 and (from_blue & ~from_red & covered).sum() > 20
    assert (~(from_red | from_blue) & covered).sum() < 0.02 * covered.sum()

    run("bake", "reference", folder / "x.vis.h5", "--frame", 0, "--brdf", RED, "--slot", f"{chosen}={BLUE}", *VIEW,
        "--light", folder / "white.hdr", "-o", folder / "truth.png", "--samples", 512)
    truth = picture(folder / "truth.png")
    both = from_blue & ~from_red & covered & (truth[..., 3] > 254)  # the chosen part
    rmse = float(np.sqrt(np.mean((truth - mixed)[both] ** 2)))
    swapped = float(np.sqrt(np.mean((truth - red)[both] ** 2)))
    print(f"slots: {', '.join(slots)}; RMSE against ray tracing {rmse:.2f} / 255, without the slot {swapped:.2f}")
    assert rmse < 16 and rmse < swapped / 4

    for asset, message in (("slots.pnb", "no slot"), ("plain.pnb", "no slot")):
        error = run("player", "render", folder / asset, "-o", folder / "no.png", "--slot", "nothing=phong", code=1).stderr
        assert message in error and slots[0] in error, error
    for words in ("nothing=phong", f"{chosen}=ggx", "phong", f"{chosen}="):
        run("pack", *pack, "--slot", words, "-o", folder / "no.pnb", code=1)
    run("bake", "reference", folder / "x.vis.h5", "--frame", 0, "--slot", f"{chosen}=glass", "-o", folder / "no.png", code=1)
    assert not list(folder.glob("no.*"))


with tempfile.TemporaryDirectory() as name:
    main(Path(name))
