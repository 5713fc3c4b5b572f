"""A killed bake goes on where it stopped (--resume) and ends with the bytes of one that nobody killed.

usage: test_resume.py BIN
"""
import json
import os
import random
import signal
import subprocess
import sys
import tempfile
import time

import h5py

from programs import digest

BIN = os.path.abspath(sys.argv[1])
BAKE = os.path.join(BIN, "penumbra-bake")
RIG = os.path.join(BIN, "..", "samples", "bend.glb")
# 99 frames of some milliseconds each, so that a signal comes within few frames of the one that it is meant for.
WORDS = ["--fps", "16", "--rays", "64", "--order", "3"]


def command(out, *words):
    return [BAKE, "visibility", RIG, "-o", out, *WORDS, *map(str, words)]


def run(out, *words, code=0):
    result = subprocess.run(command(out, *words), stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    assert result.returncode == code, result
    return result


def report(path):
    with open(path) as f:
        return json.load(f)["figures"]


def stop(out, number, size, *words):
    """Bakes until the journal has `size` bytes, then sends the signal. Returns the exit code."""
    process = subprocess.Popen(command(out, *words), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    journal = out + ".journal"
    while process.poll() is None and not (os.path.exists(journal) and os.path.getsize(journal) >= size):
        time.sleep(0.002)
    process.send_signal(number)
    return process.wait()


def check_killed(folder, expected):
    """kill -9 comes again and again. Each run goes on where the one before stopped, on 1 or 2 threads."""
    out, journal = os.path.join(folder, "a.vis.h5"), os.path.join(folder, "a.vis.h5.journal")
    kept = []
    for part in (0.2, 0.5, 0.8):
        assert stop(out, signal.SIGKILL, part * 100 * FRAME, "--resume", "--threads", 1 + len(kept) % 2) == -9
        assert not os.path.exists(out) and os.path.exists(journal)
        kept.append(os.path.getsize(journal) // FRAME)
    result = run(out, "--resume", "--report", os.path.join(folder, "r.json"))
    figures = report(os.path.join(folder, "r.json"))
    assert kept[0] < kept[1] < kept[2] and abs(figures["frames_resumed"] - kept[2]) <= 1, (kept, figures)
    assert "went on after" in result.stdout and digest(out) == expected
    assert sorted(os.listdir(folder)) == ["a.vis.h5", "r.json"], os.listdir(folder)
    # The journal of a bake without --resume serves as well. One whose end is torn loses only that frame.
    os.remove(out)
    stop(out, signal.SIGKILL, 0.5 * 100 * FRAME)
    with open(journal, "r+b") as f:
        f.truncate(os.path.getsize(journal) - FRAME // 2)
    run(out, "--resume")
    assert digest(out) == expected
    # A whole output is left as it is.
    before = os.stat(out)
    assert "whole" in run(out, "--resume").stdout
    assert os.stat(out).st_mtime_ns == before.st_mtime_ns and os.stat(out).st_ino == before.st_ino
    # An output with the right provenance and a flipped bit is not whole.
    with h5py.File(out) as f:
        places = [f[name].id.get_chunk_info(0).byte_offset for name in ("skin/weights", "frames/normals", "visibility/coefficients")]
    for at in places:
        with open(out, "r+b") as f:
            f.seek(at + 9)
            byte = f.read(1)[0]
            f.seek(at + 9)
            f.write(bytes([byte ^ 16]))
        assert "damaged" in run(out, "--resume", "--progress", "none").stderr and digest(out) == expected


def check_damage(folder, expected):
    """A changed bit anywhere in the journal costs frames, but never gives a wrong byte."""
    out, journal = os.path.join(folder, "a.vis.h5"), os.path.join(folder, "a.vis.h5.journal")
    stop(out, signal.SIGKILL, 0.3 * 100 * FRAME)
    whole = open(journal, "rb").read()
    chance = random.Random(1)
    for at in (0, 9, len(whole) // 2 + chance.randrange(FRAME)):
        data = bytearray(whole)
        data[at] ^= 1 << chance.randrange(8)
        open(journal, "wb").write(data)
        run(out, "--resume", "-q")
        assert digest(out) == expected, at
        os.remove(out)
    open(journal, "wb").write(b"notes of somebody else")
    assert "is not the journal" in run(out, "--resume").stderr
    assert digest(out) == expected


def check_foreign(folder, expected):
    """Other options are named, and nothing is taken over. Without --resume the leftover goes."""
    out, journal = os.path.join(folder, "a.vis.h5"), os.path.join(folder, "a.vis.h5.journal")
    assert stop(out, signal.SIGKILL, 10 * FRAME, "--seed", "2") == -9
    result = run(out, "--resume", "--report", os.path.join(folder, "r.json"))
    assert "seed 2, not 1" in result.stderr, result.stderr
    assert report(os.path.join(folder, "r.json"))["frames_resumed"] == 0 and digest(out) == expected
    os.remove(out)
    assert stop(out, signal.SIGKILL, 10 * FRAME) == -9
    assert "discarded" in run(out).stderr
    assert digest(out) == expected and not os.path.exists(journal)


def check_signals(folder, expected):
    """After SIGTERM and SIGINT the journal stays with --resume, and nothing stays without it."""
    out, journal = os.path.join(folder, "a.vis.h5"), os.path.join(folder, "a.vis.h5.journal")
    for number in (signal.SIGTERM, signal.SIGINT):
        assert stop(out, number, 20 * FRAME) == 4 and os.listdir(folder) == []
        assert stop(out, number, 20 * FRAME, "--resume") == 4 and os.listdir(folder) == ["a.vis.h5.journal"]
        run(out, "--resume")
        assert digest(out) == expected and os.listdir(folder) == ["a.vis.h5"]
        os.remove(out)


def killed_and_resumed(folder, out, *words):
    """Makes a bake that was killed after its second frame and went on from there."""
    for _ in range(10):
        if stop(out, signal.SIGKILL, 2 * FRAME, "--resume", *words) == -9 and os.path.exists(out + ".journal"):
            break
        os.remove(out)  # it was whole before the signal came
    run(out, "--resume", "--report", os.path.join(folder, "r.json"), *words)
    assert report(os.path.join(folder, "r.json"))["frames_resumed"] >= 2


def check_splits(folder, expected):
    """1, 2 and 7 shards on 1 and 2 threads, resumed or not, give one SHA-256."""
    merged = os.path.join(folder, "merged.vis.h5")
    for count in (1, 2, 7):
        edges = [FRAMES * i // count for i in range(count + 1)]
        for threads, resumed in ((1, False), (1, True), (2, False), (2, True)):
            shards = [os.path.join(folder, f"s{i}.vis.h5") for i in range(count)]
            for shard, first, last in zip(shards, edges, edges[1:]):
                words = ["--threads", threads, *(["--frames", f"{first}:{last}"] if count > 1 else [])]
                killed_and_resumed(folder, shard, *words) if resumed else run(shard, *words)
            subprocess.run([BAKE, "merge", *shards, "-o", merged, "-q", "--threads", str(threads)], check=True)
            assert digest(merged) == expected, (count, threads, resumed)
            for name in os.listdir(folder):
                os.remove(os.path.join(folder, name))


def check_two_at_once(folder, expected):
    """Two bakes write one output: both end well, and the file is whole. --resume does not share a journal."""
    out = os.path.join(folder, "a.vis.h5")
    first = subprocess.Popen(command(out, "-q"))
    while not (os.path.exists(out + ".journal") and os.path.getsize(out + ".journal") >= FRAME):
        assert first.poll() is None, "the first bake ended before it was seen at work"
        time.sleep(0.002)
    result = run(out, "--resume", code=2)
    assert "another bake" in result.stderr and first.poll() is None, result
    second = subprocess.Popen(command(out, "-q"))
    assert first.wait() == 0 and second.wait() == 0
    assert digest(out) == expected and os.listdir(folder) == ["a.vis.h5"], os.listdir(folder)


def main():
    global FRAME, FRAMES  # bytes of a frame in the journal; how many frames
    with tempfile.TemporaryDirectory() as folder:
        whole = os.path.join(folder, "whole.vis.h5")
        run(whole)
        expected = digest(whole)
        with h5py.File(whole) as f:
            shape = f["visibility/coefficients"].shape
        assert shape[0] >= 90, shape
        FRAMES, FRAME = shape[0], 4 * shape[1] * shape[2]
    for check in (check_killed, check_damage, check_foreign, check_signals, check_splits, check_two_at_once):
        with tempfile.TemporaryDirectory() as folder:
            check(folder, expected)
            print(f"{check.__name__}: ok")


main()
