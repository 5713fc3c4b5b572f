#!/usr/bin/python3
"""Prints the tables of materials and lights of docs/shading.md from the rows that the benchmarks keep.

accuracy_tables.py [tests/bench/results/epyc-2-cores]     reads brdf.csv and lights.csv there, the last commit's rows of
                                                          each"""
import csv
import pathlib
import sys

FOLDER = pathlib.Path(__file__).resolve().parent.parent.parent / "tests/bench/results/epyc-2-cores"


def last_rows(path):
    with open(path) as file:
        rows = list(csv.DictReader(file))
    return [row for row in rows if row["commit"] == rows[-1]["commit"]]


def unique(values):
    return list(dict.fromkeys(values))


def print_row(cells):
    print("| " + " | ".join(cells) + " |")


def brdf_table(rows):
    names, variants = unique(r["brdf"] for r in rows), unique(r["variant"] for r in rows)
    of = {(r["brdf"], r["variant"]): r for r in rows}
    print_row([f"error · bytes · multiply-adds · ns ({rows[0]['commit']})"] + variants)
    print_row(["---"] * (1 + len(variants)))
    for name in names:
        cells = [name.replace("+", ",")]
        for variant in variants:
            r = of[name, variant]
            cells.append(f"{float(r['shading_error']):.4f} · {r['bytes']} · {r['multiply_adds']} · {float(r['ns_a_vertex']):.0f}")
        print_row(cells)


def light_table(rows):
    fits = [r for r in rows if r["fit"] in ("greedy", "joint") and r["order"] == "4"]
    lights, counts = unique(r["light"] for r in fits), unique(r["lobes"] for r in fits)
    of = {(r["light"], r["fit"], r["lobes"]): r for r in fits}
    print_row([f"residual (irradiance error), greedy → joint ({rows[0]['commit']})"] + [f"{c} lobes" for c in counts])
    print_row(["---"] * (1 + len(counts)))
    for light in lights:
        def cell(count):
            greedy, joint = (of[light, fit, count] for fit in ("greedy", "joint"))
            return " → ".join(f"{float(r['residual']):.3f} ({float(r['irradiance_error']):.3f})" for r in (greedy, joint))
        print_row([light.removesuffix(".exr")] + [cell(c) for c in counts])
    print_row(["ms, median of the lights"] + [
        " → ".join(f"{sorted(float(of[light, fit, c]['ms']) for light in lights)[len(lights) // 2]:.2f}"
                   for fit in ("greedy", "joint")) for c in counts])


def main():
    folder = pathlib.Path(sys.argv[1]) if len(sys.argv) > 1 else FOLDER
    brdf_table(last_rows(folder / "brdf.csv"))
    print()
    light_table(last_rows(folder / "lights.csv"))


if __name__ == "__main__":
    main()
