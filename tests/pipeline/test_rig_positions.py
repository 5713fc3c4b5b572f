"""Skinned positions of every sample rig, and of every .glb of $PENUMBRA_DATA/rigs, against gltf_reference.py.

usage: test_rig_positions.py BIN
"""
import glob
import json
import os
import subprocess
import sys

import numpy as np

from gltf_reference import Evaluator

BIN = sys.argv[1]
BOUND = 1e-5  # in diagonals; 1.1e-6 was measured (welding moves a vertex by up to 1e-6)
TIMES_A_CLIP = 4
CLIPS_A_RIG = 12


def ours(path, fps):
    run = subprocess.run([os.path.join(BIN, "rig_positions"), path, fps], stdout=subprocess.PIPE, check=True)
    line, data = run.stdout.split(b"\n", 1)
    header = json.loads(line)
    shape = (len(header["frames"]), header["vertices"], 3)
    return header, np.frombuffer(data, "<f4").reshape(shape)


def worst_error(path):
    header, positions = ours(path, "7")
    reference = Evaluator(path)
    assert [name for name, _ in reference.clips] == [c for c in header["clips"] if c != "rest"], path
    frames = np.array([f[0] for f in header["frames"]])
    worst, compared = 0.0, 0
    for clip in np.unique(frames)[:: max(1, len(reference.clips) // CLIPS_A_RIG)]:
        of_clip = np.flatnonzero(frames == clip)
        for f in of_clip[np.linspace(0, len(of_clip) - 1, TIMES_A_CLIP).astype(int)]:
            expected = reference.positions(clip if reference.clips else -1, header["frames"][f][1])
            assert expected.shape == positions[f].shape, (path, expected.shape, positions[f].shape)
            diagonal = np.linalg.norm(expected.max(0) - expected.min(0))
            worst = np.maximum(worst, np.abs(expected - positions[f]).max() / diagonal)  # keeps NaN
            compared += 1
    return worst, compared, header


def main():
    rigs = sorted(glob.glob(os.path.join(BIN, "..", "samples", "*.glb")))
    assert len(rigs) >= 10, "make_samples.py wrote %d rigs" % len(rigs)
    if "PENUMBRA_DATA" in os.environ:
        rigs += sorted(glob.glob(os.path.join(os.environ["PENUMBRA_DATA"], "rigs", "*.glb")))
    failed = False
    for rig in rigs:
        worst, compared, header = worst_error(rig)
        failed |= not (worst <= BOUND and compared)
        print(
            "%-28s %6d vertices %6d points %3d joints  worst error %.1e of the diagonal in %d frames"
            % (os.path.basename(rig), header["vertices"], header["points"], len(header["joints"]), worst, compared)
        )
    sys.exit("error above %g" % BOUND if failed else 0)


main()
