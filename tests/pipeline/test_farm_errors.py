"""The scripts of the farm tell rubbish, missing programs, full disks and killed jobs in a line with an exit code,
without a traceback.

usage: test_farm_errors.py BIN
"""
import os
import shutil
import subprocess
import sys
import tempfile

from farm_folder import SCRIPTS, make_farm, write

BIN = os.path.abspath(sys.argv[1])
FARM = os.path.join(SCRIPTS, "farm")


def told(code, *words, part="", env=None, cwd=None):
    """Runs a script and checks its exit code, and that it says one line and no traceback."""
    result = subprocess.run([str(word) for word in words], capture_output=True, text=True, cwd=cwd, env={**os.environ, **(env or {})})
    lines = result.stderr.splitlines()
    assert result.returncode == code and len(lines) == 1 and "Traceback" not in result.stderr and part in lines[0], (words, result)


def check_rubbish(folder):
    yaml, ninja = os.path.join(folder, "farm.yaml"), os.path.join(FARM, "farm_ninja")
    with open(yaml) as file:
        good = file.read()
    cases = {b"": "takes a map", b"\x00\xff\xfe": "not YAML", b"[" * 5000: "not YAML", b"a: &a [*a]\n": "no such key",
             b"? {a: b}\n: c\n": "", b"!!python/object/apply:os.system ['true']": "not YAML",
             good.replace("output: out", 'output: "a\\0b"').encode(): "printed", good.replace("fps: 3", "fps: x").encode(): "fps",
             good.replace("capsule_man.glb", "farm.yaml").encode(): "rigs.man",
             good.replace("output: out", "output: farm.yaml").encode(): ""}
    for text, part in cases.items():
        with open(yaml, "wb") as file:
            file.write(text)
        told(2 if b"output: farm.yaml" in text else 3, ninja, "farm.yaml", part=part, cwd=folder)
    write(yaml, good)
    told(2, ninja, "nowhere.yaml", cwd=folder)


def check_programs(folder):
    """Programs that are missing, that fail and that say what nobody expects."""
    for number, (body, code) in enumerate(((None, 2), ("#!/nowhere\n", 2), ("#!/bin/sh\nkill -9 $$\n", 3), ("#!/bin/sh\necho hello\n", 3))):
        programs = os.path.join(folder, f"programs{number}")
        os.mkdir(programs)
        for name in ("fit", "pack", "player", "bake"):
            os.symlink(os.path.join(BIN, f"penumbra-{name}"), os.path.join(programs, f"penumbra-{name}"))
        which = os.path.join(programs, "penumbra-fit" if code == 2 else "penumbra-bake")
        os.remove(which)
        if body:
            write(which, body)
            os.chmod(which, 0o755)
        shutil.rmtree(os.path.join(folder, "out"), ignore_errors=True)
        told(code, os.path.join(FARM, "farm_ninja"), "farm.yaml", cwd=folder, env={"PENUMBRA_BIN": programs})


def check_disk(folder):
    """Files that cannot be written, and memories of the farm that somebody damaged."""
    out = os.path.join(folder, "out")
    shutil.rmtree(out, ignore_errors=True)
    ninja = os.path.join(FARM, "farm_ninja")
    told(2, "bash", "-c", f"ulimit -f 0; exec {ninja} farm.yaml", part="File too large", cwd=folder)
    shutil.rmtree(out)
    write(out, "")
    told(2, ninja, "farm.yaml", cwd=folder)
    os.remove(out)
    os.makedirs(os.path.join(out, "build.ninja"))
    told(2, ninja, "farm.yaml", part="build.ninja", cwd=folder)
    os.rmdir(os.path.join(out, "build.ninja"))
    for name in ("asked", "digests", "submitted"):
        write(os.path.join(out, ".farm", name + ".json"), "[1" if name == "asked" else "[]")
    write(os.path.join(out, "man.stamp"), "{}")
    subprocess.run([ninja, "farm.yaml"], cwd=folder, check=True, stdout=subprocess.DEVNULL)


def check_jobs(folder):
    """A command of farm_stamp is not there or makes nothing. A killed command gives the exit code of a shell."""
    stamp = os.path.join(FARM, "farm_stamp")
    told(2, stamp, "x", "--", "/nowhere/program", cwd=folder)
    told(2, stamp, "x", "-i", "nowhere", "--", "true", cwd=folder)
    told(2, stamp, "x", "--", "true", cwd=folder)
    killed = subprocess.run([stamp, "x", "--", "sh", "-c", "kill -9 $$"], cwd=folder, capture_output=True, text=True)
    assert killed.returncode == 137 and not killed.stderr, killed


with tempfile.TemporaryDirectory() as folder:
    make_farm(folder, BIN)
    for check in (check_rubbish, check_programs, check_disk, check_jobs):
        check(folder)
print("farm: errors in one line")
