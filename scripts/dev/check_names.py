#!/usr/bin/python3
"""No type has two definitions in one program: the linker would silently take the functions of either.

The compiler sees two functions of one name (-Wmissing-declarations), but no type that two files define. So a .cpp file
defines types in unnamed namespaces alone, and no two headers that can meet in a program define a type of one name. Reads
what clang-format leaves: what stands at namespace level begins its line. Sources of tests are compiled several at once, so
tests/X/test_Y.cpp stands in namespace penumbra::test_Y. Exits 1 and lists every place."""
import collections
import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
ATTRIBUTE = r"(?:alignas\(.*?\)|\[\[.*?\]\])\s*"
TYPE = re.compile(rf"(?:template.*>\s*)?(?:struct|class|union|enum class|enum)\s+(?:{ATTRIBUTE})*(\w+)(?!\w|::)(?:[^;{{]*\{{|[^;]*$)")
# Folder, of sources or of tests -> the programs that it is in; every other folder is in all of them. Tests of player
# and of the C interface link pack.
PROGRAMS = {"bake": {"bake"}, "fit": {"fit"}, "pack": {"pack", "player"}, "player": {"player"}, "capi": {"player"},
            "formats/rig": {"bake"}, "runtime": {"pack", "player"}}


def types_of(path):
    """(name, line number) of each type outside unnamed namespaces."""
    unnamed = 0
    for number, line in enumerate(path.read_text().split("\n"), 1):
        unnamed += line.startswith("namespace {")
        unnamed -= line == "}  // namespace"
        if not unnamed and (match := TYPE.match(line)):
            yield match[1], number
    if unnamed:
        sys.exit(f"{path.relative_to(ROOT)}: an unnamed namespace without its end: run clang-format")


def programs_of(relative):
    folders = relative.removeprefix("tests/").split("/")[:-1]
    return PROGRAMS.get("/".join(folders[:2])) or PROGRAMS.get(folders[0] if folders else "") or set.union(*PROGRAMS.values())


def tests_without_namespace():
    for path in sorted((ROOT / "tests").glob("*/test_*.cpp")):
        if f"\nnamespace penumbra::{path.stem} {{\n" not in path.read_text():
            yield f"{path.relative_to(ROOT)}: stands not in namespace penumbra::{path.stem}"


def main():
    wrong, places = [], collections.defaultdict(list)
    for top in ("sh", "formats", "runtime", "bake", "fit", "pack", "player", "tests"):
        for path in sorted((ROOT / top).rglob("*")):
            relative = path.relative_to(ROOT).as_posix()
            for name, line in types_of(path) if path.suffix in (".cpp", ".h") else ():
                if path.suffix == ".cpp":
                    wrong.append(f"{relative}:{line}: {name} belongs in an unnamed namespace")
                # Within one file `#if` may choose between two, and the compiler sees the rest.
                wrong += [f"{relative}:{line}: {name} is also in {other}" for other in places[name]
                          if other != relative and programs_of(other) & programs_of(relative)]
                places[name].append(relative)
    wrong += tests_without_namespace()
    print("\n".join(wrong) or f"{len(places)} types, each defined once a program")
    return 1 if wrong else 0


sys.exit(main())
