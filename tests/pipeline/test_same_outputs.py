"""What the programs write for one small rig has the hashes of tests/golden/output_hashes.json.

A change that is meant to change results makes that file again, and says so:
    scripts/dev/output_hashes build/release/bin build/release/samples/capsule_man.glb -o tests/golden/output_hashes.json

The hashes are of Debian 12: other versions of Embree, Eigen, the C library and Mesa round otherwise. Skipped elsewhere.

usage: test_same_outputs.py BIN
"""
import json
import pathlib
import platform
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
BIN = pathlib.Path(sys.argv[1]).resolve()

system = platform.freedesktop_os_release()
if (system["ID"], system.get("VERSION_ID")) != ("debian", "12"):
    print(f"skipped: the hashes are of Debian 12, and this is {system['PRETTY_NAME']}")
    sys.exit(77)
expected = json.loads((ROOT / "tests/golden/output_hashes.json").read_text())
text = subprocess.run(["/usr/bin/python3", ROOT / "scripts/dev/output_hashes", BIN, BIN.parent / "samples/capsule_man.glb"],
                      check=True, stdout=subprocess.PIPE, text=True).stdout
made = json.loads(text)
assert made.keys() == expected.keys(), made.keys() ^ expected.keys()
changed = [name for name in expected if made[name] != expected[name]]
assert not changed, f"other contents than before: {', '.join(changed)}"
print(f"{len(made)} files have the contents that they had")
