"""The run time for other processors and systems, as emulators run it, held against libpenumbra of this machine.

usage: test_cross.py BIN

Builds the presets `aarch64` (run by QEMU) and `windows` (run by Wine), which takes minutes of one core the first time.
One whose packages are missing is left out (scripts/setup --arm, scripts/setup --windows); without both it is skipped.
"""
import glob
import os
import shutil
import subprocess
import sys
import tempfile
import typing

import numpy as np

from programs import must

BIN = os.path.abspath(sys.argv[1])
ROOT = os.path.abspath(os.path.join(os.path.dirname(__file__), "..", ".."))
BAKE, FIT, PACK = (os.path.join(BIN, "penumbra-" + name) for name in ("bake", "fit", "pack"))
MAN = os.path.join(BIN, "..", "samples", "capsule_man.glb")
PROGRAM = os.path.join(ROOT, "tests/pipeline/cross/frames.c")
SEEDS = sorted(glob.glob(os.path.join(ROOT, "tests/fuzz/corpus/fuzz_asset/*")))


class Target(typing.NamedTuple):
    name: str  # name of the preset
    compiler: str
    emulator: list
    suffix: str  # suffix of programs
    library: str  # library that a program links, from the folder of the build
    setup: str  # the part of scripts/setup that has all this
    # The bound of E of an additive model. Windows' C library rounds angles of the pose otherwise in the last bit, so
    # that now and then a weight, a whole number of 16 bits, is the next one.
    additive: float


TARGETS = [
    Target("aarch64", "aarch64-linux-gnu-gcc", ["qemu-aarch64-static", "-L", "/usr/aarch64-linux-gnu"], "",
           "runtime/libpenumbra.so", "--arm", 1e-6),
    Target("windows", "x86_64-w64-mingw32-gcc-posix", ["/usr/lib/wine/wine64"], ".exe", "runtime/libpenumbra.dll.a",
           "--windows", 1e-5),
]


def has_tools(target):
    for tool in (target.compiler, target.compiler.replace("gcc", "g++"), target.emulator[0]):
        if not shutil.which(tool):
            print(f"{target.name}: left out, no {tool}: scripts/setup {target.setup}")
            return False
    return True


def compiled(compiler, program, library):
    rpath = [] if program.endswith(".exe") else [f"-Wl,-rpath,{os.path.dirname(os.path.abspath(library))}"]
    must(compiler, "-std=c99", "-Wall", "-Wextra", "-Werror", "-I", os.path.join(ROOT, "runtime"), PROGRAM, library, *rpath,
         "-o", program)
    return program


def built(target, folder):
    """The program for a target, beside the DLL where that is one."""
    subprocess.run(["cmake", "--preset", target.name], cwd=ROOT, check=True, stdout=subprocess.DEVNULL)
    build = os.path.join(ROOT, "build", target.name)
    must("cmake", "--build", build, "--target", "penumbra")
    for dll in glob.glob(os.path.join(build, "bin/*.dll")):
        shutil.copy(dll, folder)
    program = os.path.join(folder, target.name + target.suffix)
    return compiled(target.compiler, program, os.path.join(build, target.library))


def make_cases(folder):
    """An additive and a composed model of one character."""
    path = lambda name: os.path.join(folder, name)
    must(BAKE, "visibility", MAN, "-o", path("man.vis.h5"), "--fps", 4, "--rays", 32, "--local")
    must(BAKE, "fields", MAN, "-o", path("man.fields.h5"), "--rays", 32)
    cases = []
    for model, words in (("additive", []), ("composed", ["--fields", path("man.fields.h5")])):
        must(FIT, "visibility", path("man.vis.h5"), "-o", path(model + ".model.h5"), "--model", model, *words)
        must(PACK, "asset", path(model + ".model.h5"), "-o", path(model + ".pnb"), "--precision", "i8")
        cases.append(path(model + ".pnb"))
    return cases


def files_to_open(asset):
    """Seeds of the fuzz target, an asset that is cut short, and a file that is not there."""
    cut = asset + ".cut"
    with open(asset, "rb") as whole, open(cut, "wb") as file:
        file.write(whole.read()[:5000])
    return [*SEEDS, cut, asset + ".none"]


def numbers(asset, *command):
    """Positions and E of all frames [F,V,4], E of the ground, and the statuses of other files."""
    out = asset + ".numbers"
    environment = dict(os.environ, WINEDEBUG="-all", WINEPREFIX=os.path.join(os.path.dirname(asset), "wine"))
    said = subprocess.run([*command, asset, out, *files_to_open(asset)], check=True, stdout=subprocess.PIPE, env=environment).stdout
    with open(out, "rb") as file:
        frame_count, vertices = np.fromfile(file, np.uint32, 2)
        frames = np.fromfile(file, np.float32, 4 * frame_count * vertices).reshape(frame_count, 4 * vertices)
        ground = np.fromfile(file, np.float32)
    os.remove(out)
    positions, e = frames[:, : 3 * vertices], frames[:, 3 * vertices :]
    frames = np.concatenate([positions.reshape(frame_count, vertices, 3), e[..., None]], axis=2)
    return frames, ground, said.decode().split()


def largest_step(a, b):
    """The largest difference of arrays of the same size."""
    assert a.size == b.size and a.size > 0 and np.isfinite(a).all() and np.isfinite(b).all()
    return float(np.abs(a - b).max())


def check(target, ours, theirs, bound):
    (frames, ground, statuses), (other_frames, other_ground, other_statuses) = ours, theirs
    assert frames[..., :3].tobytes() == other_frames[..., :3].tobytes(), "positions"
    assert frames[..., 3].std() > 0.05, "nothing is in shadow"
    step = largest_step(frames[..., 3], other_frames[..., 3])
    print(f"{target}: {len(frames)} frames, positions equal, E within {step:.1e}")
    assert step <= bound
    if ground.size > 0:
        assert ground.min() < 0.9
        assert largest_step(ground, other_ground) <= bound
    assert statuses == other_statuses and statuses[-2:] == ["PENUMBRA_INVALID_ASSET", "PENUMBRA_IO_ERROR"], statuses


if __name__ == "__main__":
    targets = [target for target in TARGETS if has_tools(target)]
    if not targets:
        sys.exit(77)
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:  # Wine's server ends a little later
        programs = [(target, built(target, folder)) for target in targets]
        here = compiled("gcc", os.path.join(folder, "here"), os.path.join(BIN, "../runtime/libpenumbra.so"))
        additive, composed = make_cases(folder)
        for asset in (additive, composed):
            ours = numbers(asset, here)
            for target, program in programs:
                name = f"{target.name}, {os.path.basename(asset)}"
                bound = target.additive if asset == additive else 1e-4
                check(name, ours, numbers(asset, *target.emulator, program), bound)
    print("run time elsewhere: ok")
