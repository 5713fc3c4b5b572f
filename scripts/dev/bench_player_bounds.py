#!/usr/bin/env python3
"""The figures of a report of `penumbra-player bench` that have a bound, one line each; exit code 1 if one is missed.
With a commit: rows of tests/bench/results/*/player.csv instead.
   scripts/dev/bench_player_bounds.py REPORT.json [COMMIT]"""
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


def csv_rows(figures):
    for stage in figures["stages"]:
        yield stage["stage"], stage["threads"], stage["median_ms"], stage["best_ms"], stage["of_roof"]
    for name in ("pose_evaluate", "pose_skin_evaluate", "frame"):
        yield name, figures["threads"], figures[name]["median_ms"], figures[name]["best_ms"], ""
    for frame in figures["gl"]["whole_frames"]:
        yield f"whole frame aa {frame['samples']}", figures["threads"], frame["median_ms"], frame["best_ms"], ""
    for row in figures["characters"]:
        yield f"CPU of {row['characters']} characters", figures["threads"], row["total_ms"] - row["draw_ms"], "", ""


def print_csv(figures, commit):
    for name, threads, median, best, of_roof in csv_rows(figures):
        numbers = [f"{value:.4f}" if value != "" else "" for value in (median, best, of_roof)]
        print(",".join([commit, f'"{name}"' if "," in name else name, str(threads), *numbers]))
    return 0


def print_bounds(figures):
    missed = 0
    for name, value, bound, at_least in rows(figures):
        held = value >= bound if at_least else value <= bound
        missed += not held
        print(f"{name:<52} {value:10.3f}   {'at least' if at_least else 'at most'} {bound:<6} {'held' if held else 'MISSED'}")
    return 1 if missed else 0


def main():
    with open(sys.argv[1]) as file:
        figures = json.load(file)["figures"]
    return print_csv(figures, sys.argv[2]) if len(sys.argv) > 2 else print_bounds(figures)


sys.exit(main())
