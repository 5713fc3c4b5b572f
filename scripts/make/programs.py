"""Where the programs are, and how one is run to its end."""
import os
import shutil
import subprocess
import sys

from farm.config import ConfigError, programs_folder
from make.failure import FAILED, UNREADABLE, Failure

NAMES = ("penumbra-bake", "penumbra-fit", "penumbra-pack", "penumbra-player")


def own_folder():
    """Returns the folder that the user called `penumbra` in, without and with its links followed."""
    called = shutil.which(sys.argv[0]) or sys.argv[0]
    return [os.path.dirname(os.path.abspath(called)), os.path.dirname(os.path.realpath(called))]


def folder():
    """Returns $PENUMBRA_BIN, the folder that `penumbra` lies in, the build of this checkout, the install folder, or
    "" for $PATH. Raises Failure when the programs are nowhere."""
    beside = [place for place in own_folder() if os.path.isfile(os.path.join(place, NAMES[0]))]
    try:
        return programs_folder(beside[0] if beside else None, ".")
    except ConfigError:
        named = os.environ.get("PENUMBRA_BIN")
        where = f"in $PENUMBRA_BIN ({named})" if named else "beside penumbra, in build/release/bin or in $PATH"
        raise Failure(f"penumbra-bake is not {where}: install the packages, run scripts/setup and build, or set PENUMBRA_BIN",
                      UNREADABLE) from None


def find(name):
    """Returns the path of one of our programs."""
    place = folder()
    path = os.path.join(place, name) if place else shutil.which(name)
    if not path or not os.access(path, os.X_OK):
        raise Failure(f"{name} is not {'in ' + place if place else 'in $PATH'}: install or build it", UNREADABLE)
    return path


def ask(*words, **more):
    """Runs a program and returns what subprocess.run() does, with its texts."""
    return subprocess.run([str(word) for word in words], stdin=subprocess.DEVNULL, capture_output=True, text=True,
                          errors="replace", **more)


def complaint(result, fallback="failed"):
    """Returns what a program that failed says last."""
    lines = [line for line in result.stderr.splitlines() if line.strip()]
    return lines[-1] if lines else fallback


def become(name, words):
    """Replaces this process by a program. It has the terminal, the signals and the exit code from here on."""
    path = find(name)
    try:
        os.execv(path, [path, *words])
    except OSError as error:
        raise Failure(f"{path}: {error.strerror}", FAILED) from None
