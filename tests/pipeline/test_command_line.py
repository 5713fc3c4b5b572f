# The command line that all programs share: --help, --version, exit codes, one line for an error, and nothing left behind.
# Usage: test_command_line.py BIN_FOLDER
import hashlib
import json
import os
import re
import resource
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import processor_time

BIN = Path(sys.argv[1]).resolve()
ROOT = Path(__file__).resolve().parents[2]
failures = 0

# Program, verb, arguments; {in} is an input, {out} the output. Every verb that writes a file stands here.
VERBS = [
    ("penumbra-bake", "visibility", ["{in}", "-o", "{out}"]),
    ("penumbra-bake", "merge", ["{in}", "-o", "{out}"]),
    ("penumbra-bake", "reference", ["{in}", "--frame", "0", "-o", "{out}"]),
    ("penumbra-fit", "visibility", ["{in}", "-o", "{out}"]),
    ("penumbra-fit", "predict", ["{in}", "{in}", "-o", "{out}"]),
    ("penumbra-fit", "light", ["{in}", "-o", "{out}"]),
    ("penumbra-fit", "blockers", ["{in}", "-o", "{out}"]),
    ("penumbra-fit", "page", ["{in}", "-o", "{out}"]),
    ("penumbra-pack", "asset", ["{in}", "-o", "{out}"]),
    ("penumbra-pack", "truth", ["{in}", "-o", "{out}"]),
    ("penumbra-player", "render", ["{in}", "-o", "{out}"]),
]
READERS = [
    ("penumbra-bake", "info", ["{in}"]),
    ("penumbra-player", "bench", ["{in}"]),
    ("penumbra-pack", "check", ["{in}", "{in}"]),
]
# Program, verb, option, and a value below and one above its range.
RANGES = [
    *(("penumbra-bake", "visibility", *option) for option in (
        ("--fps", -1, 1001), ("--blocks", 0, 10001), ("--cache-fps", -1, 1000000), ("--order", 0, 9), ("--rays", 15, 65537),
        ("--seed", -1, 2**63), ("--bias", 1e-8, 0.2), ("--bounces", -1, 17))),
    *(("penumbra-bake", "reference", *option) for option in (
        ("--size", "0x1", "1x16385"), ("--samples", 3, 2**20 + 1), ("--aa", 0, 65), ("--bounces", -1, 17), ("--exposure", 0, "inf"))),
    ("penumbra-fit", "visibility", "--output-variance", 0, 1.5),
    ("penumbra-fit", "visibility", "--input-variance", 0, 1.5),
    ("penumbra-fit", "visibility", "--clusters", 0, 1000001),
    ("penumbra-fit", "light", "--order", 0, 9),
    ("penumbra-fit", "blockers", "--spheres", 0, 65),
    ("penumbra-pack", "asset", "--max-error", 0, "inf"),
    *(("penumbra-player", "render", *option) for option in (
        ("--aa", 0, 3), ("--sun-map", 7, 8193), ("--error-max", 0, "inf"), ("--exposure", -0.5, "nan"), ("--frame", -1, 2**31))),
]
EXTENSION = {"reference": ".png", "render": ".png"}


def check(condition, what):
    global failures
    if not condition:
        failures += 1
        print("FAILED:", what)


def run(arguments, cwd, **options):
    environment = {k: v for k, v in os.environ.items() if k not in ("PENUMBRA_THREADS", "CUE_THREADS")}
    environment.update(options.pop("env", {}))
    return subprocess.run([str(a) for a in arguments], cwd=cwd, capture_output=True, text=True, env=environment,
                          timeout=300, **options)


def entries(folder):
    return sorted(p.name for p in Path(folder).iterdir())


def expect_error(result, code, what, *words):
    """Checks the exit code, one line on stderr that starts with the program's name and holds the words, and an empty
    stdout."""
    lines = result.stderr.splitlines()
    check(result.returncode == code, f"{what}: exit code {result.returncode}, not {code}: {result.stderr.strip()}")
    check(len(lines) == 1 and lines[0].startswith("penumbra-"), f"{what}: not one line: {result.stderr!r}")
    check(result.stdout == "", f"{what}: wrote to stdout: {result.stdout!r}")
    for word in words:
        check(word in result.stderr, f"{what}: {word!r} is not in {result.stderr!r}")


def command(verb, source, target):
    program, name, arguments = verb
    return [BIN / program, name] + [a.format(**{"in": source, "out": target}) for a in arguments]


def test_programs(folder):
    for program in sorted({verb[0] for verb in VERBS + READERS}):
        for flag in ("-h", "--help"):
            result = run([BIN / program, flag], folder)
            check(result.returncode == 0 and "Verbs" in result.stdout and result.stderr == "", f"{program} {flag}")
        result = run([BIN / program, "--version"], folder)
        check(result.returncode == 0 and re.fullmatch(program + r" \S+\nformats: penumbra\.\w+ 1(, penumbra\.\w+ 1)*\n", result.stdout),
              f"{program} --version: {result.stdout!r}")
        expect_error(run([BIN / program], folder), 1, f"{program} without a verb", "verb", "--help")
        expect_error(run([BIN / program, "frobnicate"], folder), 1, f"{program} frobnicate", "frobnicate")
        expect_error(run([BIN / program, "--frobnicate"], folder), 1, f"{program} --frobnicate", "--frobnicate")


def test_usage(folder):
    for verb in VERBS + READERS:
        name = f"{verb[0]} {verb[1]}"
        result = run([BIN / verb[0], verb[1], "--help"], folder)
        check(result.returncode == 0 and "Options that all programs share" in result.stdout, f"{name} --help")
        good = command(verb, "in", "out" + EXTENSION.get(verb[1], ".out"))
        expect_error(run(good + ["--no-such-flag"], folder), 1, f"{name} --no-such-flag", "--no-such-flag")
        expect_error(run(good + ["--threads", "0"], folder), 1, f"{name} --threads 0", "--threads", "0", "1024")
        expect_error(run(good + ["--threads", "two"], folder), 1, f"{name} --threads two", "--threads", "two")
        expect_error(run(good + ["--progress", "loud"], folder), 1, f"{name} --progress loud", "--progress", "loud")
        for variable in ("PENUMBRA_THREADS", "CUE_THREADS"):
            expect_error(run(good, folder, env={variable: "-3"}), 1, f"{name} with {variable}=-3", variable, "-3")
        expect_error(run([BIN / verb[0], verb[1]], folder), 1, f"{name} without arguments", "required")
        expect_error(run(good + ["--report"], folder), 1, f"{name} --report", "--report needs a value")
        expect_error(run(good + ["--threads", "-q"], folder), 1, f"{name} --threads -q", "--threads needs a value")


def test_ranges(folder):
    verbs = {verb[:2]: verb for verb in VERBS + READERS}
    for program, name, option, low, high in RANGES:
        good = command(verbs[program, name], "in", "out" + EXTENSION.get(name, ".out"))
        for value in (low, high):
            expect_error(run([*good, f"{option}={value}"], folder), 1, f"{name} {option} {value}", option + " must ", str(value))


def test_files(folder):
    empty, rubbish = folder / "empty.glb", folder / "rubbish.glb"
    empty.write_bytes(b"")
    rubbish.write_bytes(bytes(range(256)) * 64)
    for verb in VERBS + READERS:
        name, output = f"{verb[0]} {verb[1]}", "out" + EXTENSION.get(verb[1], ".out")
        writes = verb in VERBS
        before = entries(folder)
        expect_error(run(command(verb, "missing.glb", output), folder), 2, f"{name} of a missing file", "missing.glb")
        expect_error(run(command(verb, ".", output), folder), 2, f"{name} of a folder")
        expect_error(run(command(verb, empty, output), folder), 3, f"{name} of an empty file", "empty.glb")
        expect_error(run(command(verb, rubbish, output), folder), 3, f"{name} of rubbish", "rubbish.glb")
        if writes:
            expect_error(run(command(verb, rubbish, "no/such/" + output), folder), 2, f"{name} into no folder", "no/such")
            expect_error(run(command(verb, rubbish, "/proc/" + output), folder), 2, f"{name} into /proc", "/proc")
            expect_error(run(command(verb, rubbish, "/dev/full"), folder), 2, f"{name} to a device", "/dev/full")
            expect_error(run(command(verb, rubbish, rubbish), folder), 1, f"{name} onto its input", "rubbish.glb")
            (folder / output).write_text("old")
            expect_error(run(command(verb, rubbish, output), folder), 3, f"{name} over an old file")
            expect_error(run(command(verb, rubbish, output) + ["--no-clobber"], folder), 2, f"{name} --no-clobber", output)
            check((folder / output).read_text() == "old", f"{name}: a failure changed the old file")
            (folder / output).unlink()
        check(entries(folder) == before, f"{name} left {set(entries(folder)) - set(before)}")


def test_report_of_a_failure(folder):
    before = entries(folder)
    (folder / "empty.h5").write_bytes(b"")
    result = run([BIN / "penumbra-bake", "info", "empty.h5", "--report", "report.json"], folder)
    report = json.loads((folder / "report.json").read_text())
    check(result.returncode == 3 and report["exit_code"] == 3, "report: exit code of a failure")
    check(report["schema"] == "penumbra.report" and report["schema_version"] == 1, "report: schema")
    check("empty.h5" in report["error"] and report["verb"] == "info", "report: error of a failure")
    expect_error(run([BIN / "penumbra-bake", "info", "empty.h5", "--depfile", "x.d"], folder), 1, "depfile without output")
    (folder / "empty.h5").unlink()
    (folder / "report.json").unlink()
    check(entries(folder) == before, "report: left something")


def test_names_of_files(folder):
    """What a run writes has a name of its own each, which is no input's. What it reads are regular files."""
    source, old = folder / "in.glb", b"rubbish that stays"
    source.write_bytes(old)
    (folder / "linked").symlink_to(".")
    (folder / "old.json").write_text("old")
    before = entries(folder)
    good = [BIN / "penumbra-bake", "visibility", "in.glb", "-o", "q.vis.h5"]
    for word in ("--report", "--depfile"):
        for same in ("in.glb", "./in.glb", source, "linked/in.glb"):
            expect_error(run(good + [word, same], folder), 1, f"{word} {same}", "is input and output")
        for same in ("q.vis.h5", "./q.vis.h5", folder / "q.vis.h5", "linked/q.vis.h5"):
            expect_error(run(good + [word, same], folder), 1, f"{word} {same}", "different files")
        expect_error(run(good + [word, "old.json", "--no-clobber"], folder), 2, f"{word} --no-clobber", "old.json")
        expect_error(run(good + [word, "no/x"], folder), 2, f"{word} into no folder", "no/x")
    expect_error(run(good + ["--report", "x", "--depfile", "./x"], folder), 1, "report as depfile", "different files")
    check(source.read_bytes() == old and (folder / "old.json").read_text() == "old", "names: a file was replaced")
    check(entries(folder) == before, f"names: left {entries(folder)}")
    # Here the report's own name is right, so the report tells of the failure.
    result = run(good[:-1] + ["in.glb", "--report", "r.json"], folder)
    expect_error(result, 1, "output onto the input, with a report", "is input and output")
    check(json.loads((folder / "r.json").read_text())["exit_code"] == 1, "names: report of a usage error")
    os.mkfifo(folder / "pipe")
    (folder / "link").symlink_to("pipe")
    # What a file names is treated as what the command line names.
    (folder / "named.gltf").write_text('{"asset": {"version": "2.0"}, "buffers": [{"uri": "pipe", "byteLength": 4}]}')
    expect_error(run([BIN / "penumbra-bake", "visibility", "named.gltf", "-o", "out.vis.h5"], folder), 2, "a buffer that is a pipe",
                 "pipe: not a regular file")
    for verb in VERBS + READERS:
        for name in ("pipe", "link", "/dev/zero"):
            result = run(command(verb, name, "out" + EXTENSION.get(verb[1], ".out")), folder)
            expect_error(result, 2, f"{verb[0]} {verb[1]} of {name}", name, "not a regular file")


def bake(rig, output, *more):
    return [BIN / "penumbra-bake", "visibility", rig, "-o", output, "--order", "3", *more]


def test_bake(folder, rig):
    """Does a whole run with report, depfile, dry run and info; then one with a full disk and one with a signal."""
    small = ["--fps", "2", "--rays", "16"]
    result = run(bake(rig, "dry.vis.h5", "--dry-run", "--report", "dry.json", *small), folder)
    check(result.returncode == 0 and entries(folder) == [], f"--dry-run wrote {entries(folder)}: {result.stderr}")
    result = run(bake(rig, "a.vis.h5", "--report", "a.json", "--depfile", "a.d", "--threads", "1", *small), folder)
    check(result.returncode == 0, f"bake: {result.stderr}")
    check(entries(folder) == ["a.d", "a.json", "a.vis.h5"], f"bake left {entries(folder)}")
    report = json.loads((folder / "a.json").read_text())
    check(report["exit_code"] == 0 and report["threads"] == 1 and report["phases"], "report of a bake")
    check(set(report["sha256"]) == {str(rig), "a.vis.h5"}, f"hashes in the report: {report['sha256']}")
    check(report["sha256"]["a.vis.h5"] == hashlib.sha256((folder / "a.vis.h5").read_bytes()).hexdigest(), "hash of the output")
    lines = run(bake(rig, "b.vis.h5", "-v", *small), folder).stderr.splitlines()
    stamp = r"\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d\.\d{3}Z penumbra-bake visibility: "
    check(len(lines) >= 3 and all(re.match(stamp, line) for line in lines), f"-v: {lines}")
    for style, pattern in (("openjd", r"openjd_(progress: \d+\.\d|status: .+)"), ("alf", r"ALF_PROGRESS \d+%")):
        lines = run(bake(rig, "b.vis.h5", "--progress", style, *small), folder).stdout.splitlines()
        check(len(lines) > 1 and all(re.fullmatch(pattern, line) for line in lines[:-1]), f"--progress {style}: {lines}")
        check("100" in lines[-2] or "100" in lines[-3], f"--progress {style} does not end at 100: {lines}")
    check((folder / "a.d").read_text().split() == ["a.vis.h5:", "\\", str(rig).replace(" ", "\\ ")], "depfile of a bake")
    result = run(bake(rig, "b.vis.h5", *small), folder, env={"CUE_THREADS": "3", "PENUMBRA_THREADS": "2"})
    check((folder / "a.vis.h5").read_bytes() == (folder / "b.vis.h5").read_bytes(), "other bytes with other threads")

    result = run([BIN / "penumbra-bake", "info", "a.vis.h5", "--report", "info.json"], folder)
    check(result.returncode == 0 and "hemisphere_visibility" in result.stdout, f"info: {result.stdout}{result.stderr}")
    figures = json.loads((folder / "info.json").read_text())["figures"]
    check(figures["provenance"]["tool"] == "penumbra-bake visibility", "info: tool")
    check(0.2 < figures["coefficients"]["mean_open_share"] < 1, "info: open share")
    with open("/dev/full", "w") as full:
        result = subprocess.run([BIN / "penumbra-bake", "info", folder / "a.vis.h5"], stdout=full, stderr=subprocess.PIPE)
        check(result.returncode == 2, "info to a full disk")


def test_full_disk(folder, rig):
    """To a program, a limit on the size of files is what a full disk is. Several sizes are tried."""
    (folder / "sky.hdr").write_bytes(b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 8 +X 16\n" + bytes([90, 99, 120, 128]) * 128)
    stages = [
        ("bake", "visibility", "f.vis.h5", [rig, "--order", "5", "--fps", "2", "--rays", "16"]),
        ("fit", "visibility", "f.model.h5", ["f.vis.h5"]),
        ("fit", "predict", "p.vis.h5", ["f.model.h5", "f.vis.h5"]),
        ("fit", "brdf", "f.brdf.h5", ["--analytic", "lambert"]),
        ("fit", "light", "f.light.h5", ["sky.hdr"]),
        ("pack", "asset", "f.pnb", ["f.model.h5", "--brdf", "f.brdf.h5", "--light", "f.light.h5"]),
        ("pack", "truth", "f.truth.pnb", ["f.vis.h5"]),
        ("player", "render", "f.png", ["f.pnb", "--size", "64x64"]),
    ]
    for program, verb, output, words in stages:
        command = [BIN / f"penumbra-{program}", verb, *words, "-o", output]
        result = run(command, folder)
        check(result.returncode == 0, f"{program} {verb}: {result.stderr}")
        whole = (folder / output).read_bytes()
        before = entries(folder)
        for limit in sorted({0, 100, min(4096, len(whole) - 1), len(whole) // 2, len(whole) - 1}):
            result = run(command + ["--quiet"], folder,
                         preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit)))
            expect_error(result, 2, f"{program} {verb} with {limit} bytes of disk", output, "File too large")
            check(entries(folder) == before and (folder / output).read_bytes() == whole,
                  f"{program} {verb}, full disk: {entries(folder)}")
    with open("/dev/full", "w") as full:
        (folder / "f.pnb").unlink()
        result = subprocess.run([BIN / "penumbra-pack", "asset", "f.model.h5", "-o", "f.pnb"], cwd=folder, stdout=full,
                                stderr=subprocess.PIPE, text=True)
        check(result.returncode == 2 and len(result.stderr.splitlines()) == 1, f"asset to a full disk: {result.stderr}")
        check((folder / "f.pnb").exists(), "results that cannot be printed take the whole output away")


def test_signals(folder, rig):
    before = entries(folder)
    for number in (signal.SIGTERM, signal.SIGINT):
        process = subprocess.Popen([str(a) for a in bake(rig, "c.vis.h5", "--fps", "60", "--rays", "4096")], cwd=folder,
                                   stderr=subprocess.PIPE, text=True)
        deadline = time.monotonic() + 60
        while not any("part" in name for name in entries(folder)) and time.monotonic() < deadline:
            time.sleep(0.02)
        while processor_time.of_running(process.pid) < 0.2 and process.poll() is None:  # it traces
            time.sleep(0.02)
        message, seconds = processor_time.stop(process, number)
        check(process.returncode == 4, f"{number.name}: exit code {process.returncode}: {message}")
        check(seconds < 1, f"{number.name}: took {seconds:.2f} s")
        check(entries(folder) == before, f"{number.name}: left {set(entries(folder)) - set(before)}")


def main():
    with tempfile.TemporaryDirectory(prefix="penumbra_command_line_") as name:
        top = Path(name)
        tests = [test_programs, test_usage, test_ranges, test_files, test_report_of_a_failure, test_names_of_files]
        for test in tests:
            folder = top / test.__name__
            folder.mkdir()
            test(folder)
        subprocess.run([sys.executable, ROOT / "scripts" / "samples" / "make_samples.py", top / "samples"], check=True,
                       stdout=subprocess.DEVNULL)
        rig = top / "samples" / "bend.glb"
        folder = top / "bake"
        folder.mkdir()
        for test in (test_bake, test_full_disk, test_signals):
            test(folder, rig)
    print("command line:", "ok" if failures == 0 else f"{failures} failures")
    return failures != 0


sys.exit(main())
