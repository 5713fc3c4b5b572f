"""`penumbra doctor`: what is installed and what is missing, and with a file what would go wrong with it."""
import json
import os
import platform
import re
import shutil
import tempfile

from farm.config import files_of
from make import pictures, programs
from make.failure import INVALID, Failure
from make.make import missing

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
    python = os.access("/usr/bin/python3", os.X_OK)
    if not python:
        line("missing", "/usr/bin/python3, for farms")
    for module, (package, use) in MODULES.items():
        if python and programs.ask("/usr/bin/python3", "-c", f"import {module}").returncode != 0:
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


def facts_of(said, names):
    """Prints these facts of what `penumbra-bake info` said. Returns all of them."""
    found = dict(re.findall(r"^(\w+) +(\S.*)$", said, re.M))
    for name in names:
        if name in found:
            text = found[name] + (" m" if name == "size" else "")
            line(name, text if len(text) < 100 or name == "slots" else text[:97] + "...")
    return found


def is_own(path):
    """Prints what is in a picture or in a file of ours. Tells whether this is one, and no mesh and no clips."""
    if not os.path.isfile(path):
        return False
    if pictures.kind_of(path):
        for name, text in pictures.describe(path):
            line(name, text)
        return True
    known = programs.ask(programs.find("penumbra-bake"), "info", path)
    if known.returncode != 0 or re.search("^format +(rig|point cache)$", known.stdout, re.M):
        return False
    facts_of(known.stdout, ("format", "vertices", "triangles"))
    return True


def check_rig(files, meshes):
    """Says what would go wrong with a mesh and the files of its clips. `meshes` are words that choose parts of it.
    Returns whether something stops `make`."""
    bake, said = programs.find("penumbra-bake"), ""
    for path in files:
        known = programs.ask(bake, "info", path) if os.path.isfile(path) else None
        if known and known.returncode == 0:
            said += known.stdout
            if path == files[0]:
                facts_of(said, ("format", "vertices", "triangles", "size", "slots", "joints"))
    asked = [["visibility", *files, "--rays", "256", *meshes]]
    if re.search("^format +rig$", said, re.M):
        asked.append(["fields", *files, *meshes])
    with tempfile.TemporaryDirectory() as folder:
        probes = [programs.ask(bake, *words, "-o", os.path.join(folder, "x.h5"), "--dry-run") for words in asked]
    for probe in probes:
        if probe.returncode != 0:
            line("cannot be baked", programs.complaint(probe).removeprefix("penumbra-bake: "))
            return 1
    dry = probes[0]
    clips = json.loads(re.search("^clips: (.*)$", dry.stdout, re.M)[1])
    still = dry.stdout.startswith("1 frames ")
    line("clips", "none" if still else f"{len(clips)}: {', '.join(clips)}"[:110])
    if found := re.search("^estimate from a probe of [^:]*: (.*)$", dry.stdout, re.M):
        line("bake, all keys", found[1])
    if still:
        line("note", "a single pose: nothing is held out; files of clips may stand behind a rig")
    elif len(clips) == 1:
        line("note", "a single clip: blocks of it are held out; more clips make a better model")
    warn(said, dry.stderr, files)
    return 0


def warn(said, complaints, files):
    """Prints each warning once: the notes that `info` said, and the complaints of a bake."""
    notes = re.findall(r"^(?:notes| +-) +(?!name )(\S.*)$", said, re.M)
    warned = [*notes, *re.findall(r"^penumbra-bake: warning: (.*)$", complaints, re.M)]
    for path in files:
        warned = [part for text in warned for part in text.removeprefix(path + ": ").split(f", {path}: ")]
    for text in dict.fromkeys(warned):
        line("warning", text)
    if not warned:
        line("warnings", "none")


def doctor(files, meshes=()):
    """Returns the exit code."""
    if not files:
        return INVALID if check_machine() else 0
    for path in files:
        if not files_of(path):
            raise missing(path)
    rig = [path for path in files if not is_own(path)]
    return INVALID if rig and check_rig(rig, meshes) else 0
