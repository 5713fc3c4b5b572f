#!/usr/bin/python3
"""No type has two definitions in one program: the linker would silently take the functions of either.

Reads every type at namespace level outside unnamed namespaces; sh and formats are in every program (rigs in penumbra-bake
and penumbra-fit only), each of bake, fit, pack and player (and its tests) with them. Exits 1 and lists every name that is
defined twice."""
import collections
import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
SHARED = ["sh", "formats"]
PROGRAMS = {"bake": ["bake"], "fit": ["fit"], "pack": ["pack", "player/runtime"], "player": ["player", "player/runtime"]}
WITHOUT_RIGS = ["pack", "player"]
NO_CODE = re.compile(r"""//[^\n]*|/\*.*?\*/|R"([^\s()\\]*)\(.*?\)\1"|"(?:\\.|[^"\\\n])*"|(?<![0-9a-fA-F])'(?:\\.|[^'\\\n])+'""", re.S)
ATTRIBUTE = r"(?:alignas\s*\((?:[^()]|\([^()]*\))*\)|\[\[.*?\]\])\s*"
TYPE = re.compile(rf"(?:template.*>\s*)?(?:struct|class|union|enum class|enum)\s+(?:{ATTRIBUTE})*(\w+)(?!\w|::)(?:[^;{{]*\{{|[^;]*$)")


def code_of(path):
    """Returns the file's lines without comments, strings and characters, whose braces do not count."""
    return NO_CODE.sub(lambda match: "\n" * match[0].count("\n"), path.read_text()).split("\n")


def types_of(path):
    """Returns (name, "FILE:LINE") of the types that other files can clash with."""
    depth, open_namespaces = 0, []  # of each the depth around it, and whether it is unnamed
    for number, line in enumerate(code_of(path), 1):
        if re.match(r"(inline )?namespace\b[^=;]*\{", line):
            open_namespaces.append((depth, bool(re.search(r"namespace\s*\{", line))))
        elif (match := TYPE.match(line)) and not any(unnamed for _, unnamed in open_namespaces):
            yield match[1], f"{path.relative_to(ROOT)}:{number}"
        depth += line.count("{") - line.count("}")
        while open_namespaces and depth <= open_namespaces[-1][0]:
            open_namespaces.pop()
    if depth:
        sys.exit(f"{path.relative_to(ROOT)}: braces do not match: this script cannot read it")


def folder_of(place):
    parts = place.removeprefix("tests/").split("/")
    return "player/runtime" if parts[:2] == ["player", "runtime"] else parts[0]


def is_in(place, program):
    if program in WITHOUT_RIGS and place.startswith("formats/rig/"):
        return False
    return folder_of(place) in [*SHARED, *PROGRAMS[program]]


def main():
    places = collections.defaultdict(list)
    for top in [*SHARED, *PROGRAMS, "tests"]:
        for path in sorted((ROOT / top).rglob("*")):
            if path.suffix in (".cpp", ".h"):
                for name, place in types_of(path):
                    places[name].append(place)
    wrong = set()
    for name, all_places in places.items():
        for program in PROGRAMS:
            found = [place for place in all_places if is_in(place, program)]
            if len(found) > 1:
                wrong.add(f"{name}: {', '.join(sorted(found))}")
    print("\n".join(sorted(wrong)) or f"{len(places)} types, each defined once a program")
    return 1 if wrong else 0


sys.exit(main())
