"""Compares what --dry-run says of a bake with the bake itself: frames, rays and the journal exactly, the file
closely, the seconds roughly. The seconds are held against the processor time of the bake, which hardly depends on
what else runs on the machine.

usage: test_estimate.py BIN
"""
import json
import os
import re
import subprocess
import sys
import tempfile

import processor_time

BIN = os.path.abspath(sys.argv[1])
BAKE = os.path.join(BIN, "penumbra-bake")
SAMPLES = os.path.join(BIN, "..", "samples")
CASES = [("capsule_man.glb", "--fps", "10", "--rays", "128"),  # each takes about 2 s of processor time
         ("capsule_man.glb", "--fps", "20", "--rays", "32", "--precision", "f16", "--order", "4"),
         ("bend.glb", "--fps", "60", "--rays", "256", "--ground")]
THREADS = 2
SAYS = re.compile(r"(\d+) frames x (\d+) vertices x (\d+) rays = ([\d.]+) Mray; ([\d.]+) MB before compression\n"
                  r"clips: \[.*\]\n"
                  r"estimate from a probe of ([\d.]+) s: (\d+) s on 2 threads, ([\d.]+) MB, peak memory (\d+) MB, journal ([\d.]+) MB\n")


def run(folder, words, *more):
    command = [BAKE, "visibility", os.path.join(SAMPLES, words[0]), *words[1:], "--threads", str(THREADS),
               "-o", os.path.join(folder, "x.vis.h5")]
    return subprocess.run([*command, *more], check=True, capture_output=True, text=True).stdout


def compare(folder, words):
    text = run(folder, words, "--dry-run")
    assert SAYS.fullmatch(text) and os.listdir(folder) == [], (text, os.listdir(folder))
    frames, vertices, rays, mray, raw, probe, seconds, megabytes, memory, journal = map(float, SAYS.fullmatch(text).groups())
    report = os.path.join(folder, "r.json")
    before = processor_time.of_ended_children()
    run(folder, words, "-q", "--report", report)
    used = (processor_time.of_ended_children() - before) / min(THREADS, os.cpu_count())
    with open(report) as file:
        done = json.load(file)
    figures = done["figures"]
    assert (figures["frames"], figures["vertices"], figures["rays"]) == (frames, vertices, frames * vertices * rays), figures
    assert mray == round(figures["rays"] * 1e-6, 1) and raw == round(figures["uncompressed_bytes"] * 1e-6, 1), text
    # Half of the 2N directions are above a vertex' horizon, give or take a few; the floor takes those that point down.
    traced = figures["rays_traced"] / figures["rays"]
    assert traced < 1.01 and (traced > 0.99 or "--ground" in words), traced
    order = int(words[words.index("--order") + 1]) if "--order" in words else 5
    assert journal == round(frames * vertices * order**2 * (2 if "f16" in words else 4) * 1e-6, 1), text
    size, time, room = (megabytes * 1e6 / figures["bytes"], seconds / used, memory * 1e6 / done["peak_memory_bytes"])
    print(f"{' '.join(words)}: probe {probe:.1f} s; estimate / actual: bytes {size:.2f}, seconds {time:.2f}, memory {room:.2f}")
    assert 0.85 < size < 1.15, (text, figures)  # 0.91, 1.02, 1.02
    # The estimate is in whole seconds: half a second more or less is rounding.
    assert 0.4 * used - 0.5 < seconds < 2.5 * used + 0.5, (text, used)
    assert 0.7 < room < 1.5, (text, done["peak_memory_bytes"])


def main():
    for words in CASES:
        with tempfile.TemporaryDirectory() as folder:
            compare(folder, words)


main()
