"""penumbra-bake poses --auto as a user runs it: what it tries, tells and writes, and what it refuses.

usage: test_auto_poses.py BIN
"""
import json
import math
import os
import shutil
import signal
import subprocess
import tempfile
import time

import h5py

from programs import BIN, digest, good, must, refused, run

SAMPLES = os.path.join(BIN, "..", "samples")
MAN = os.path.join(SAMPLES, "capsule_man.glb")
BEND = os.path.join(SAMPLES, "bend.glb")
# A choice takes a fit for each combination and fold, so most of what follows is asked of a rig of two joints, which has
# one combination beside the clips. The frames are those of its first clip: the other clips have none of them.
SMALL = ["--fps", "4", "--frames", "0:9", "--rays", "16"]


def auto(out, *words, rig=MAN):
    report = out + ".json"
    result = good("bake", "poses", rig, "--auto", "-o", out, "--report", report, *words)
    return json.load(open(report))["figures"], result.stdout


def check_choice(folder):
    """The table has every combination, and the list is that of the options which were chosen, byte by byte."""
    out = os.path.join(folder, "man.poses.h5")
    frames = ["--fps", "2", "--holdout", "squat"]
    figures, said = auto(out, *frames, "--sample", "6", "--mix", "6", "--cover", "4", "--rays", "16")
    choice = figures["auto"]
    kinds = [row["options"] for row in choice["tried"]]
    assert kinds[:5] == ["--choose all", "--choose all --sample 6", "--mix 6", "--mix 6 --cover 4",
                         "--sample 6 --mix 6 --cover 4"], kinds
    assert choice["chosen"] in kinds and len(kinds) == (5 if choice["chosen"] == kinds[0] else 6), choice
    assert choice["pilot"]["folds"] == 4 and choice["pilot"]["model"] == "composed", choice
    clips = choice["tried"][0]
    for row in choice["tried"]:
        assert len(row["errors"]) == 4 and all(0 < error < 1 for error in row["errors"]), row
        logs = [math.log(a / b) for a, b in zip(row["errors"], clips["errors"])]
        assert abs(row["ratio"] - math.exp(sum(logs) / 4)) < 1e-9, row
        assert row["minutes"] > 0 and row["options"] in said, (row, said)
    assert f"chosen, to type in place of --auto: {choice['chosen']}" in said, said
    assert "pilot: " in said and " minutes" in said, said
    typed = os.path.join(folder, "typed.poses.h5")
    must(os.path.join(BIN, "penumbra-bake"), "poses", MAN, *frames, *choice["chosen"].split(), "-o", typed)
    assert digest(typed) == digest(out)


def check_budget(folder):
    """No list takes longer than the minutes. Where the clips alone do, they stay alone, and nothing is tried."""
    out = os.path.join(folder, "budget.poses.h5")
    words = [*SMALL, "--sample", "8", "--minutes"]
    figures, said = auto(out, *words, "1e-9", rig=BEND)
    assert figures["auto"]["tried"] == [] and figures["auto"]["chosen"] == "--choose all", figures["auto"]
    assert "the clips alone take" in said and figures["sampled"] == 0, said
    with h5py.File(out) as f:
        assert len(f["frames/time"]) == figures["candidates"]
    # Time for some five poses beside the clips; probes of one machine differ.
    minutes = figures["auto"]["clip_minutes"] * (1 + 5 / figures["candidates"])
    figures, _ = auto(out, *words, minutes, rig=BEND)
    rows = figures["auto"]["tried"]
    assert all(row["minutes"] <= minutes for row in rows[1:]), (minutes, rows)


def check_one_clip(folder):
    """With one clip the folds are blocks of it. A rig without limbs has no mixed poses. The same seed gives the same
    errors and the same bytes, whatever the number of threads."""
    out, again = os.path.join(folder, "bend.poses.h5"), os.path.join(folder, "again.poses.h5")
    figures, said = auto(out, *SMALL, "--sample", "3", rig=BEND)
    choice = figures["auto"]
    assert choice["pilot"]["folds"] == 4 and list(figures["frames_by_clip"])[0] == "bend", figures
    assert not choice["can_mix"] and "no limbs" in said, said
    assert [row["options"] for row in choice["tried"]][:2] == ["--choose all", "--choose all --sample 3"]
    other = auto(again, *SMALL, "--sample", "3", "--threads", "1", rig=BEND)[0]["auto"]
    assert [row["errors"] for row in other["tried"]] == [row["errors"] for row in choice["tried"]], (other, choice)
    assert digest(again) == digest(out)


def check_all_frames(folder):
    """--choose all lists the candidates in their order, also those that repeat others."""
    out = os.path.join(folder, "all.poses.h5")
    good("bake", "poses", MAN, "--fps", "5", "--choose", "all", "-o", out)
    with h5py.File(out) as f:
        assert len(f["frames/time"]) == 48 and list(f["frames/rank"][:]) == list(range(48))
        assert json.loads(f.attrs["provenance"])["options"]["choose"] == "all"


def check_failures(folder):
    out = os.path.join(folder, "no.poses.h5")
    bake = os.path.join(BIN, "penumbra-bake")
    call = [bake, "poses", MAN, "-o", out]
    refused(1, "--minutes needs --auto", *call, "--sample", "3", "--minutes", "3")
    refused(1, "--choose: --auto lists the frames", *call, "--auto", "--choose", "3")
    refused(1, "--minutes must be a finite number above 0", *call, "--auto", "--minutes", "0")
    refused(1, "--minutes must be", *call, "--auto", "--minutes", "nan")
    refused(1, "--choose must be 0..", *call, "--choose", "al")
    refused(1, "--auto: needs at least 8 frames of clips", *call, "--auto", "--fps", "1", "--clips", "walk", "--frames", "0:2")
    refused(2, "none.glb", bake, "poses", os.path.join(folder, "none.glb"), "-o", out, "--auto")
    # Without a fit, and with one that fails.
    lonely = os.path.join(folder, "lonely")
    os.makedirs(lonely)
    shutil.copy(bake, lonely)
    alone = [os.path.join(lonely, "penumbra-bake"), "poses", BEND, "-o", out, "--auto", *SMALL, "--sample", "3"]
    result = run(*alone, env={**os.environ, "PATH": lonely})
    assert result.returncode == 1 and "--auto: needs penumbra-fit" in result.stderr, result
    fit = os.path.join(lonely, "penumbra-fit")
    open(fit, "w").write("#!/bin/sh\necho no such luck >&2\nexit 3\n")
    os.chmod(fit, 0o755)
    result = run(*alone)
    assert result.returncode == 4 and "a trial fit failed: no such luck" in result.stderr, result
    open(fit, "w").write("#!/bin/sh\nexit 0\n")
    result = run(*alone)
    assert result.returncode == 4 and "a trial fit failed" in result.stderr, result
    assert not os.path.exists(out)


def check_interrupt(folder):
    """A signal ends it within seconds. No output and no temporary folder stays."""
    out, place = os.path.join(folder, "stopped.poses.h5"), os.path.join(folder, "tmp")
    os.makedirs(place)
    command = [os.path.join(BIN, "penumbra-bake"), "poses", MAN, "--fps", "10", "--auto", "-o", out, "-q"]
    process = subprocess.Popen(command, env={**os.environ, "TMPDIR": place}, stderr=subprocess.PIPE)
    while not os.listdir(place):
        time.sleep(0.05)
    time.sleep(1)
    process.send_signal(signal.SIGTERM)
    process.communicate(timeout=60)
    assert process.returncode != 0 and os.listdir(place) == [] and not os.path.exists(out), process.returncode


def main():
    with tempfile.TemporaryDirectory() as folder:
        check_all_frames(folder)
        check_failures(folder)
        check_choice(folder)
        check_budget(folder)
        check_one_clip(folder)
        check_interrupt(folder)


if __name__ == "__main__":
    main()
