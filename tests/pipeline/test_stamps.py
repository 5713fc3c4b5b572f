"""farm_stamp, farm_ninja (ninja and make) and farm_check: content decides what runs again, and foreign files are named.

usage: test_stamps.py BIN
"""
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile

from farm_folder import SCRIPTS, make_farm, replace, write

BIN = os.path.abspath(sys.argv[1])
STAMP = os.path.join(SCRIPTS, "farm", "farm_stamp")


def run(*words, cwd=".", code=0):
    result = subprocess.run([str(w) for w in words], cwd=cwd, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    assert result.returncode == code, (words, result.returncode, result.stdout)
    return result.stdout


def copy(*flags, command=("sh", "-c", "cp in.txt out.txt; echo ran >>log"), code=0):
    """Runs a stamped copy. Returns whether the command itself ran."""
    before = os.path.getsize("log") if os.path.exists("log") else 0
    text = run(STAMP, "out.txt", "-i", "in.txt", *flags, "--", *command, code=code)
    return os.path.getsize("log") > before if os.path.exists("log") else False, text


def check_stamp():
    write("in.txt", "one")
    assert copy()[0] and not copy()[0]
    made = os.stat("out.txt").st_mtime_ns
    os.utime("in.txt")
    os.utime("out.txt")
    assert not copy()[0]
    write("in.txt", "two")
    assert copy()[0] and open("out.txt").read() == "two" and os.stat("out.txt").st_mtime_ns > made
    assert copy(command=("sh", "-c", "cp in.txt out.txt; echo ran  >>log"))[0], "another command"
    os.remove("out.txt")
    assert copy()[0], "the output is gone"
    made = os.stat("out.txt").st_mtime_ns
    assert not copy("--touch")[0] and os.stat("out.txt").st_mtime_ns > made
    stamp = json.load(open("out.txt.stamp"))
    write("out.txt.stamp", json.dumps(stamp)[:-20])
    assert copy()[0], "half a stamp"
    write("out.txt", "from elsewhere")
    ran, text = copy(code=3)
    assert not ran and "out.txt: is not the file that was made here" in text, text
    ran, text = run(STAMP, "next.txt", "-i", "out.txt", "--", "cp", "out.txt", "next.txt", code=3), ""
    assert "out.txt: is not the file that was made here" in ran and not os.path.exists("next.txt"), ran
    os.remove("out.txt")
    assert copy()[0]
    write("in.txt", "three")
    assert copy(command=("sh", "-c", "exit 4"), code=4) and copy()[0], "a failed command is no result"
    assert "nothing.txt" in run(STAMP, "new.txt", "-i", "nothing.txt", "--", "cp", "nothing.txt", "new.txt", code=2)
    print("farm_stamp: content decides")


def check_renamed():
    """A renamed file from outside runs nothing, unless clips are named after it."""
    stamp = lambda path: run(STAMP, "named.txt", "-i", os.path.abspath(path), "--", "sh", "-c", 'cp "$0" named.txt; echo ran',
                             os.path.abspath(path))
    for first, then, runs in (("a.glb", "b.glb", False), ("walk.bvh", "stroll.bvh", True)):
        write(first, "some bytes")
        assert "ran" in stamp(first)
        os.rename(first, then)
        assert ("ran" in stamp(then)) == runs, then
        os.remove("named.txt")
    print("farm_stamp: renamed files")


def check_killed():
    """An output that was killed between its new name and its stamp is made again. It is neither foreign nor
    current."""
    write("in.txt", "four")
    assert copy()[0]
    write("in.txt", "five")
    die = ("sh", "-c", "cp in.txt out.txt; kill -9 $PPID")
    assert subprocess.run([STAMP, "out.txt", "-i", "in.txt", "--", *die], capture_output=True).returncode == -9
    assert open("out.txt").read() == "five" and not os.path.exists("out.txt.stamp")
    assert copy()[0] and not copy()[0]
    print("farm_stamp: killed before the stamp, made again")


def check_failed_report():
    """The output of a failed command (the report of a check) is deleted. The output of an earlier run
    stays."""
    fail = ("sh", "-c", "echo failed >out.txt; exit 3")
    copy(command=fail, code=3)
    assert not os.path.exists("out.txt") and not os.path.exists("out.txt.stamp")
    assert copy()[0]
    copy(command=("sh", "-c", "exit 3"), code=3)
    assert open("out.txt").read() == "five"
    assert copy()[0]


def check_memory():
    """No job fails because its digests cannot be remembered."""
    os.rename(".farm", ".farm.kept")
    write(".farm", "a file where the folder should be")
    write("in.txt", "six")
    assert copy()[0] and not copy()[0]
    os.remove(".farm")
    os.rename(".farm.kept", ".farm")
    assert not [name for name in os.listdir(".") if ".part" in name]


def check_order():
    """Inputs in another order are other inputs, even where their names are the same. Folders are no part of a
    name."""
    for folder in ("first", "second"):
        os.mkdir(folder)
        write(f"{folder}/x.txt", folder)
    a, b = (os.path.abspath(f"{folder}/x.txt") for folder in ("first", "second"))
    join = lambda *files: run(STAMP, "joined.txt", *(word for f in files for word in ("-i", f)), "--",
                              sys.executable, "-c", "import sys; open('joined.txt', 'w').write(open(sys.argv[1]).read())", *files)
    join(a, b)
    assert open("joined.txt").read() == "first"
    join(b, a)
    assert open("joined.txt").read() == "second"
    made = os.stat("joined.txt").st_mtime_ns
    os.rename("second", "third")
    join(b.replace("second", "third"), a)
    assert os.stat("joined.txt").st_mtime_ns == made


def check_depfile():
    """A file that only the command knows to have read counts from the second run on. Blanks and $ in names are kept."""
    write("a b$.txt", "one")
    write("rule.sh", 'cp "a b\\$.txt" dep.txt; printf "dep.txt: a\\\\ b\\$\\$.txt\\n" >dep.d; echo ran >>log2')
    words = [STAMP, "dep.txt", "--depfile", "dep.d", "--", "sh", "rule.sh"]
    count = lambda: len(open("log2").readlines())
    run(*words)
    os.remove("dep.d")  # ninja removes the file, too
    run(*words)
    assert count() == 1 and open("dep.d").read() == "dep.txt: a\\ b$$.txt\n", open("dep.d").read()
    write("a b$.txt", "two")
    run(*words)
    assert count() == 2 and open("dep.txt").read() == "two"


def reports(folder):
    """Returns report -> time of writing, which tells the programs that ran."""
    top = os.path.join(folder, "out", "reports")
    return {name: os.stat(os.path.join(top, name)).st_mtime_ns for name in os.listdir(top)}


def ran_by(folder, *command):
    before = reports(folder) if os.path.exists(os.path.join(folder, "out", "reports")) else {}
    text = run(*command, cwd=folder)
    return {name.removesuffix(".json") for name, time in reports(folder).items() if before.get(name) != time}, text


def touch_all(folder):
    for name in run("find", folder, "-type", "f", "-not", "-path", "*/.*").split("\n"):
        if name:
            os.utime(name)


def check_build(folder, flags, build, idle):
    """Makes the whole farm, then nothing, nothing after touching everything, and only what a changed material
    changes."""
    make_farm(folder, BIN, shards=2)
    generate = [os.path.join(SCRIPTS, "farm", "farm_ninja"), "farm.yaml", *flags]
    run(*generate, cwd=folder)
    ran, _ = ran_by(folder, *build)
    assert len(ran) == 19 and "index.html" in ran and "man.shards.000000-000015.vis.h5" in ran, ran
    ran, text = ran_by(folder, *build)
    assert ran == set() and idle in text, (ran, text)
    touch_all(folder)
    ran, _ = ran_by(folder, *build)
    assert ran == set(), ran
    ran, text = ran_by(folder, *build)
    assert ran == set() and idle in text, (ran, text)
    replace(os.path.join(folder, "farm.yaml"), "alpha=0.4", "alpha=0.5")
    ran, _ = ran_by(folder, *build)
    assert ran == {"materials.gold.brdf.h5", "bend.bend.pnb", "bend.sheet.png", "index.html"}, ran
    check_needs(folder, build[0])
    print(f"{build[0]}: {len(reports(folder))} jobs; touched, none; a material changed, {len(ran)} and the check")


def check_needs(folder, program):
    """Threads and memory of `jobs:` reach the commands and ninja's pools. The changed YAML file is read without being
    told."""
    replace(os.path.join(folder, "farm.yaml"), "pictures:", "jobs: {fit: {threads: 3, memory_mb: 100000000}}\npictures:")
    plan = "Makefile" if program == "make" else "build.ninja"
    run(program, "-C", "out", plan, cwd=folder)
    text = open(os.path.join(folder, "out", plan)).read()
    of_fit = [line for line in text.split("\n") if "penumbra-fit visibility" in line]
    assert len(of_fit) == 2 and all("PENUMBRA_THREADS=3 " in line for line in of_fit), of_fit
    assert text.count("PENUMBRA_THREADS=1 ") == 19, text
    if program == "ninja":
        assert "pool of_3_threads_100000000_mb\n  depth = 1\n" in text and text.count("  pool = of_3_threads_100000000_mb\n") == 2, text
        assert re.search(r"pool of_1_threads_2000_mb\n  depth = [1-9]", text), text


def check_lists(folder):
    """Runs every line of every list in order, each in a shell of its own: first the whole farm, and then nothing."""
    make_farm(folder, BIN, shards=2)
    run(os.path.join(SCRIPTS, "farm", "farm_ninja"), "farm.yaml", "--lists", cwd=folder)
    lists = os.path.join(folder, "out", "lists")
    lines = [line for name in sorted(os.listdir(lists)) for line in open(os.path.join(lists, name))]
    assert len(lines) == 21, lines
    for line in lines:
        run("sh", "-c", line, cwd="/")
    shards = os.listdir(os.path.join(folder, "out", "man", "shards"))
    assert os.path.exists(os.path.join(folder, "out", "index.html")) and shards, shards
    assert not [name for name in shards if name.endswith(".vis.h5")], shards
    assert "nothing to do" in run(os.path.join(SCRIPTS, "farm", "slurm", "farm_array"), "farm.yaml", cwd=folder)
    # All lines run again do nothing. Without the merged file its shards are wanted again.
    ran, _ = ran_by(folder, "sh", "-c", "set -e\n" + "".join(f"({line.strip()})\n" for line in lines))
    assert ran == set() and not any(name.endswith(".vis.h5") for name in os.listdir(os.path.join(folder, "out", "man", "shards"))), ran
    os.remove(os.path.join(folder, "out", "man", "man.vis.h5"))
    ran, _ = ran_by(folder, "sh", "-c", "set -e\n" + "".join(f"({line.strip()})\n" for line in lines))
    assert len(ran) == 3 and "man.man.vis.h5" in ran, ran
    print(f"lists: {len(lines)} commands")


def check_belonging(folder):
    """farm_check names the asset whose model was replaced, and a file that is cut short."""
    check = os.path.join(SCRIPTS, "farm", "farm_check")
    out = os.path.join(folder, "out")
    assert "0 disagree" in run(check, out, os.path.join(folder, "bend.glb"))
    model, asset = (os.path.join(out, "man", name) for name in ("man.model.h5", "man.pnb"))
    shutil.copy(os.path.join(out, "bend", "bend.model.h5"), model)
    text = run(check, out, code=3)
    assert f"{asset}: made from another man.model.h5" in text, text
    with open(model, "r+b") as file:
        file.truncate(1000)
    assert "man.model.h5" in run(check, out, code=2)
    with open(os.path.join(folder, "bend.glb"), "ab") as file:
        file.write(b" ")
    os.remove(model)
    text = run(check, out, os.path.join(folder, "bend.glb"), code=3)
    assert "bend.vis.h5: made from another bend.glb" in text, text
    print("farm_check: names what does not belong")


def main():
    with tempfile.TemporaryDirectory() as top:
        os.mkdir(os.path.join(top, "stamps"))
        os.chdir(os.path.join(top, "stamps"))
        check_stamp()
        check_renamed()
        check_killed()
        check_failed_report()
        check_memory()
        check_order()
        check_depfile()
        check_build(os.path.join(top, "with $ and blank"), [], ["ninja", "-C", "out"], "no work to do")
        check_build(os.path.join(top, "plain"), ["--make"], ["make", "-C", "out", "-j2"], "is up to date")
        check_belonging(os.path.join(top, "plain"))
        check_lists(os.path.join(top, "lists"))


main()
