#!/usr/bin/python3
"""Prints the demo's table of errors, sizes and times from the reports in its folder.

demo_table.py DEMO_FOLDER"""
import json
import pathlib
import sys

MODELS = {"paper": "paper: linear, joint angles, A4", "bones_a4": "linear, relative bones, A4",
          "additive_a4": "additive, relative bones, A4", "additive": "additive, relative bones, D5",
          "composed": "composed: local x far parts, D5"}


def report(folder, name):
    return json.loads((folder / f"{name}.json").read_text())


def model_row(folder, name):
    fit, pack, check = (report(folder, f"{stage}_{name}") for stage in ("fit", "pack", "check"))
    pictures = report(folder, "pictures")["image_rmse"]
    train, held_out = fit["figures"]["train"], fit["figures"]["held_out"]
    packed = check["figures"]["held_out"]
    return [MODELS[name], f"{train['relative_error']:.3f}", f"{held_out['relative_error']:.3f}",
            f"{packed['relative_error']:.3f}", f"{packed['ambient_error']:.4f}", f"{packed['ambient_error_max']:.3f}",
            f"{pictures[name]:.1f}" if name in pictures else "-",
            f"{pack['figures']['model_bytes_per_vertex']:.0f}", f"{pack['figures']['bytes']['file'] / 1e6:.2f}",
            f"{fit['seconds']:.1f}"]


def print_table(head, rows):
    widths = [max(len(row[i]) for row in [head] + rows) for i in range(len(head))]
    for row in [head] + rows:
        print("  ".join(cell.ljust(w) if i == 0 else cell.rjust(w) for i, (cell, w) in enumerate(zip(row, widths))))


def main():
    folder = pathlib.Path(sys.argv[1])
    bake = report(folder, "bake")
    figures = bake["figures"]
    print(f"bake: {figures['frames']} frames x {figures['vertices']} vertices, "
          f"{figures['rays_traced'] / 1e6:.0f} Mray in {bake['seconds']:.0f} s "
          f"({figures['rays_per_second'] / 1e6:.1f} Mray/s), {figures['bytes'] / 1e6:.1f} MB, "
          f"peak memory {bake['peak_memory_bytes'] / 1e6:.0f} MB")
    light = report(folder, "light")
    print(f"material: {report(folder, 'brdf')['seconds']:.2f} s; light: {light['seconds']:.2f} s, "
          f"residual of its order-{light['figures']['order']} SH {light['figures']['residual']:.2f}")
    print("\nrelative error: 1 = a static bake; a number is comparable between rows of one convention (A4 or D5) only.\n"
          "ambient error (mean and largest) and picture RMSE (8-bit steps, against ray-traced truth) are comparable between all rows.\n")
    print_table(["model", "train", "held out", "packed i8", "ambient", "largest error", "picture", "B/vertex", "file MB", "fit s"],
                [model_row(folder, name) for name in MODELS])


if __name__ == "__main__":
    main()
