"""Finds the comments of source files: C and C++, GLSL, TypeScript, FlatBuffers, Python, shell and CMake.

A comment is a run of comment lines that start in one column, the text behind some code with the lines that go on below
it in the same column, a block comment, or the docstring of a Python module, class or function."""
import pathlib
import re
from typing import NamedTuple

# A comment's mark within a text begins no comment, and a quote between digits, as in 1'000, begins no text.
SLASHES = re.compile(r"""(?P<line>//[^\n]*)|(?P<block>/\*.*?\*/)|R"(?P<raw>\w*)\(.*?\)(?P=raw)"|"(?:\\.|[^"\\\n])*"
                         |(?<!\w)'(?:\\.|[^'\\\n])*'""", re.S | re.X)
HASHES = re.compile(r"""(?P<line>(?:(?<=\s)|^)\#(?!!)[^\n]*)|^[ ]*(?P<block>\"\"\".*?\"\"\")|\"\"\".*?\"\"\"|'{3}.*?'{3}
                        |"(?:\\.|[^"\\\n])*"|'(?:\\.|[^'\\\n])*'""", re.S | re.X | re.M)
SLASHED = {".c", ".h", ".cpp", ".ts", ".js", ".mjs", ".fbs", ".comp", ".vert", ".frag", ".glsl"}
HASHED = {".py", ".cmake"}


class Comment(NamedTuple):
    line: int
    text: str  # without marks and line breaks
    columns: int  # the longest line, with the code before it


def comments_in(path):
    """Returns the comments of a file in their order; none of a file that is no source."""
    path = pathlib.Path(path)
    if path.suffix in SLASHED:
        return comments_of(path.read_text(), SLASHES)
    is_script = not path.suffix and path.read_bytes()[:2] == b"#!"
    if is_script or path.suffix in HASHED or path.name == "CMakeLists.txt":
        return comments_of(path.read_text(), HASHES)
    return []


def comments_of(text, pattern):
    """Returns the comments of a source's text, which `pattern` finds."""
    found, last_line, last_column = [], -2, -1
    line, counted = 1, 0
    for match in pattern.finditer(text):
        kind = "line" if match["line"] else "block" if match["block"] else None
        if not kind:
            continue
        start, end = match.span(kind)
        line += text.count("\n", counted, start)
        counted = start
        begin = text.rfind("\n", 0, start) + 1
        whole_lines = text[begin:(text + "\n").index("\n", end)].split("\n")
        words = re.sub(r"^[/*#!<\"\s]+|[*/\"\s]+$", "", match[kind])
        new = Comment(line, re.sub(r"\s*\n[\s*]*", " ", words), max(map(len, whole_lines)))
        column = start - begin
        if kind == "line" and line == last_line + 1 and column == last_column and not whole_lines[0][:column].strip():
            before = found.pop()
            new = Comment(before.line, f"{before.text} {new.text}".strip(), max(before.columns, new.columns))
        found.append(new)
        if kind == "line":
            last_line, last_column = line, column
    return found
