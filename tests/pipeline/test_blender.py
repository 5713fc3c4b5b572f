"""The add-on for Blender: both routes on a character with modifiers, a shape key, two materials and a box on a bone.

Skipped where there is no Blender: PENUMBRA_BLENDER names it, else it is found by PATH. With --cycles, as scripts/test
--tools runs it, ambient occlusion is also held against Cycles' own bake.

usage: test_blender.py BIN [--cycles]"""
import importlib.util
import os
import pathlib
import subprocess
import sys
import tempfile

import h5py
import numpy as np
from run_blender import run

BIN = os.path.abspath(sys.argv[1])
HERE = os.path.dirname(os.path.abspath(__file__))
SCRIPTS = os.path.join(HERE, "..", "..", "scripts", "blender")
MAX_RMS, MIN_SPEED = 0.03, 5.0


def check_refused(what, argument, part):
    try:
        what(argument)
    except Exception as failed:
        assert type(failed).__name__ == "Failed" and part in str(failed), failed
    else:
        sys.exit(f"test_blender: not refused: {argument}")


def check_programs():
    """Command lines, names of files on another system, and progress, which need no Blender."""
    spec = importlib.util.spec_from_file_location("programs", os.path.join(SCRIPTS, "penumbra_addon", "programs.py"))
    module = sys.modules["programs"] = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    art = pathlib.PureWindowsPath("C:\\art\\hero ü.npz")
    wsl = module.Programs(("wsl",), "/opt/penumbra/")
    assert wsl.program("bake") == ["wsl", "/opt/penumbra/penumbra-bake"], wsl.program("bake")
    assert wsl.argument(art) == "/mnt/c/art/hero ü.npz", wsl.argument(art)
    docker = module.Programs(("docker", "run", "penumbra"), path_from="C:\\art", path_to="/art")
    assert docker.argument(art) == "/art/hero ü.npz" and docker.argument("C:\\art") == "C:\\art"
    inside = module.Programs(("docker",), path_from="c:/Art\\", path_to="/")
    assert inside.argument(pathlib.PureWindowsPath("C:\\ART\\x\\y.npz")) == "/x/y.npz"
    check_refused(docker.argument, pathlib.PureWindowsPath("C:\\artist\\x.npz"), "has no name where")
    check_refused(wsl.argument, pathlib.PureWindowsPath("\\\\server\\share\\x.npz"), "has no name where")
    here = module.Programs(("nice",), path_from="/a", path_to="/b")
    assert [here.argument(pathlib.PurePosixPath(p)) for p in ("/a/x", "/ab/x", "/A/x")] == ["/b/x", "/ab/x", "/A/x"]
    words = module.words_of('"C:\\Program Files\\d.exe" run -v "C:\\my art:/art"', windows=True)
    assert words == ("C:\\Program Files\\d.exe", "run", "-v", "C:\\my art:/art"), words
    assert module.words_of("a\\ b 'c d'", windows=False) == ("a b", "c d")
    check_refused(lambda text: module.words_of(text, windows=True), 'wsl "', "is no command line")
    assert not {"LD_LIBRARY_PATH", "PYTHONPATH"} & set(module.environment())
    for line, expected in (
        ("openjd_progress: 42.0", (0.42, "x")),
        ("openjd_status: tracing", (0.1, "tracing")),
        ("openjd_progress: rubbish", (0.1, "x")),
        ("openjd_progress: 1e9", (1.0, "x")),
        ("rubbish", (0.1, "x")),
    ):
        assert module.progress_of(line, 0.1, "x") == expected, line
    here = module.Programs(folder=BIN)
    check_refused(lambda p: list(here.run("bake", "visibility", p, "-o", "x.vis.h5")), pathlib.Path("no such.npz"), "no such")


def check_positions(folder):
    """`penumbra-pack export --positions` is what the bake has, in the order of the file; it goes with a bake alone."""
    bake, positions = os.path.join(folder, "bend.vis.h5"), os.path.join(folder, "positions.npy")
    words = ["visibility", os.path.join(BIN, "..", "samples", "bend.glb"), "-o", bake, "--rays", "16", "-q"]
    subprocess.run([os.path.join(BIN, "penumbra-bake"), *words], check=True)
    export = [os.path.join(BIN, "penumbra-pack"), "export", bake, "-o", positions, "--positions", "-q"]
    subprocess.run(export, check=True)
    with h5py.File(bake) as file:
        expected = file["frames/positions"][:][:, file["mesh/source_vertex"][:]]
    assert np.array_equal(np.load(positions), expected), "positions of a bake"
    for wrong in (["--as", "table", "-o", positions + ".png"], ["--clips", "bend"], ["--rate", "5"]):
        assert subprocess.run(export + wrong, capture_output=True).returncode == 1, wrong


def lines_of(text, *starts):
    return [line for line in text.splitlines() if line.startswith(starts)]


check_programs()
with tempfile.TemporaryDirectory() as folder:
    check_positions(folder)
    archive = os.path.join(folder, "penumbra_addon.zip")
    subprocess.run([sys.executable, os.path.join(SCRIPTS, "make_zip"), "-o", archive], check=True, stdout=subprocess.DEVNULL)
    said = run("blender_steps.py", archive, BIN, folder)
    print("\n".join(lines_of(said, "route", "without", "clips", "roles", "compare", "stopped", "export", "show")))
    if "PASSED" not in said:
        sys.exit("test_blender: the steps did not come to their end\n" + said[-4000:])
    if "--cycles" in sys.argv:
        said = run("blender_cycles.py", SCRIPTS, BIN, folder, "1024")
        rms, speed = (float(word) for word in lines_of(said, "CYCLES")[0].split()[1:])
        print("\n".join(line for line in said.splitlines() if "of Cycles' bake" in line))
        if not (rms <= MAX_RMS and speed >= MIN_SPEED):
            sys.exit(f"test_blender: rms {rms} above {MAX_RMS}, or {speed} times faster, below {MIN_SPEED}")
