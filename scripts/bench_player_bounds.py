#!/usr/bin/env python3
"""The figures of a report of `penumbra-player bench` that have a bound, one line each; exit code 1 if one is missed.
   scripts/bench_player_bounds.py REPORT.json"""
import json
import sys


def rows(figures):
    stages = {stage["stage"]: stage for stage in figures["stages"]}
    gl = figures["gl"]
    yield "CPU pose and evaluate, Hz", 1000 / figures["pose_evaluate"]["median_ms"], 1000, True
    if figures["shade"]["median_ms"] > 0:
        yield "CPU shade, Hz", 1000 / figures["shade"]["median_ms"], 250, True
    for name in ("evaluate, 1 thread", "evaluate"):
        yield f"{name}: share of the roof", stages[name]["of_roof"], 0.6, True
    for frame in gl["whole_frames"]:
        yield f"whole frame, CPU path, --aa {frame['samples']}, Hz", frame["hz"], 60, True
    yield "GLSL path against CPU path, RMSE in 8-bit steps", gl["path_difference_8bit"], 0.5, False
    if figures["characters"]:
        last = figures["characters"][-1]
        yield f"CPU cost of one of {last['characters']} characters / of one alone", last["cpu_linearity"], 1.1, False


def main():
    with open(sys.argv[1]) as file:
        figures = json.load(file)["figures"]
    missed = 0
    for name, value, bound, at_least in rows(figures):
        held = value >= bound if at_least else value <= bound
        missed += not held
        print(f"{name:<52} {value:10.3f}   {'at least' if at_least else 'at most'} {bound:<6} {'held' if held else 'MISSED'}")
    return 1 if missed else 0


sys.exit(main())
