"""`penumbra doctor`: what is installed and what is missing, and with a file what would go wrong with it."""
import os
import platform
import re
import shutil
import tempfile

from farm.config import files_of
from make import pictures, programs
from make.failure import INVALID, UNREADABLE, Failure

# The scripts of farms run with /usr/bin/python3. Python module or program -> (package of Debian, what needs it)
MODULES = {"yaml": ("python3-yaml", "farms"), "numpy": ("python3-numpy", "pictures of farms"),
           "h5py": ("python3-h5py", "pictures of farms"), "PIL": ("python3-pil", "pictures of farms")}
TOOLS = {"snakemake": ("snakemake", "farms"), "ffmpeg": ("ffmpeg", "videos of sequences"), "npm": ("npm", "web pages, samples")}
TETRAHEDRON = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"


def line(name, text):
    print(f"{name:<22} {text}", flush=True)


def versions():
    """Prints each program with its version. Returns how many are missing."""
    missing = 0
    for name in programs.NAMES:
        try:
            said = programs.ask(programs.find(name), "--version")
            good = said.returncode == 0
            line(name, said.stdout.splitlines()[0] if good else f"does not start: {programs.complaint(said)}")
        except Failure as error:
            good = False
            line(name, str(error))
        except OSError as error:
            good = False
            line(name, f"does not start: {error.strerror}")
        missing += not good
    return missing


def converter():
    """Says as findConverter() of formats/rig/fbx/fbx_convert.cpp looks for it."""
    named = os.environ.get("PENUMBRA_FBX2GLTF")
    if named == "off":
        return "assimp (PENUMBRA_FBX2GLTF=off)"
    data = os.environ.get("XDG_DATA_HOME") or os.path.expanduser("~/.local/share")
    found = named or shutil.which("FBX2glTF") or shutil.which(os.path.join(data, "penumbra", "FBX2glTF"))
    if not found:
        return "assimp, which reads some FBX files; scripts/setup --fbx fetches FBX2glTF for the others"
    return found if os.access(found, os.X_OK) else f"{found}: is no program (PENUMBRA_FBX2GLTF)"


def simd_path():
    """Says which kernels the programs take (sh/kernel.h)."""
    if os.environ.get("PENUMBRA_NO_SIMD"):
        return "portable (PENUMBRA_NO_SIMD is set)"
    if platform.machine() != "x86_64":
        return f"portable, on {platform.machine()}"
    try:
        with open("/proc/cpuinfo") as file:
            flags = set(re.search(r"^flags\s*:(.*)$", file.read(), re.M)[1].split())
    except (OSError, TypeError):
        return "not known"
    if not {"avx2", "fma", "f16c"} <= flags:
        return "portable"
    return "AVX-512" if {"avx512f", "avx512bw", "avx512vl", "avx512dq", "avx512_vnni"} <= flags else "AVX2"


def whole_path():
    """Runs the whole path on a tetrahedron. Returns what drew it, or raises Failure with the first complaint."""
    with tempfile.TemporaryDirectory() as folder:
        with open(os.path.join(folder, "x.obj"), "w") as file:
            file.write(TETRAHEDRON)
        steps = [("penumbra-bake", "visibility x.obj --rays 16 -o x.vis.h5"), ("penumbra-fit", "visibility x.vis.h5 -o x.model.h5"),
                 ("penumbra-fit", "brdf --analytic lambert -o x.brdf.h5"), ("penumbra-fit", "light --analytic uniform -o x.light.h5"),
                 ("penumbra-pack", "asset x.model.h5 --brdf x.brdf.h5 --light x.light.h5 -o x.pnb"),
                 ("penumbra-player", "render x.pnb --size 16x16 -o x.png --report x.json")]
        for name, words in steps:
            done = programs.ask(programs.find(name), *words.split(), cwd=folder)
            if done.returncode != 0:
                raise Failure(programs.complaint(done, f"{name}: exit code {done.returncode}"))
        with open(os.path.join(folder, "x.json")) as file:
            return re.search(r'"gl": "([^"]*)"', file.read())[1]


def drawing():
    """Prints what draws. Returns how much is wrong."""
    try:
        gl = whole_path()
    except Failure as error:
        line("whole path", f"fails: {error}")
        return 1
    software = re.search("llvmpipe|softpipe|swrast|OSMesa", gl)
    line("whole path", "bake, fit, pack and picture of a tetrahedron: works")
    line("draws with", ("software: " if software else "GPU: ") + gl)
    screen = os.environ.get("WAYLAND_DISPLAY") or os.environ.get("DISPLAY")
    line("screen", screen or "none: penumbra view needs one, penumbra render does not")
    return 0


def packages():
    for module, (package, use) in MODULES.items():
        if programs.ask("/usr/bin/python3", "-c", f"import {module}").returncode != 0:
            line("missing", f"{package}, for {use} (apt-get install {package})")
    for tool, (package, use) in TOOLS.items():
        if not shutil.which(tool):
            line("missing", f"{package}, for {use} (apt-get install {package})")


def check_machine():
    """Says what is installed. Returns how much of it stops `penumbra make`."""
    line("python", platform.python_version())
    wrong = versions()
    line("FBX converter", converter())
    line("kernels", simd_path())
    wrong += drawing() if not wrong else 0
    packages()
    return wrong


def check_file(path):
    """Says what would go wrong with a file. Returns whether something stops `penumbra make`."""
    if not files_of(path):
        raise Failure(f"{path}: no such file", UNREADABLE)
    if os.path.isfile(path) and pictures.kind_of(path):
        for name, text in pictures.describe(path):
            line(name, text)
        return 0
    bake = programs.find("penumbra-bake")
    known = programs.ask(bake, "info", path)
    if known.returncode != 0:
        line("cannot be read", programs.complaint(known).removeprefix("penumbra-bake: "))
        return 1
    found = dict(re.findall(r"^(\w+) +(\S.*)$", known.stdout, re.M))
    for name in ("format", "vertices", "triangles", "size", "slots", "joints"):
        if name in found:
            line(name, found[name] if len(found[name]) < 100 else found[name][:97] + "...")
    if found.get("format") not in ("rig", "point cache"):
        return 0
    return check_rig(bake, path, found, known.stdout)


def check_rig(bake, path, found, said):
    notes = said.partition("\nnotes")[2].splitlines()
    warned = [note.strip().lstrip("- ").removeprefix(path + ": ") for note in notes if note.strip(" -")]
    with tempfile.TemporaryDirectory() as folder:
        dry = programs.ask(bake, "visibility", path, "--rays", "256", "-o", os.path.join(folder, "x.vis.h5"), "--dry-run")
    if dry.returncode != 0:
        line("cannot be baked", programs.complaint(dry).removeprefix("penumbra-bake: "))
        return 1
    warned += [text for text in re.findall(r"^penumbra-bake: warning: (.*)$", dry.stderr, re.M)]
    clips = re.findall(r"^\s+-\s+name (.*), (?:seconds|keys) ", said, re.M)
    line("clips", f"{len(clips)}: {', '.join(clips)}"[:110])
    for text in dry.stdout.splitlines():
        if text.startswith("estimate"):
            line("bake, all keys", text.removeprefix("estimate from a ").strip())
    if len(clips) == 1:
        line("note", "a single clip: blocks of it are held out; more clips make a better model")
    elif not clips:
        line("note", "no clips: the rest pose alone is baked; give files of clips behind this one")
    for text in dict.fromkeys(warned):
        line("warning", text.removeprefix(path + ": "))
    if not warned:
        line("warnings", "none")
    return 0


def doctor(files):
    """Returns the exit code."""
    if not files:
        return INVALID if check_machine() else 0
    return INVALID if sum(check_file(path) for path in files) else 0
