#!/usr/bin/python3
"""Checks every Markdown file: the paths that it names exist, its links lead somewhere, its prose fits into 120 columns.

check_docs.py [FILE.md]...     without arguments all files that git tracks

A path is a word in code, inline or in a block, that begins with a folder of the repository or of the document's own
folder; it may be a pattern (`fit/models/train_*.cpp`). The name of a source file without a folder must be that of some
file. Tables, code blocks and lines with a URL may be longer than 120 columns."""
import fnmatch
import pathlib
import re
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
COLUMNS = 120
MADE = {ROOT / name for name in ("build", "samples", "demo-out")}  # may be empty
SOURCES = {".h", ".cpp", ".py", ".fbs", ".comp", ".vert", ".frag", ".glsl", ".md"}
PATH = re.compile(r"(?<![\w/.$-])\.?[\w-]+(?:/[\w.*-]+)+/?|(?<![\w/.$*-])[\w*-]+\.\w+(?![\w/])")
LINK = re.compile(r"\]\(([^)\s]+)\)")


def tracked():
    return subprocess.run(["git", "ls-files"], cwd=ROOT, check=True, stdout=subprocess.PIPE, text=True).stdout.split("\n")


def anchors(path):
    """The anchors of a document's headings, as GitHub forms them."""
    text = re.sub(r"^```.*?^```", "", path.read_text(), flags=re.M | re.S)
    headings = re.findall(r"^#+ +(.*)$", text, flags=re.M)
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}


def is_missing(word, document, names):
    """Whether a word of code is a path or a source file's name, and there is no such file."""
    if "/" not in word:
        return pathlib.PurePath(word).suffix in SOURCES and not fnmatch.filter(names, word)
    for folder in (document.parent, ROOT):
        if (first := folder / word.split("/")[0]).is_dir() and first not in MADE:
            return not any(folder.glob(word.rstrip("/")))
    return False


def errors_of(document, names):
    """(line, message) of everything that is wrong with a document."""
    block = False
    for number, line in enumerate(document.read_text().split("\n"), 1):
        if line.startswith("```"):
            block = not block
            continue
        pieces = [line] if block else re.findall(r"`([^`]+)`", line)
        for word in (word for piece in pieces for word in PATH.findall(piece)):
            if is_missing(word, document, names):
                yield number, f"{word}: no such file"
        if block:
            continue
        for target in LINK.findall(re.sub(r"`[^`]*`", "", line)):
            path, _, anchor = target.partition("#")
            linked = document.parent / path if path else document
            if re.match(r"\w+:", target):
                continue
            if not linked.exists():
                yield number, f"{target}: the link leads nowhere"
            elif anchor and anchor not in anchors(linked):
                yield number, f"{target}: no such heading"
        if len(line) > COLUMNS and not line.startswith("|") and "://" not in line:
            yield number, f"{len(line)} columns, more than {COLUMNS}"


def main():
    files = tracked()
    names = {pathlib.PurePath(file).name for file in files}
    chosen = sys.argv[1:] or [file for file in files if file.endswith(".md")]
    wrong = [f"{file}:{number}: {message}" for file in chosen
             for number, message in errors_of((ROOT / file).resolve(), names)]
    print("\n".join(wrong), end="\n" if wrong else "")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
