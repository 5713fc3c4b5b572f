"""A bake streams its frames: its memory does not grow with their number, and stays below the output's size plus 500 MB.

test_memory.py BIN_FOLDER"""
import json
import pathlib
import subprocess
import sys
import tempfile

import h5py

BIN = pathlib.Path(sys.argv[1])
RIG = BIN / ".." / "samples" / "capsule_man.glb"


def bake(folder, fps):
    """Returns (frames, peak resident bytes, bytes of the output, bytes of all its coefficients in memory)."""
    out, report = folder / "m.vis.h5", folder / "m.json"
    subprocess.run([BIN / "penumbra-bake", "visibility", RIG, "-o", out, "--fps", str(fps), "--rays", "16", "--order", "8",
                    "-q", "--report", report], check=True)
    read = json.loads(report.read_text())
    with h5py.File(out) as file:
        kept = 4 * file["visibility/coefficients"].size
    return read["figures"]["frames"], read["peak_memory_bytes"], out.stat().st_size, kept


with tempfile.TemporaryDirectory() as name:
    few, many = (bake(pathlib.Path(name), fps) for fps in (10, 90))
    for frames, peak, size, kept in (few, many):
        print(f"{frames} frames: {peak / 1e6:.0f} MB of memory, {size / 1e6:.1f} MB written, {kept / 1e6:.0f} MB if all were kept")
        assert peak < size + 500e6
    # Up to 64 frames wait for their chunk. From there on only the pose arrays grow: 1 MB was measured.
    assert many[0] > 8 * few[0] and many[3] > 100e6, "too few frames to tell"
    assert many[1] - few[1] < 0.1 * (many[3] - few[3]), "memory grows with the frames"
