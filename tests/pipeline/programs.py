"""The tests of the programs share this: how they run one, and what they ask of it.

The folder of the programs is the first argument of every test.
"""
import hashlib
import os
import subprocess
import sys

BIN = os.path.abspath(sys.argv[1])


def run(*words, **options):
    return subprocess.run([*map(str, words)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, **options)


def must(*words):
    """Runs a program that does its work, and returns what it says."""
    result = run(*words)
    assert result.returncode == 0, (words, result.returncode, result.stderr)
    return result.stdout


def refused(code, part, *words):
    """Runs a program that ends with this code and names this part of the reason."""
    result = run(*words)
    assert result.returncode == code and part in result.stderr, (words, result.returncode, result.stderr)


def run_tool(tool, *words, **options):
    """The same by the short name of a program, as in run_tool("bake", "visibility", ...)."""
    return run(os.path.join(BIN, "penumbra-" + tool), *words, **options)


def good(tool, *words):
    result = run_tool(tool, *words)
    assert result.returncode == 0, (tool, words, result.returncode, result.stderr)
    return result


def digest(path):
    with open(path, "rb") as file:
        return hashlib.sha256(file.read()).hexdigest()
