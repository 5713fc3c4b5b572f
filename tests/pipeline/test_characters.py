"""scripts/characters/check_characters on two synthetic rigs: one that is read right, one that is cut. A program that
bakes another rig in its place must be found out.

usage: test_characters.py BIN

Skipped without node or npm's three, which scripts/characters/get_characters samples/characters brings; $PENUMBRA_THREE
names another node_modules.
"""
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile

BIN = pathlib.Path(sys.argv[1]).resolve()
ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
THREE = pathlib.Path(os.environ.get("PENUMBRA_THREE", ROOT / "samples/characters/three/node_modules"))
RIG, OTHER = (BIN.parent / "samples" / name for name in ("bend.glb", "capsule_man.glb"))


def check(folder, programs):
    run = subprocess.run([ROOT / "scripts/characters/check_characters", folder, "--bin", programs, "--three", THREE,
                          "--out", folder / "table.md"], capture_output=True, text=True)
    print(run.stdout, run.stderr)
    return run.returncode, run.stdout.splitlines(), (folder / "table.md").read_text()


def main():
    if not shutil.which("node") or not (THREE / "three").is_dir():
        sys.exit(77)
    with tempfile.TemporaryDirectory() as work:
        folder, programs = pathlib.Path(work, "characters"), pathlib.Path(work, "bin")
        folder.mkdir()
        programs.mkdir()
        shutil.copy(RIG, folder / "bend.glb")
        (folder / "cut.glb").write_bytes(RIG.read_bytes()[:-200])
        code, lines, table = check(folder, BIN)
        assert code == 0 and [line.split()[0] for line in lines[:2]] == ["right", "refused"], lines
        assert float(lines[0].split()[1]) < 1e-6 and "| all | glb | 2 | 1 | 0 | 1 | 0 |" in table, table

        wrong = programs / "penumbra-bake"
        wrong.write_text(f'#!/bin/sh\nverb=$1\nshift 2\nexec "{BIN}/penumbra-bake" "$verb" "{OTHER}" "$@"\n')
        wrong.chmod(0o755)
        code, lines, _ = check(folder, programs)
        assert code == 1 and lines[0].startswith("wrong"), lines


main()
