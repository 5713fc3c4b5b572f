"""kill -9 at random moments: a file under its final name is whole, and what is left over is swept by the next run.

usage: test_kill.py BIN
"""
import os
import random
import signal
import subprocess
import sys
import tempfile
import time

from programs import digest

BIN = os.path.abspath(sys.argv[1])
RIG = os.path.join(BIN, "..", "samples", "bend.glb")
BAKE = ["penumbra-bake", "visibility", RIG, "--fps", "16", "--rays", "32", "--order", "3"]  # 99 frames
KILLS = 20


def check(verb, folder, output, words, seconds, expected, random_moment, again=()):
    """Kills the program KILLS times before it would end by itself. Then it runs to its end, with `again` added."""
    before = set(os.listdir(folder)) - {output}
    killed, most = 0, seconds
    for _ in range(10 * KILLS):
        process = subprocess.Popen(words, cwd=folder, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        try:
            process.wait(timeout=random_moment(most))
            most *= 0.8  # it was faster than before: the moments are too late
        except subprocess.TimeoutExpired:
            process.send_signal(signal.SIGKILL)
            process.wait()
            killed += 1
        if os.path.exists(os.path.join(folder, output)):
            assert digest(os.path.join(folder, output)) == expected, f"{verb}: another file under the final name"
            os.remove(os.path.join(folder, output))
        left = set(os.listdir(folder)) - before
        assert all(name.startswith((output + ".part", output + ".journal")) for name in left), (verb, left)
        if killed == KILLS:
            break
    assert killed == KILLS, f"{verb}: ended {10 * KILLS - killed} times before it could be killed"
    result = subprocess.run([*words, *again], cwd=folder, capture_output=True, text=True)
    assert result.returncode == 0, result
    assert digest(os.path.join(folder, output)) == expected, f"{verb}: other bytes after kills"
    assert set(os.listdir(folder)) == before | {output}, (verb, os.listdir(folder))
    print(f"{verb}: killed {killed} times within {seconds:.2f} s, whole in the end")


def main():
    chance = random.Random(7)
    programs = {
        "bake": [*BAKE, "-o", "a.vis.h5"],
        "resumed bake": [*BAKE, "--resume", "-o", "a.vis.h5"],
        "merge": ["penumbra-bake", "merge", "s0.vis.h5", "s1.vis.h5", "-o", "m.vis.h5"],
        "fit": ["penumbra-fit", "visibility", "m.vis.h5", "--model", "linear", "--clusters", "8", "--convention", "D3", "-o", "m.model.h5"],
        "pack": ["penumbra-pack", "asset", "m.model.h5", "-o", "m.pnb"],
    }
    with tempfile.TemporaryDirectory() as folder:
        for i, frames in enumerate(("0:50", "50:90")):
            subprocess.run([os.path.join(BIN, BAKE[0]), *BAKE[1:], "--frames", frames, "-o", f"s{i}.vis.h5"], cwd=folder,
                           check=True, stdout=subprocess.DEVNULL)
        for verb, words in programs.items():
            words = [os.path.abspath(os.path.join(BIN, words[0])), *words[1:]]
            if verb == "merge":
                words += ["--frames", "0:90"]
            start = time.monotonic()
            subprocess.run(words, cwd=folder, check=True, stdout=subprocess.DEVNULL)
            seconds = time.monotonic() - start
            expected = digest(os.path.join(folder, words[words.index("-o") + 1]))
            if verb.endswith("bake"):
                os.remove(os.path.join(folder, "a.vis.h5"))
            check(verb, folder, words[words.index("-o") + 1], words, seconds, expected,
                  lambda most: chance.uniform(0, most), ["--resume"] if verb == "bake" else [])
            if verb.endswith("bake"):
                os.remove(os.path.join(folder, "a.vis.h5"))


main()
