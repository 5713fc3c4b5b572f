"""docs/options.md has every flag of every verb, as the programs print them.

usage: test_options.py BIN
"""
import difflib
import os
import re
import sys

from farm_folder import SCRIPTS
from programs import BIN, must, run_tool

with open(os.path.join(SCRIPTS, "..", "docs", "options.md")) as file:
    stored = file.read()
made = must(sys.executable, os.path.join(SCRIPTS, "dev", "make_options.py"), BIN)
difference = list(difflib.unified_diff(stored.split("\n"), made.split("\n"), "docs/options.md", "made", lineterm="", n=0))
assert not difference, "\n".join([*difference[:20], "make it anew: scripts/dev/make_options.py BIN -o docs/options.md"])

# The script reads --help by its layout, so hold what it found to the flags themselves.
flags = 0
for tool in ("bake", "fit", "pack", "player"):
    for verb in re.findall(rf"^### penumbra-{tool} (\w+)$", made, flags=re.M):
        for name in re.findall(r"^  (?:-\w,)?(--[\w-]+)", run_tool(tool, verb, "--help").stdout, flags=re.M):
            flags += 1
            assert name in ("--help", "--version") or re.search(rf"^\| `(-\w,)?{name}` ", made, flags=re.M), (tool, verb, name)
assert flags > 400, flags
print(f"{flags} flags stand in docs/options.md")
