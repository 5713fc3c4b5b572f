"""The whole pipeline on the rig that scripts/get_samples brought from the network, with the bounds of test_sample_rig.py.
CTest skips it where there is no such rig. $PENUMBRA_SAMPLE_ENV names the file that get_samples wrote.

usage: test_found_rig.py BIN
"""
import os
import subprocess
import sys

from sample_rig import check_sample


def sample():
    """Returns what sample.env says: source, clips to train on, clip to hold out, files of the rig."""
    script = 'source "$0"; printf "%s\\n" "$SAMPLE_SOURCE" "$TRAIN_CLIPS" "$HOLDOUT_CLIP" "${RIG[@]}"'
    lines = subprocess.run(["bash", "-c", script, os.environ["PENUMBRA_SAMPLE_ENV"]], check=True, capture_output=True,
                           text=True).stdout.splitlines()
    return lines[0], [*lines[1].split(","), lines[2]], lines[3:]


if "PENUMBRA_SAMPLE_ENV" not in os.environ:
    print("skipped: PENUMBRA_SAMPLE_ENV is not set (scripts/test sets it)")
    sys.exit(77)
source, clips, files = sample()
if not source.startswith("npm "):
    print(f"skipped: the rig is not the one from npm, but {source}; test_sample_rig.py has the synthetic one")
    sys.exit(77)
check_sample(files, clips, fps=10)
