#!/usr/bin/python3
"""Every source includes the headers of ours that declare what it names.

A build in batches cannot tell, because a source sees what those before it included. This check reads text alone: what a
header declares at namespace level (types, constants, functions, aliases) and what a file names outside of comments and
strings. Some header that declares the name must be among those that the file includes, directly or through others. It
takes seconds and sees nearly all (a name that two headers declare is taken for either, and names of others are not looked
for); scripts/dev/check_syntax lets the compiler look, in minutes. Exits 1 and lists each name."""
import collections
import functools
import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
TESTS = ROOT / "tests"  # whose headers the others do not see
FOLDERS = ("sh", "formats", "runtime", "bake", "fit", "pack", "player", "tests")
QUIET = re.compile(r'//[^\n]*|/\*.*?\*/|R"(\w*)\(.*?\)\1"|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])+\'', re.S)
INCLUDE = re.compile(r'^#include "([^"]+)"', re.M)
TEMPLATE = r"(?:template\s*<.*>\s*)?"
DECLARED = [re.compile(pattern, re.M) for pattern in (
    rf"^{TEMPLATE}(?:struct|class|union|enum class|enum)\s+(?:alignas\(.*?\)\s*|\[\[.*?\]\]\s*)*(\w+)",
    r"^(?:template\s*<.*>\s*)?using\s+(\w+)\s*=",
    r"^#define\s+(\w+)",
    r"^(?:inline |extern |static )*(?:constexpr|const) [^=;(){}\n]*?\b(\w+)(?:\[[^\]\n]*\])*\s*(?:=|\{|;)",
    # A function begins its line with its type. The name is the word before the first parenthesis.
    r"^(?=\w)(?!return|using|typedef)(?:[\w:<>,*&\[\]. ]+[ *&>])(\w+)\((?!\*)",
)]
WORD = re.compile(r"(?<![\w#])(\w+)")
MEMBER = re.compile(r"(?:\.|->)\s*$")
OTHERS = re.compile(r"::$")  # in a type, or in a namespace of others


@functools.cache
def text(path):
    """The code of a file: without comments and strings."""
    return QUIET.sub(lambda match: " " if match[0].startswith(("//", "/*")) else '""', path.read_text())


@functools.cache
def included(path):
    """The headers of ours that a file includes, with itself."""
    found, waiting = {path}, [path]
    while waiting:
        for name in INCLUDE.findall(waiting.pop().read_text()):
            header = ROOT / name
            if header not in found and header.exists():
                found.add(header)
                waiting.append(header)
    return found


def unnamed(code):
    """The code outside of unnamed namespaces, where a header would declare nothing for others."""
    return re.sub(r"^namespace \{$.*?^\}  *(?=//|$|\n)", "", code, flags=re.S | re.M)


def declared(path):
    found = {name for pattern in DECLARED for name in pattern.findall(text(path))}
    return {name for name in found if name != name.lower()}  # one word may be anything


@functools.cache
def own(path):
    """Names that a file gives to its own things: variables, parameters, lambdas, types and functions in types."""
    code = text(path)
    return (set(re.findall(r"[\w>\]&*]\s+[&*]*(\w+)\s*(?:[=;,){\[(:]|\bconst\b)", code)) |
            set(re.findall(r"\b(?:struct|class|union|enum|using|typename)\s+(\w+)", code)) |
            set(re.findall(r"\btypedef\b[^;(]*?(\w+)\s*(?:__attribute__|;)", code)) |
            set(re.findall(r"\busing [\w:]+::(\w+);", code)) |
            {name for test in re.findall(r"^TEST\w*\((\w+),\s*(\w+)\)", code, re.M) for name in test})


def uses(path, headers):
    """(name) of what the file names although it includes no header that declares it."""
    code = text(path)
    given = set().union(*(own(header) for header in included(path)))
    for match in WORD.finditer(code):
        name = match[1]
        others = {header for header in headers.get(name, ()) if header.is_relative_to(TESTS) <= path.is_relative_to(TESTS)}
        if not others or others & included(path) or name in given:
            continue
        before = code[max(0, match.start() - 40):match.start()]
        if not MEMBER.search(before) and not OTHERS.search(before):
            yield name


def main():
    files = [path for top in FOLDERS for path in sorted((ROOT / top).rglob("*")) if path.suffix in (".cpp", ".h")]
    headers = collections.defaultdict(set)
    for path in files:
        if path.suffix == ".h":
            for name in declared(path):
                headers[name].add(path)
    wrong = []
    sources = [path for path in files if path.suffix == ".cpp"]
    for path in sources:
        for name in sorted(set(uses(path, headers))):
            of = ", ".join(sorted(header.relative_to(ROOT).as_posix() for header in headers[name]))
            wrong.append(f"{path.relative_to(ROOT)}: names {name}, which is declared in {of}")
    print("\n".join(wrong) or f"{len(sources)} sources include what declares the names of ours that they use")
    return 1 if wrong else 0


sys.exit(main())
