"""FBX by a converter: what is said of it, what is kept of it, and what is refused without it. A script that copies a
prepared .glb stands in for FBX2glTF.

usage: test_fbx.py BIN"""

import hashlib
import json
import os
import subprocess
import sys
import tempfile

BIN = os.path.abspath(sys.argv[1])
SAMPLES = os.path.join(BIN, "..", "samples")


def bake(folder, rig, *options, converter):
    out = os.path.join(folder, "x.vis.h5")
    command = [os.path.join(BIN, "penumbra-bake"), "visibility", rig, "-o", out, "--rays", "16", "--clips", "swing"]
    environment = dict(os.environ, PENUMBRA_FBX2GLTF=converter, TMPDIR=folder)
    run = subprocess.run(command + list(options), env=environment, capture_output=True, text=True)
    return run, out


def check(good, what):
    if not good:
        sys.exit("test_fbx: " + str(what))


with tempfile.TemporaryDirectory() as folder:
    with open(os.path.join(SAMPLES, "swing.fbx")) as f:
        text = f.read()
    # Steps, which assimp takes for lines.
    rig = os.path.join(folder, "steps.fbx")
    with open(rig, "w") as f:
        f.write(text.replace("KeyAttrFlags: *1 { a: 24836 }", "KeyAttrFlags: *1 { a: 24834 }"))
    check(open(rig).read() != text, "the sample has linear keys")
    converter = os.path.join(folder, "FBX2glTF")
    glb = os.path.join(SAMPLES, "swing.glb")
    with open(converter, "w") as f:
        f.write("#!/bin/sh\nwhile [ $1 != -o ]; do shift; done\ncp '%s' $2.glb\necho 'Animation swing: [0 - 60]'\n" % glb)
    os.chmod(converter, 0o755)

    run, out = bake(folder, rig, converter="off")
    check(run.returncode == 5 and "`scripts/setup --fbx`" in run.stderr and not os.path.exists(out), run.stderr)

    kept, depfile = os.path.join(folder, "kept.glb"), os.path.join(folder, "x.d")
    run, out = bake(folder, rig, "--keep-converted", kept, "--depfile", depfile, "-v", converter=converter)
    check(run.returncode == 0, run.stderr)
    with open(converter, "rb") as f:
        sha256 = hashlib.sha256(f.read()).hexdigest()
    check("read by " + converter in run.stderr and sha256[:12] in run.stderr and "network" in run.stderr, run.stderr)
    check(open(kept, "rb").read() == open(glb, "rb").read(), "--keep-converted is what the converter made")
    check("FBX2glTF" in open(depfile).read(), "the converter stands in the depfile")
    info = subprocess.run([os.path.join(BIN, "penumbra-bake"), "info", out, "--json"], capture_output=True, text=True)
    text = info.stdout if info.returncode == 0 else subprocess.run(
        [os.path.join(BIN, "penumbra-bake"), "info", out], capture_output=True, text=True
    ).stdout
    check(sha256[:12] in text, "provenance has the converter's SHA-256: " + text)
    check([n for n in os.listdir(folder) if n.startswith("penumbra.")] == [], "no temporary folder is left")

    run, out = bake(folder, glb, "--keep-converted", kept, converter=converter)
    check(run.returncode == 5 and "did not convert it" in run.stderr, run.stderr)
print("test_fbx: refusals, provenance and kept files are right")
