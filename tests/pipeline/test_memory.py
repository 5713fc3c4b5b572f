"""A bake streams its frames: its memory does not grow with their number, and stays below the output's size plus 500 MB.

test_memory.py BIN_FOLDER"""
import json
import pathlib
import subprocess
import sys
import tempfile

BIN = pathlib.Path(sys.argv[1])
RIG = BIN / ".." / "samples" / "capsule_man.glb"


def bake(folder, fps):
    """Returns (frames, peak resident bytes, bytes of the output)."""
    out, report = folder / "m.vis.h5", folder / "m.json"
    subprocess.run([BIN / "penumbra-bake", "visibility", RIG, "-o", out, "--fps", str(fps), "--rays", "16", "--order", "3",
                    "-q", "--report", report], check=True)
    read = json.loads(report.read_text())
    return read["figures"]["frames"], read["peak_memory_bytes"], out.stat().st_size


with tempfile.TemporaryDirectory() as name:
    few, many = (bake(pathlib.Path(name), fps) for fps in (10, 90))
    for frames, peak, size in (few, many):
        print(f"{frames} frames: {peak / 1e6:.0f} MB of memory, {size / 1e6:.1f} MB written")
        assert peak < size + 500e6
    # Up to 64 frames wait for their chunk. From there on only the pose arrays grow (measured).
    assert many[0] > 8 * few[0] and many[1] < few[1] + 40e6, "memory grows with the frames"
