"""The run time as a WebAssembly module, and the npm package around it: as node sees it, held against libpenumbra.

usage: test_web_runtime.py BIN

Builds the preset `wasm`, which takes two minutes of one core the first time. Skipped where scripts/setup --wasm or
scripts/setup --web has not run.
"""
import ctypes
import gzip
import json
import os
import shutil
import subprocess
import sys
import tempfile

import numpy as np

from programs import must

BIN = os.path.abspath(sys.argv[1])
ROOT = os.path.abspath(os.path.join(os.path.dirname(__file__), "..", ".."))
BAKE, FIT, PACK, PLAYER = (os.path.join(BIN, "penumbra-" + name) for name in ("bake", "fit", "pack", "player"))
LIBRARY = os.path.join(BIN, "..", "runtime", "libpenumbra.so")
MAN = os.path.join(BIN, "..", "samples", "capsule_man.glb")
MODULES = os.path.join(os.environ.get("XDG_DATA_HOME", os.path.expanduser("~/.local/share")), "penumbra/web/node_modules")
POINTS, SPACING = 16, 0.125  # those of web/runtime.mjs


def skip(reason):
    print("skipped:", reason)
    sys.exit(77)


def need_tools():
    for tool in ("node", "clang++-19", "wasm-ld-19", "wasm-opt"):
        if not shutil.which(tool):
            skip(f"no {tool}: scripts/setup --wasm" if tool != "node" else "no node")
    for part in ("/usr/lib/wasm32-wasi/libc.a", "/usr/lib/llvm-19/lib/wasm32-wasi/libc++abi.a"):
        if not os.path.exists(part):
            skip(f"no {part}: scripts/setup --wasm")
    for package in ("typescript", "esbuild", "@types/three"):
        if not os.path.isdir(os.path.join(MODULES, package)):
            skip(f"no npm package {package}: scripts/setup --web")


def built(folder):
    """The npm package, made anew."""
    subprocess.run(["cmake", "--preset", "wasm"], cwd=ROOT, check=True, stdout=subprocess.DEVNULL)
    must("cmake", "--build", os.path.join(ROOT, "build/wasm"), "--target", "penumbra-web")
    package = os.path.join(folder, "penumbra-player")
    wasm = os.path.join(ROOT, "build/wasm/bin/penumbra-web.wasm")
    must("node", os.path.join(ROOT, "runtime/web/build.mjs"), wasm, MODULES, package)
    return package


class Error(ctypes.Structure):
    _fields_ = [("status", ctypes.c_int), ("message", ctypes.c_char * 508)]


class Vertices(ctypes.Structure):
    _fields_ = [*((name, ctypes.c_void_p) for name in ("positions", "normals", "tangents", "coefficients", "bounced")),
                ("first", ctypes.c_size_t), ("count", ctypes.c_size_t), ("received", ctypes.c_void_p)]


class Points(ctypes.Structure):
    _fields_ = [("positions", ctypes.c_void_p), ("normals", ctypes.c_void_p), ("count", ctypes.c_size_t)]


def native(path):
    """Positions and E of every frame of an asset, and E of points on the ground where it casts."""
    lib = ctypes.CDLL(LIBRARY)
    size, handle, error = ctypes.c_size_t, ctypes.c_void_p, Error()

    def call(name, *words):
        status = getattr(lib, "penumbra_" + name)(*words, ctypes.byref(error))
        assert status == 0, (name, status, error.message)

    asset, character, scene = handle(), handle(), handle()
    call("asset_open_file", path.encode(), ctypes.byref(asset))
    info = (size * 40)()  # penumbra_asset_info: its two ints in a row take one word
    lib.penumbra_asset_get_info(asset, info)
    vertices, stride, clusters, frames = info[2], info[27], info[28], info[23]
    call("character_create", asset, ctypes.byref(character))
    casts = lib.penumbra_asset_part_count(asset) > 0
    if casts:
        call("scene_create", (handle * 1)(asset), size(1), ctypes.byref(scene))
    arrays = [np.zeros((vertices, n), np.float32) for n in (3, 3, 3, stride)]
    of = Vertices(*(a.ctypes.data for a in arrays), None, 0, vertices)
    side = (np.arange(POINTS) - POINTS // 2) * SPACING
    ground = np.zeros((POINTS, POINTS, 3), np.float32)
    ground[..., 0], ground[..., 2] = side[None, :], side[:, None]
    up = np.zeros_like(ground)
    up[..., 1] = 1
    points = Points(ground.ctypes.data, up.ctypes.data, POINTS**2)
    ambient, below, out = np.zeros(vertices, np.float32), np.zeros(POINTS**2, np.float32), []
    pointer = ctypes.c_void_p
    for frame in range(frames):
        call("character_set_frame", character, size(frame))
        call("character_evaluate", character, size(0), size(clusters), ctypes.byref(of))
        call("character_skin", character, ctypes.byref(of))
        call("character_ambient", character, ctypes.byref(of), pointer(ambient.ctypes.data))
        out += [arrays[0].ravel().copy(), ambient.copy()]
        if casts:
            call("scene_set_caster", scene, size(0), character, None)
            call("scene_ambient", scene, size(2**64 - 1), ctypes.byref(points), pointer(below.ctypes.data))
            out.append(below.copy())
    return np.concatenate(out)


def make_cases(folder):
    path = lambda name: os.path.join(folder, name)
    must(BAKE, "visibility", MAN, "-o", path("man.vis.h5"), "--fps", 8, "--rays", 64, "--local")
    must(BAKE, "fields", MAN, "-o", path("man.fields.h5"), "--rays", 64)
    must(FIT, "brdf", "--analytic", "ggx:alpha=0.3,f0=0.9", "-o", path("ggx.brdf.h5"))
    must(FIT, "light", "--analytic", "sky:elevation=40,azimuth=30", "-o", path("sky.light.h5"))
    look = ["--brdf", path("ggx.brdf.h5"), "--light", path("sky.light.h5")]
    for model, words in (("additive", []), ("composed", ["--fields", path("man.fields.h5")])):
        must(FIT, "visibility", path("man.vis.h5"), "-o", path(model + ".model.h5"), "--model", model, *words)
        must(PACK, "asset", path(model + ".model.h5"), "-o", path(model + ".pnb"), "--precision", "i8",
             *(look if model == "additive" else []))
        native(path(model + ".pnb")).tofile(path(model + ".native"))


def check_sizes(package, folder):
    """What goes over the wire, and what is left of an import that nobody uses."""
    size = lambda name: len(gzip.compress(open(os.path.join(package, "dist", name), "rb").read(), 9))
    print(f"penumbra.wasm {size('penumbra.wasm') / 1000:.0f} KB gzip, packed.js {size('packed.js') / 1000:.0f} KB")
    assert size("penumbra.wasm") <= 520e3 and size("packed.js") <= 540e3
    page = os.path.join(folder, "unused.mjs")
    with open(page, "w") as file:
        file.write("import { load, Character } from 'penumbra-player';\nimport { PenumbraLoader } from 'penumbra-player/three';\n"
                   "import { Crowd, PenumbraWorker } from 'penumbra-player/worker';\n"
                   "import { PenumbraCharacter as Nodes } from 'penumbra-player/three/webgpu';\n")
    modules = os.path.join(folder, "node_modules")
    os.makedirs(modules, exist_ok=True)
    os.symlink(package, os.path.join(modules, "penumbra-player"))
    bundle = must(os.path.join(MODULES, "esbuild/bin/esbuild"), page, "--bundle", "--minify", "--format=esm", "--external:three", "--external:three/*")
    assert len(bundle) < 100, bundle[:500]


def can_browse():
    if shutil.which("chromium") and os.path.isdir(os.path.join(MODULES, "playwright-core")):
        return True
    print("the pages were not tried: no Chromium, or no npm package playwright-core (scripts/setup --web)")
    return False


def look_at(page, package, files, *flags):
    """What a page of tests/pipeline/web found."""
    driver = os.path.join(ROOT, "tests/pipeline/web/chromium.mjs")
    found = json.loads(must("node", driver, package, MODULES, files, shutil.which("chromium"), page, *flags))
    print(page, json.dumps(found))
    assert "error" not in found, found["error"]
    return found


def check_three(package, files):
    """A character in three.js on WebGL, drawn by software: pictures with and without shadows."""
    found = look_at("page.html", package, files)
    assert found["plainLoads"] and found["ownCompileRan"]
    assert found["matchedBy"] == "order" and found["matchError"] < 1e-5
    assert found["reversed"]["by"] == "place" and found["reversed"]["error"] < 1e-5
    assert found["split"]["by"] == "place" and found["split"]["error"] < 1e-5
    assert found["welded"]["by"] == "place" and found["welded"]["error"] < 1e-5
    # Half a step of 16 bits in three directions is 1.3e-5 of the largest side.
    assert found["quantised"]["by"] == "order" and found["quantised"]["error"] < 1.3e-5
    assert found["unmatched"] == "UNMATCHED" and found["grown"] == [0, 0]
    # Shadows only darken, and they are seen; without strength and afterwards the picture is the one from before.
    assert found["onCharacter"]["changed"] > 0.005 and found["onCharacter"]["brighter"] == 0
    assert found["onGround"]["changed"] > 0.005 and found["onGround"]["brighter"] == 0
    assert found["turned"]["changed"] > 0.01
    assert found["reversedPicture"]["mean"] < 0.01
    assert found["strength0"]["changed"] == 0 and found["afterDispose"]["changed"] == 0
    assert found["unwrapped"]


def check_worker(package, files):
    """What a module worker computes, and many characters that it updates."""
    found = look_at("worker.html", package, files)
    assert found["different"] == 0 and found["compared"] > 10000
    assert found["refused"] == ["INVALID_ASSET", "DISPOSED", "DISPOSED", "DISPOSED"] and found["oneUnderWay"]
    assert found["inThree"]["different"] == 0 and found["inThree"]["compared"] > 1000
    assert found["crowd"]["updates"] > 50 and found["crowd"]["least"] > 0 and not found["crowd"]["errors"]


def check_babylon(package, files):
    """The example with Babylon.js: it poses as the engine does, and its colours are E."""
    if not os.path.isdir(os.path.join(MODULES, "@babylonjs/loaders")):
        print("Babylon.js was not tried: no npm package @babylonjs/loaders (scripts/setup --web)")
        return
    found = look_at("babylon.html", package, files)
    assert found["vertices"] > 1000 and found["apart"] < 1e-5  # 2.4e-7 m
    assert -1e-6 < found["least"] < 0.5 and 0.9 < found["most"] < 1 + 1e-6


def check_csp(package, files):
    """A page whose policy forbids WebAssembly is told the word that it lacks, and needs no other."""
    blocked = look_at("csp.html", package, files, "csp:script-src 'self'")
    assert blocked["code"] == "BLOCKED_BY_CSP" and "'wasm-unsafe-eval'" in blocked["message"]
    for policy in ("script-src 'self' 'wasm-unsafe-eval'", "default-src 'self'; script-src 'self' 'wasm-unsafe-eval'"):
        found = look_at("csp.html", package, files, "csp:" + policy)
        assert found["code"] == "" and found["vertices"] > 100 and found["worker"] > 100


def check_consumer(package, folder, files):
    """A project that depends on the package: tsc, what Vite leaves of an unused import, and its build in Chromium."""
    project = os.path.join(folder, "consumer")
    shutil.copytree(os.path.join(ROOT, "tests/pipeline/web/consumer"), project)
    modules = os.path.join(project, "node_modules")
    os.mkdir(modules)
    for name in ("three", "@types", "@webgpu", "fflate"):
        os.symlink(os.path.join(MODULES, name), os.path.join(modules, name))
    os.symlink(package, os.path.join(modules, "penumbra-player"))
    must("node", os.path.join(MODULES, "typescript/bin/tsc"), "-p", project)
    if not os.path.isdir(os.path.join(MODULES, "vite")):
        print("Vite was not tried: no npm package vite (scripts/setup --web)")
        return
    vite = os.path.join(MODULES, "vite/bin/vite.js")
    must("node", vite, "build", project, "--config", os.path.join(project, "vite.config.mjs"))
    unused = [name for name in os.listdir(os.path.join(project, "dist/assets")) if name.startswith("unused")]
    assert len(unused) == 1 and os.path.getsize(os.path.join(project, "dist/assets", unused[0])) < 100, unused
    os.symlink(os.path.join(project, "dist"), os.path.join(files, "consumer"))
    found = look_at("../files/consumer/index.html", package, files)
    assert found["vertices"] > 100 and found["worker"] == found["vertices"] and found["three"]


SOFTWARE_WEBGPU = ("--enable-unsafe-webgpu", "--enable-features=Vulkan", "--use-vulkan=swiftshader",
                   "--use-webgpu-adapter=swiftshader")


def check_webgpu(package, files):
    """The same character by nodes of WebGPURenderer, with both of its back ends, beside WebGLRenderer."""
    for backend in ("webgl", "webgpu"):
        found = look_at(f"webgpu.html?backend={backend}", package, files, *SOFTWARE_WEBGPU)
        assert found["backend"] == backend
        assert found["onCharacter"]["changed"] > 0.005 and found["onCharacter"]["brighter"] == 0
        assert found["onGround"]["changed"] > 0.005 and found["onGround"]["brighter"] == 0
        assert found["turned"]["changed"] > 0.01 and found["after"]["changed"] == 0
        assert found["twice"] < 0.01
        if backend == "webgpu":
            # The core rounds the weights of components to 16 bits, the shader does not: E differs by 4.4e-5.
            computed = found["compute"]
            assert computed["mistake"] == "" and computed["composed"] == "UNSUPPORTED" and computed["frames"] > 50
            assert computed["ambient"] < 1e-4 and computed["coefficients"] < 5e-4 and 0 <= computed["least"] < 0.9
        # Means of 8-bit steps: .009 is what they differ by without shadows as well.
        assert max(found["beside"].values()) < 0.05, found["beside"]


def make_demo_data(cases, data):
    """Small files of the names that the demo page loads. A picture of a character stands for both skies."""
    os.mkdir(data)
    path = lambda name: os.path.join(data, name)
    must(PACK, "embed", os.path.join(cases, "composed.pnb"), MAN, "-o", path("man.glb"))
    with open(path("man.glb"), "rb") as file, gzip.open(path("man.glb.gz"), "wb", 1) as packed:
        packed.write(file.read())
    os.remove(path("man.glb"))
    for name in ("walk.glb", "run.glb", "jump.glb"):
        shutil.copy(MAN, path(name))
    must(PLAYER, "render", os.path.join(cases, "composed.pnb"), "--size", "64x32", "--background", "0.4/0.6/0.9",
         "--channel", "ao", "-o", path("city.exr"))
    shutil.copy(path("city.exr"), path("apartment.exr"))
    # The clip files hold the character's clips, of which the page plays the first.
    must("/usr/bin/python3", os.path.join(ROOT, "scripts/figures/web_truth.py"), os.path.join(cases, "man.vis.h5"),
         "--clip", "wave", "--every", 1, "-o", path("walk.truth.gz"))


def check_demo(package, folder, cases):
    """The demo page as a site and as one file."""
    if not os.path.isdir(os.path.join(MODULES, "vite")):
        print("the demo page was not tried: no npm package vite (scripts/setup --web)")
        return
    data, demo = os.path.join(folder, "data"), os.path.join(folder, "demo")
    make_demo_data(cases, data)
    must("node", os.path.join(ROOT, "runtime/web/demo/build.mjs"), package, MODULES, data, demo)
    driver = os.path.join(ROOT, "tests/pipeline/web/demo.mjs")
    found = json.loads(must("node", driver, demo, MODULES, shutil.which("chromium")))
    print("demo", json.dumps(found))
    assert not found["errors"] and found["stats"]
    # What was traced is nearer than no shadows at all, and than those of a white sky.
    assert 0 < found["truth"] < 0.5 * found["off"] and found["occlusion"] > 0.01 and found["sun"] > found["off"]
    assert found["fromDisk"] == 0 and found["comparesOnlyWalk"]
    assert found["divider"] == "5"  # the least there is
    assert "shadow=off" in found["address"] and "sun=true" in found["address"]


if __name__ == "__main__":
    need_tools()
    with tempfile.TemporaryDirectory() as folder:
        package = built(folder)
        cases = os.path.join(folder, "cases")
        os.mkdir(cases)
        make_cases(cases)
        print(must("node", os.path.join(ROOT, "tests/pipeline/web/runtime.mjs"), package, cases,
                   os.path.join(ROOT, "tests/fuzz/corpus/fuzz_asset")))
        print(must("node", os.path.join(ROOT, "tests/pipeline/web/crowd.mjs"), package))
        check_sizes(package, folder)
        if can_browse():
            files = os.path.join(folder, "files")
            os.mkdir(files)
            for model in ("additive", "composed"):
                os.symlink(os.path.join(cases, model + ".pnb"), os.path.join(files, model + ".pnb"))
            must(PACK, "embed", os.path.join(cases, "composed.pnb"), MAN, "-o", os.path.join(files, "character.glb"))
            check_three(package, files)
            check_worker(package, files)
            check_webgpu(package, files)
            check_babylon(package, files)
            check_csp(package, files)
            check_consumer(package, folder, files)
            check_demo(package, folder, cases)
    print("web runtime: ok")
