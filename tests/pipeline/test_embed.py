"""An asset inside of the .glb of its character: its bytes come back, the file says what it said, and other rigs are
refused.

usage: test_embed.py BIN
"""
import json
import os
import struct
import sys
import tempfile

from programs import BIN, good, must, refused

PACK = os.path.join(BIN, "penumbra-pack")
SAMPLES = os.path.join(BIN, "..", "samples")
MAN = os.path.join(SAMPLES, "capsule_man.glb")


def chunks(path):
    """The JSON and the binary chunk of a .glb."""
    with open(path, "rb") as file:
        data = file.read()
    (length,) = struct.unpack_from("<I", data, 12)
    return json.loads(data[20 : 20 + length]), data[28 + length :]


with tempfile.TemporaryDirectory() as folder:
    path = lambda name: os.path.join(folder, name)
    good("bake", "visibility", MAN, "-o", path("man.vis.h5"), "--fps", 4, "--rays", 32)
    good("fit", "visibility", path("man.vis.h5"), "-o", path("man.model.h5"), "--model", "additive")
    good("pack", "asset", path("man.model.h5"), "-o", path("man.pnb"))
    must(PACK, "embed", path("man.pnb"), MAN, "-o", path("both.glb"))

    (before, bytes_before), (after, bytes_after) = chunks(MAN), chunks(path("both.glb"))
    view = after["bufferViews"][after["extensions"]["PENUMBRA_visibility"]["bufferView"]]
    asset = open(path("man.pnb"), "rb").read()
    start = view.get("byteOffset", 0)
    assert bytes_after[start : start + view["byteLength"]] == asset and view["byteLength"] == len(asset)
    size = before["buffers"][0]["byteLength"]
    assert bytes_after[:size] == bytes_before[:size]
    # All else stays, and nobody must know the extension.
    assert "PENUMBRA_visibility" in after["extensionsUsed"]
    assert "PENUMBRA_visibility" not in after.get("extensionsRequired", [])
    for key in before:
        if key not in ("buffers", "bufferViews", "extensions", "extensionsUsed"):
            assert after[key] == before[key], key
    assert after["bufferViews"][: len(before["bufferViews"])] == before["bufferViews"]
    # Our own reader takes it as the file that it was.
    good("bake", "visibility", path("both.glb"), "-o", path("again.vis.h5"), "--fps", 4, "--rays", 32)

    refused(3, "already", PACK, "embed", path("man.pnb"), path("both.glb"), "-o", path("no.glb"))
    refused(3, "another character", PACK, "embed", path("man.pnb"), os.path.join(SAMPLES, "bend.glb"), "-o",
            path("no.glb"))  # fmt: skip
    refused(1, "--output", PACK, "embed", path("man.pnb"), MAN, "-o", path("no.gltf"))
    refused(3, "not a Penumbra asset", PACK, "embed", MAN, MAN, "-o", path("no.glb"))
    assert not os.path.exists(path("no.glb"))
print("embed: ok")
