#!/usr/bin/python3
"""One frame of the demo's character in a web page (three.js) beside penumbra-player render, and FLIP of the two.

compare_web.py BIN DEMO_OUT NODE_MODULES -o OUT.png     after `scripts/demo --web`

Both draw clay under the sky `city` with one camera and one exposure: the player from the asset's light of order 5 and a
fitted material, the page from the picture of the sky and a material of three.js without specular light."""
import base64
import json
import pathlib
import subprocess
import sys
import tempfile

import numpy as np
from PIL import Image

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent))
import flip
from usage import ArgumentParser

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
LOOK = {"size": 512, "yaw": 35, "pitch": 12, "fov": 30, "distance": 4.2, "target": [0, 0.9, 0], "exposure": 1.0,
        "seconds": 20 / 30, "albedo": [0.75, 0.7, 0.65]}
FRAME = 20


def draw_page(arguments, files):
    """Returns the picture of the page, and the largest distance of its vertices from the asset's."""
    data = arguments.demo / "web/data"
    for name in ("walk.glb", "city.exr"):
        (files / name).symlink_to((data / name).resolve())
    with open(files / "man.glb", "wb") as file:
        subprocess.run(["gzip", "-dc", str(data / "man.glb.gz")], stdout=file, check=True)
    (files / "look.json").write_text(json.dumps(LOOK))
    command = ["node", ROOT / "tests/pipeline/web/chromium.mjs", (arguments.demo / "web/penumbra-player").resolve(),
               arguments.modules, files, "/usr/bin/chromium", "beside_player.html"]
    found = json.loads(subprocess.run([str(c) for c in command], check=True, capture_output=True, text=True).stdout)
    if "error" in found:
        sys.exit(f"compare_web: {found['error']}")
    (files / "page.png").write_bytes(base64.b64decode(found["picture"].split(",")[1]))
    return files / "page.png", found["matchError"]


def draw_player(arguments, out):
    camera = ",".join(f"{name}={LOOK[name]}" for name in ("yaw", "pitch", "fov", "distance"))
    camera += ",target=" + "/".join(str(x) for x in LOOK["target"])
    subprocess.run([str(c) for c in (arguments.bin / "penumbra-player", "render", arguments.demo / "composed.pnb",
                    "--clip", "Walk", "--frame", FRAME, "--size", f"{LOOK['size']}x{LOOK['size']}", "--camera", camera,
                    "--exposure", LOOK["exposure"], "--suns", "off", "-o", out)], check=True, capture_output=True)


def main():
    parser = ArgumentParser(__doc__)
    parser.add_argument("bin", type=pathlib.Path)
    parser.add_argument("demo", type=pathlib.Path)
    parser.add_argument("modules", type=pathlib.Path)
    parser.add_argument("-o", "--output", required=True)
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        files = pathlib.Path(folder)
        draw_player(arguments, files / "player.png")
        page, match_error = draw_page(arguments, files)
        reference, test = flip.read_srgb(files / "player.png"), flip.read_srgb(page)
        covered = np.asarray(Image.open(files / "player.png").convert("RGBA"))[..., 3] == 255
        values = flip.flip_map(reference, test)
        pair = np.concatenate([reference, test], axis=1)
        Image.fromarray((255 * pair).round().astype(np.uint8)).save(arguments.output, optimize=True)
        off = (255 * np.abs(reference - test))[covered]
    print(f"FLIP {values.mean():.4f} over the picture, {values[covered].mean():.4f} over the character; "
          f"mean difference {off.mean():.2f} / 255, vertices off by {match_error:.1e} diagonals")


if __name__ == "__main__":
    main()
