"""Readers of others take our exports: the Khronos validator, three.js, Babylon.js and assimp.

usage: test_web_export.py BIN [--all]

The packages of npm come by scripts/setup --web. Without them the test is skipped. --all (scripts/test --tools) also
draws with Babylon.js, and static exports, tables and exports with an error.
"""
import base64
import ctypes.util
import http.server
import itertools
import json
import os
import shutil
import subprocess
import sys
import tempfile
import threading

import h5py
import numpy as np
from gltf_reference import Glb
from programs import must

BIN = sys.argv[1]
ALL = "--all" in sys.argv
BAKE, PACK = (os.path.join(BIN, "penumbra-" + name) for name in ("bake", "pack"))
PAGES = os.path.join(os.path.dirname(os.path.abspath(__file__)), "web")
DATA = os.environ.get("XDG_DATA_HOME", os.path.expanduser("~/.local/share"))
PACKAGES = os.environ.get("PENUMBRA_WEB", os.path.join(DATA, "penumbra", "web", "node_modules"))


class Handler(http.server.SimpleHTTPRequestHandler):
    folders = {}
    result = None
    done = threading.Event()

    def translate_path(self, path):
        first, _, rest = path.lstrip("/").partition("?")[0].partition("/")
        return os.path.join(self.folders.get(first, "/nowhere"), os.path.normpath("/" + rest).lstrip("/"))

    def do_POST(self):
        Handler.result = json.loads(self.rfile.read(int(self.headers["Content-Length"])))
        self.send_response(200)
        self.end_headers()
        Handler.done.set()

    def log_message(self, *words):
        pass


def page(name, port, profile):
    """Opens a page in Chromium, and returns what it posts back."""
    Handler.result = None
    Handler.done.clear()
    browser = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
    process = subprocess.Popen(
        [browser, "--headless", "--no-sandbox", "--disable-quic", "--no-first-run", "--use-gl=angle", "--disable-extensions",
         "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist", "--user-data-dir=" + profile,
         "http://127.0.0.1:%d/pages/%s" % (port, name)],
        stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)  # fmt: skip
    try:
        assert Handler.done.wait(200), name + " said nothing"
    finally:
        process.terminate()
        process.wait()
    assert "error" not in Handler.result, Handler.result["error"]
    return Handler.result


def ambient_of(vis):
    with h5py.File(vis) as f:
        b, n = f["visibility/coefficients"][:].astype(float), f["frames/normals"][:].astype(float)
        visible = np.stack([-b[..., 3], -b[..., 1], b[..., 2]], -1) / np.sqrt(3 / (4 * np.pi))
        clips = [f["clips/names"][i].decode() for i in f["frames/clip"][:]]
        return ((visible * n).sum(-1) / np.pi).clip(0, 1)[:, f["mesh/source_vertex"][:]], clips, f["frames/time"][:]


def write_case(folder, export, vis, more):
    """Returns the reference of the pages: the truth of some frames, by mesh and primitive of the exported file. Of a
    static export that is the mean in every frame."""
    ambient, clips, times = ambient_of(vis)
    if Glb(export).json["asset"]["extras"]["penumbra_export"]["as"] == "static":
        ambient = np.repeat(ambient.mean(0, keepdims=True), len(ambient), 0)
    chosen = np.linspace(0, len(times) - 1, 5).astype(int)
    glb, truth, first = Glb(export), {}, 0
    for n in glb.drawn():
        for p, primitive in enumerate(glb.json["meshes"][glb.nodes[n]["mesh"]]["primitives"] if "mesh" in glb.nodes[n] else []):
            count = glb.json["accessors"][primitive["attributes"]["POSITION"]]["count"]
            rows = ambient[chosen, first : first + count]
            truth["%d/%d" % (glb.nodes[n]["mesh"], p)] = [[float(x) for x in row] for row in rows]
            first += count
    case = {"file": os.path.basename(export), "clips": [clips[c] for c in chosen], "times": [float(times[c]) for c in chosen]}
    with open(os.path.join(folder, "case.json"), "w") as out:
        json.dump(case | {"truth": truth} | more, out)


def read_by_assimp(path):
    """Returns how many meshes have vertex colours, or None where libassimp is not there."""
    library = ctypes.util.find_library("assimp")
    if not library:
        return None
    assimp = ctypes.CDLL(library)
    assimp.aiImportFile.restype = ctypes.c_void_p
    scene = assimp.aiImportFile(path.encode(), 0)
    assert scene, "assimp cannot read " + path
    # struct aiScene: flags, root node, number of meshes, meshes. struct aiMesh begins with 3 numbers and vertices.
    head = ctypes.cast(scene, ctypes.POINTER(ctypes.c_uint32))
    count = head[4]
    meshes = ctypes.cast(scene + 24, ctypes.POINTER(ctypes.POINTER(ctypes.c_void_p)))[0]
    colored = 0
    for m in range(count):
        fields = ctypes.cast(meshes[m], ctypes.POINTER(ctypes.c_void_p))
        # 16 bytes of numbers, then vertices, normals, tangents, bitangents, colours.
        colored += fields[6] is not None
    assimp.aiReleaseImport(ctypes.c_void_p(scene))
    return count, colored


def main():
    if not shutil.which("node") or not os.path.isdir(os.path.join(PACKAGES, "gltf-validator")):
        print("skipped: no packages of scripts/setup --web in " + PACKAGES)
        sys.exit(77)
    with tempfile.TemporaryDirectory() as folder:
        server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Handler)
        threading.Thread(target=server.serve_forever, daemon=True).start()
        port, profile = server.server_address[1], os.path.join(folder, "profile")
        Handler.folders = {"node_modules": PACKAGES, "pages": PAGES, "case": folder}
        files = []
        for name in ("face", "capsule_man") if ALL else ("face",):
            rig, vis = os.path.join(BIN, "..", "samples", name + ".glb"), os.path.join(folder, name + ".vis.h5")
            must(BAKE, "visibility", rig, "-o", vis, "--rays", "64", "--fps", "4")
            out = [os.path.join(folder, name + "." + kind + ".glb") for kind in ("static", "play", "table", "few")]
            files += out
            report = os.path.join(folder, "report.json")
            must(PACK, "export", vis, rig, "-o", out[0])
            must(PACK, "export", vis, rig, "-o", out[2], "--as", "table")
            must(PACK, "export", vis, rig, "-o", out[3], "--as", "play", "--components", "4")
            must(PACK, "export", vis, rig, "-o", out[1], "--as", "play", "--components", "0", "--report", report)
            count = json.load(open(report))["figures"]["components"]
            pages = ["three_colors.html"] + (["babylon_colors.html"] if ALL else [])
            kinds = [(out[1], count, "%d components" % count)] + ([(out[0], 0, "static")] if ALL else [])
            for (file, components, kind), one in itertools.product(kinds, pages):
                write_case(folder, file, vis, {"components": components})
                found = page(one, port, profile)
                for shot in found["out"]:
                    print("%s %s, %s: %s" % (found["reader"], name, kind, shot))
                    # The sum of floats is rounded once more on the way to 8 bits: at most one pixel in a thousand
                    # differs.
                    assert shot["pixels"] > 5000 and shot["rms"] < 2e-4 and shot["max"] <= 1.001 / 255, shot
                if "picture" in found and len(sys.argv) > 3:
                    with open(os.path.join(sys.argv[3], name + ".png"), "wb") as picture:
                        picture.write(base64.b64decode(found["picture"].split(",")[1]))
            if not ALL:
                continue
            must(PACK, "export", vis, rig, "-o", out[3], "--as", "play", "--components", "4", "--report", report)
            figures = json.load(open(report))["figures"]
            write_case(folder, out[3], vis, {"components": 4})
            for one in pages:
                found = page(one, port, profile)
                rms = np.sqrt(np.mean([s["rms"] ** 2 for s in found["out"]]))
                print("%s %s, 4 components: rms of pictures %.4f, of vertices %.4f" % (found["reader"], name, rms, figures["rms_error"]))
                assert 0.3 * figures["rms_error"] < rms < 2.5 * figures["rms_error"]
            write_case(folder, out[2], vis, {"table": name + ".table.json"})
            found = page("three_table.html", port, profile)
            for shot in found["out"]:
                print("%s %s, table: %s" % (found["reader"], name, shot))
                assert shot["pixels"] > 5000 and shot["max"] <= 1.001 / 255, shot
        print(must("node", os.path.join(PAGES, "validate.cjs"), PACKAGES, *files), end="")
        read = read_by_assimp(files[0])
        print("assimp reads (meshes, with colours):", read)
        assert read is None or read[0] == read[1] > 0, read


main()
