"""A wrong command line of a script ends with 1 and its usage, as of a program; 2 means that something cannot be read or
written.

usage: test_usage.py BIN
"""
import glob
import os
import subprocess
import sys

from farm_folder import SCRIPTS

found = []
for path in sorted(glob.glob(os.path.join(SCRIPTS, "**", "*"), recursive=True)):
    if not os.path.isfile(path) or path.endswith(".pyc"):
        continue
    with open(path) as file:
        text = file.read()
    assert "argparse.ArgumentParser(" not in text or path.endswith("usage.py"), f"{path}: scripts/usage.py has the exit code"
    if "ArgumentParser(__doc__" not in text:
        continue
    result = subprocess.run([sys.executable, path, "--no-such-option"], capture_output=True, text=True)
    name = os.path.basename(path)
    assert result.returncode == 1 and result.stderr.startswith(f"usage: {name}") and f"\n{name}: " in result.stderr, (path, result)
    found.append(name)
assert len(found) >= 14, found
print(f"{len(found)} scripts exit with 1")
