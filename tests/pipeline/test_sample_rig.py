"""The whole pipeline on the synthetic character of scripts/make_samples.py, which is the same on every machine.

usage: test_sample_rig.py BIN
"""
from sample_rig import BIN, check_sample

check_sample([BIN / ".." / "samples" / "capsule_man.glb"], ["wave", "squat", "walk"], fps=6)
