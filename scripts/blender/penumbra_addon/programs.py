"""Runs Penumbra's programs: where they are, how their progress is read, how they are stopped. Nothing here imports
bpy."""
import os
import pathlib
import queue
import re
import shlex
import shutil
import signal
import subprocess
import sys
import threading
from dataclasses import dataclass

FOUND_BY = "set the folder of the programs, or a command that starts them, in the preferences of the add-on"


class Failed(Exception):
    """A job cannot go on. The message is shown in the panel as it is."""


def words_of(text, windows):
    """The words of a command line. At Windows a backslash is part of a name; quotes join words and go away."""
    lexer = shlex.shlex(text, posix=True, punctuation_chars=False)
    lexer.whitespace_split, lexer.commenters = True, ""
    if windows:
        lexer.escape = ""
    try:
        return tuple(lexer)
    except ValueError as error:
        raise Failed(f"the command before the programs is no command line ({error}): {text}") from error


def parts_below(path, folder):
    """The parts of `path` below `folder`, or None. At Windows letters are one in either case."""
    if isinstance(path, pathlib.PureWindowsPath) and re.fullmatch("[A-Za-z]:", folder):
        folder += "\\"
    above = type(path)(folder).parts

    def plain(parts):
        return [part.lower() for part in parts] if isinstance(path, pathlib.PureWindowsPath) else list(parts)

    return path.parts[len(above) :] if plain(path.parts[: len(above)]) == plain(above) else None


@dataclass
class Programs:
    """How the programs are started: by a command before them (`wsl`, `docker run ...`), from a folder, or from PATH."""

    prefix: tuple = ()
    folder: str = ""
    path_from: str = ""  # how the names of files begin here, and
    path_to: str = ""  # how they begin where the programs run

    def argument(self, word):
        """A word of a command line. Names of files, which are pathlib paths, become those that the programs see."""
        if not isinstance(word, pathlib.PurePath):
            return str(word)
        below = parts_below(word, self.path_from) if self.path_from else None
        if below is not None:
            return "/".join([self.path_to.rstrip("/"), *below]) or "/"
        if not self.prefix or not word.drive:
            return str(word)
        if re.fullmatch("[A-Za-z]:", word.drive) and pathlib.PureWindowsPath(self.prefix[0]).stem.lower() == "wsl":
            return "/".join(["/mnt", word.drive[0].lower(), *word.parts[1:]])
        raise Failed(f"{word} has no name where the programs run: set Files here and there in the add-on's preferences")

    def program(self, tool):
        """The words that start a program, as in program("bake")."""
        name = "penumbra-" + tool
        if self.prefix:
            return [*self.prefix, self.folder.rstrip("/") + "/" + name if self.folder else name]
        found = shutil.which(name, path=self.folder or None)
        if not found:
            raise Failed(f"{name} was not found in {self.folder or 'PATH'}: {FOUND_BY}")
        return [found]

    def run(self, tool, *words):
        """Runs a program and gives (share done, what it does) as it goes on. Throws Failed with the program's reason.

        Whoever closes this generator stops the program.
        """
        command = self.program(tool) + [self.argument(word) for word in words]
        lines, messages = queue.Queue(), []
        process = start(command)
        readers = [reader(process.stdout, lines.put), reader(process.stderr, messages.append)]
        share, status = 0.0, f"penumbra-{tool} {words[0]}"
        try:
            while any(thread.is_alive() for thread in readers) or not lines.empty():
                try:
                    share, status = progress_of(lines.get(timeout=0.05), share, status)
                except queue.Empty:
                    pass
                yield share, status
            if process.wait() != 0:
                raise Failed(reason(f"penumbra-{tool}", process.returncode, messages))
        finally:
            stop(process)


def start(command):
    hidden = {"creationflags": subprocess.CREATE_NO_WINDOW} if sys.platform == "win32" else {}
    try:
        return subprocess.Popen(
            command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE, encoding="utf-8",
            errors="replace", env=environment(), **hidden
        )  # fmt: skip
    except OSError as error:
        raise Failed(f"{command[0]} cannot be started ({error.strerror}): {FOUND_BY}") from error


def environment():
    """Blender of some systems is started with library paths of its own, which are not for other programs."""
    own = ("PYTHONHOME", "PYTHONPATH", "LD_LIBRARY_PATH", "DYLD_LIBRARY_PATH")
    return {name: value for name, value in os.environ.items() if name not in own}


def reader(stream, take):
    def read():
        with stream:
            for line in stream:
                take(line.rstrip("\n"))

    thread = threading.Thread(target=read, daemon=True)
    thread.start()
    return thread


def progress_of(line, share, status):
    """Reads a line of `--progress openjd` (docs/farm.md); any other line changes nothing."""
    key, _, value = line.partition(": ")
    if key == "openjd_progress":
        try:
            return min(max(float(value) / 100, 0.0), 1.0), status
        except ValueError:
            return share, status
    return (share, value) if key == "openjd_status" else (share, status)


def reason(program, code, messages):
    """The last line of standard error that a program wrote, which says why it ended."""
    said = [line for line in messages if line.strip()]
    return said[-1] if said else f"{program} ended with exit code {code}"


def stop(process):
    """Ends a program that still runs: politely, so that it leaves no half file, and after two seconds by force."""
    if process.poll() is not None:
        return
    if sys.platform == "win32":
        process.terminate()
    else:
        process.send_signal(signal.SIGTERM)
    try:
        process.wait(timeout=2)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()
