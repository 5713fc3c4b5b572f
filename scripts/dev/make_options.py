#!/usr/bin/python3
"""Writes docs/options.md, every flag of every program, from what the programs print for --help.

make_options.py BIN [-o FILE]     BIN is the folder of the programs; without -o the page goes to standard output

pipeline.test_options compares the page in the repository with what this script writes."""
import pathlib
import re
import subprocess
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent))
from make.verbs import HELP, make_parser
from usage import ArgumentParser

PROGRAMS = ("penumbra-bake", "penumbra-fit", "penumbra-pack", "penumbra-player")
SHARED = "Options that all programs share"
# A line of an option or a positional: two blanks, its name and what it takes, and, two blanks later, what it means.
ENTRY = re.compile(r"  (\S.*?)(?:   *(\S.*))?$")
HEADER = """# All options

`scripts/dev/make_options.py` makes this page from `--help` of every verb. A range and a default stand behind the kind
of value: `INT:1..8=5` is a whole number from 1 to 8, 5 unless told. [commands.md](commands.md) says what the verbs are
for, and the pages that it names explain the options in their context.
"""


def help_of(program, *verb):
    return subprocess.run([program, *verb, "--help"], check=True, capture_output=True, text=True).stdout.split("\n")


def groups_of(lines):
    """(title, [[name, takes, meaning]]) of every group of options in the lines of a --help."""
    groups = []
    for line in lines:
        if line.startswith(" " * 8) and groups and groups[-1][1]:  # goes on with the meaning of the entry above
            entry = groups[-1][1][-1]
            entry[2] = f"{entry[2]} {line.strip()}".strip()
        elif (entry := ENTRY.match(line)) and groups:
            name, _, takes = entry[1].replace("{false}", "").partition(" ")  # CLI11 marks a flag that unsets so
            groups[-1][1].append([name, takes, entry[2] or ""])
        elif line.endswith(":") and not line.startswith(" "):
            groups.append((line[:-1], []))
    return groups


def notes_of(lines):
    """Returns the text of a --help behind the options that all programs share, such as a list of materials."""
    begin = lines.index("", lines.index(SHARED + ":"))
    end = next(number for number, line in enumerate(lines) if line.startswith("Exit codes:"))
    return "\n".join(lines[begin:end]).strip()


def table(entries):
    def cell(text):
        return text.replace("|", "\\|")

    rows = "".join(f"| `{cell(name)}` | {cell(takes)} | {cell(meaning)} |\n" for name, takes, meaning in entries)
    return f"| option | takes | meaning |\n|---|---|---|\n{rows}"


def section(program, verb):
    """Returns the entry of one verb, without the options that every verb has."""
    lines = help_of(program, verb)
    text = [f"### {program.name} {verb}\n", f"{lines[0]}\n", f"```\n{lines[1].removeprefix('Usage: ')}\n```\n"]
    for title, entries in groups_of(lines):
        entries = [entry for entry in entries if entry[0] not in ("-h,--help", "--version")]
        if title == SHARED:
            break
        if not entries:
            continue
        if title not in ("Positionals", "Options"):
            text.append(f"{title}:\n")
        text.append(table(entries))
    if notes := notes_of(lines):
        text.append(f"```\n{notes}\n```\n")
    return "\n".join(text)


def own_program():
    """Returns the part of the page about the program `penumbra`. Its options come from the parser, because argparse
    lays its help out in another way in each version of Python."""
    entries = []
    for action in make_parser()._actions:
        if action.dest != "help":
            takes = "{%s}" % ",".join(action.choices) if action.choices else action.metavar or action.dest.upper()
            names = ",".join(action.option_strings) or action.metavar
            entries.append((names, "" if action.nargs == 0 else takes, action.help))
    return f"## penumbra\n\n```\n{HELP}```\n\n### penumbra make\n\n{table(entries)}"


def page(folder):
    programs = [folder / name for name in PROGRAMS]
    text = [HEADER]
    verbs = {program: [name for name, _, _ in dict(groups_of(help_of(program)))["Verbs"]] for program in programs}
    first = programs[0]
    shared = dict(groups_of(help_of(first, verbs[first][0])))[SHARED]
    text += [own_program(), "## Options of all verbs of the programs\n", table(shared)]
    for program in programs:
        text.append(f"## {program.name}\n")
        text += [section(program, verb) for verb in verbs[program]]
    return "\n".join(text)


def main():
    parser = ArgumentParser(__doc__)
    parser.add_argument("bin", type=pathlib.Path)
    parser.add_argument("-o", "--output", type=pathlib.Path)
    arguments = parser.parse_args()
    text = page(arguments.bin)
    if arguments.output:
        arguments.output.write_text(text)
    else:
        sys.stdout.write(text)


if __name__ == "__main__":
    main()
