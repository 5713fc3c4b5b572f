"""Full disks, read-only folders, other file systems: a clear error and an old file that is still there, or a whole
file.

Mounts small file systems: as root, or as root of a user namespace of its own. Where neither is allowed, CTest skips it.
usage: test_disk.py BIN
"""
import contextlib
import os
import subprocess
import sys
import tempfile

from programs import digest

BIN = os.path.abspath(sys.argv[1])
BAKE = os.path.join(BIN, "penumbra-bake")
MAN = os.path.join(BIN, "..", "samples", "capsule_man.glb")
SMALL = ["--fps", "4", "--rays", "16", "--order", "4"]


def run(*words):
    return subprocess.run([BAKE, *map(str, words)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


@contextlib.contextmanager
def mounted(folder, options):
    """A tmpfs at the folder."""
    subprocess.run(["mount", "-t", "tmpfs", "-o", options, "tmpfs", folder], check=True)
    try:
        yield
    finally:
        subprocess.run(["umount", folder], check=True)


def can_mount(*before):
    """Whether a command after these words can mount a tmpfs. The mount is gone when the command ends."""
    words = [*before, "unshare", "--mount", "mount", "-t", "tmpfs", "tmpfs", tempfile.gettempdir()]
    return subprocess.run(words, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL).returncode == 0


def become_root():
    """Starts this script again in a user namespace if it may not mount here."""
    own_root = ["unshare", "--user", "--map-root-user", "--mount"]
    if can_mount():
        return
    if can_mount(*own_root):
        os.execvp("unshare", [*own_root, sys.executable, *sys.argv])
    print("skipped: this user may neither mount file systems nor make user namespaces")
    sys.exit(77)


def check_full(disk, shards, whole):
    """Disks of several sizes, from none to almost enough; the journal gives way to the output."""
    size = os.path.getsize(whole)
    for room, words in ((16, None), (size // 2048, None), (size // 1024 - 8, None), (size // 2048, shards)):
        with mounted(disk, f"size={room}k"):
            out = os.path.join(disk, "a.vis.h5")
            result = run("merge", *words, "-o", out) if words else run("visibility", MAN, *SMALL, "-o", out, "-q")
            assert result.returncode == 2 and len(result.stderr.splitlines()) == 1, (room, result)
            assert "a.vis.h5" in result.stderr and "No space left" in result.stderr, result
            assert os.listdir(disk) == [], os.listdir(disk)
    # Room for the output but not for the journal besides.
    with mounted(disk, f"size={size // 1024 + 64}k"):
        assert run("visibility", MAN, *SMALL, "-o", os.path.join(disk, "a.vis.h5")).returncode == 0
        assert digest(os.path.join(disk, "a.vis.h5")) == digest(whole) and os.listdir(disk) == ["a.vis.h5"]
    # With --resume what was traced stays for a run with more room.
    with mounted(disk, f"size={size // 2048}k"):
        out = os.path.join(disk, "a.vis.h5")
        assert run("visibility", MAN, *SMALL, "-o", out, "--resume").returncode == 2
        assert os.listdir(disk) == ["a.vis.h5.journal"], os.listdir(disk)
        subprocess.run(["mount", "-o", "remount,size=16m", "tmpfs", disk], check=True)
        assert "went on after" in run("visibility", MAN, *SMALL, "-o", out, "--resume").stdout
        assert digest(out) == digest(whole) and os.listdir(disk) == ["a.vis.h5"]


def check_full_fields(disk, shards, whole):
    """The fields of parts, whose datasets are written in another place: the file is named all the same."""
    out = os.path.join(disk, "a.fields.h5")
    for room in (16, 400, 1000, 1600):
        with mounted(disk, f"size={room}k"):
            result = run("fields", MAN, "--rays", "16", "-o", out, "-q")
            assert result.returncode == 2 and len(result.stderr.splitlines()) == 1, (room, result)
            assert out + ": " in result.stderr and "No space left" in result.stderr, (room, result)
            assert os.listdir(disk) == [], os.listdir(disk)


def check_read_only(disk, shards, whole):
    with mounted(disk, "size=16m"):
        out = os.path.join(disk, "a.vis.h5")
        assert run("merge", *shards, "-o", out).returncode == 0  # another file system than the shards'
        assert digest(out) == digest(whole)
        subprocess.run(["mount", "-o", "remount,ro", "tmpfs", disk], check=True)
        for words in (["visibility", MAN, *SMALL], ["merge", *shards], ["visibility", MAN, *SMALL, "--resume", "--seed", "2"]):
            result = run(*words, "-o", out)
            assert result.returncode == 2 and len(result.stderr.splitlines()) == 1, result
            assert "Read-only" in result.stderr and digest(out) == digest(whole), result
        # Reading needs no writing.
        assert run("info", out).returncode == 0


def main():
    become_root()
    with tempfile.TemporaryDirectory() as folder:
        disk, whole = os.path.join(folder, "disk"), os.path.join(folder, "whole.vis.h5")
        os.mkdir(disk)
        result = run("visibility", MAN, *SMALL, "-o", whole)
        frames = int(result.stdout.split(" frames")[0].split()[-1])
        shards = [os.path.join(folder, f"s{i}.vis.h5") for i in range(2)]
        for shard, part in zip(shards, (f"0:{frames // 2}", f"{frames // 2}:{frames}")):
            assert run("visibility", MAN, *SMALL, "--frames", part, "-o", shard).returncode == 0
        for check in (check_full, check_full_fields, check_read_only):
            check(disk, shards, whole)
            print(f"{check.__name__}: ok")


main()
