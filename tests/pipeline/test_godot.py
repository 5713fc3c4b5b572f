"""Godot 3 reads exports: every vertex has the place and the colour that the file has.

Skipped where there is no Godot 3 without a window: PENUMBRA_GODOT names it, else godot3-server or godot3-headless are
found by PATH (scripts/setup --godot).

usage: test_godot.py BIN
"""
import json
import os
import shutil
import subprocess
import sys
import tempfile

import numpy as np
from export_cases import export_cases, vertices_of, worst_of_nearest

HERE = os.path.dirname(os.path.abspath(__file__))


def godot(program, folder, *words):
    """Runs Godot on the project in a folder, which is also its home. It complains of much that does no harm."""
    home = dict(os.environ, HOME=folder, XDG_DATA_HOME=folder, XDG_CONFIG_HOME=folder, XDG_CACHE_HOME=folder)
    done = subprocess.run([program, "--path", folder, *words], env=home, capture_output=True, text=True, timeout=100)
    assert done.returncode == 0, (words, done.returncode, done.stdout[-2000:], done.stderr[-2000:])


def main():
    found = [os.environ.get("PENUMBRA_GODOT"), shutil.which("godot3-server"), shutil.which("godot3-headless")]
    program = next((one for one in found if one), None)
    if not program:
        print("skipped: no Godot 3 (PENUMBRA_GODOT, or godot3-server by PATH)")
        sys.exit(77)
    with tempfile.TemporaryDirectory() as folder:
        paths = export_cases(folder)
        with open(os.path.join(folder, "project.godot"), "w") as project:
            project.write("config_version=4\n")
        shutil.copy(os.path.join(HERE, "godot", "read_glb.gd"), folder)
        godot(program, folder, "-e", "-q")  # the editor imports what is new, and quits
        godot(program, folder, "-s", "read_glb.gd", *map(os.path.basename, paths))
        for path in paths:
            read = json.load(open(path + ".json"))
            assert len(read) == 1, (path, len(read))
            positions, colors = (np.array(read[0][name], float) for name in ("positions", "colors"))
            wanted = vertices_of(path)
            there, back = (worst_of_nearest(a, b, 1e-5) for a, b in
                           ((wanted[:2], (positions, colors[:, :3])), ((positions, colors[:, :3]), wanted[:2])))  # fmt: skip
            print("%s: %d vertices, colours within %.5f, %d of %d morph targets" %
                  (os.path.basename(path), len(positions), max(there, back), read[0]["targets"], wanted[2]))
            # Godot stores colours with 8 bits, cut off.
            assert max(there, back) < 1.001 / 255 and len(positions) == len(wanted[0]) and np.ptp(colors[:, 0]) > 0.1


main()
