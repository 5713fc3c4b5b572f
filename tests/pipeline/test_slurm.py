"""The pipeline on Slurm, on this machine alone: Snakemake's jobs, job arrays, a bake as one array. Jobs are killed in the middle;
every file must be what a local run makes, byte for byte.

Most of the time goes by in Slurm's queue, so the three run side by side, each in a folder of its own.

usage: test_slurm.py BIN
"""
import concurrent.futures
import glob
import hashlib
import os
import re
import subprocess
import sys
import tempfile
import time

from farm_folder import SCRIPTS, make_farm, outputs_made, replace, skip_without, snakemake, write

BIN = os.path.abspath(sys.argv[1])
SHARDS = 5
MAX_TASKS = 3  # an array has no more, so that the shards need two arrays
RAYS = 1024  # a shard takes about a second, so that it can be killed in the middle
SLURM = os.path.join(SCRIPTS, "farm", "slurm")


def make_slow_farm(folder):
    """Does what make_farm does with one of its rigs, whose bake is long enough to be killed in the middle: about a second a
    shard."""
    make_farm(folder, BIN)
    replace(os.path.join(folder, "farm.yaml"), "  bend: {files: [bend.glb], holdout: [sway]}\n", "")
    replace(os.path.join(folder, "farm.yaml"), "holdout: [walk],", f"holdout: [walk], shards: {SHARDS}, bake: {{rays: {RAYS}}},")
    return folder


def run(*words, cwd, code=0):
    result = subprocess.run(words, cwd=cwd, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    assert result.returncode == code, (words, result.returncode, result.stdout)
    return result.stdout


def bakes_under(folder):
    """Returns the process ids of the slow rig's bakes that run there."""
    found = []
    for place in glob.glob("/proc/[0-9]*"):
        try:
            with open(place + "/cmdline", "rb") as file:
                words = file.read().split(b"\0")
            here = os.readlink(place + "/cwd")
        except OSError:
            continue
        slow = words[0].endswith(b"penumbra-bake") and b"--resume" in words and words[2].endswith(b"capsule_man.glb")
        if slow and here.startswith(folder):
            found.append(int(os.path.basename(place)))
    return found


def wait_for(condition, what, pause=0.05):
    """Asks again and again, for five minutes at most, and returns the first answer that is true."""
    deadline = time.monotonic() + 300
    while not (result := condition()):
        assert time.monotonic() < deadline, "waited in vain for " + what
        time.sleep(pause)
    return result


def kill_one_bake(folder):
    while True:
        pid = wait_for(lambda: bakes_under(folder), "a bake in " + folder)[0]
        time.sleep(0.2)
        try:
            return os.kill(pid, 9)
        except ProcessLookupError:  # done already: the next one
            pass


def wait_for_queue(folder):
    """Waits until no job that works in a folder is in the queue."""
    words = ["squeue", "-h", "-o", "%Z"]
    left = lambda: [place for place in subprocess.check_output(words, text=True).splitlines() if place.startswith(folder)]
    wait_for(lambda: not left(), "the jobs in " + folder, pause=0.3)


def digests(out):
    """Returns the SHA-256 of every file that a farm keeps and that holds no times."""
    files = [name for kind in ("h5", "pnb", "png") for name in glob.glob(f"**/*.{kind}", root_dir=out, recursive=True)]
    return {name: hashlib.sha256(open(os.path.join(out, name), "rb").read()).hexdigest() for name in files if "shards/" not in name}


def check_snakemake(folder, wanted):
    """A job of Snakemake's is killed and submitted again."""
    make_slow_farm(folder)
    log = open(os.path.join(folder, "log"), "w+")
    process = subprocess.Popen(["snakemake", "-s", os.path.join(SCRIPTS, "farm", "Snakefile"), "--configfile", "farm.yaml", "--profile",
                                SLURM, "--latency-wait", "10"], cwd=folder, stdout=log, stderr=log, env={**os.environ, "CI": "true"})
    kill_one_bake(folder)
    code = process.wait(timeout=600)
    log.seek(0)
    text = log.read()
    assert code == 0 and "Trying to restart job" in text, text
    assert digests(os.path.join(folder, "out")) == wanted
    assert outputs_made(snakemake(folder, "-n")) == set()
    print(f"Snakemake on Slurm: {len(wanted)} files as made here, a killed shard was baked again")


def check_arrays(folder, wanted):
    """Shards take two arrays, and the merge waits for both. A task is killed: it goes back into the queue. One is cancelled: what
    waits for it ends, and is taken up again."""
    make_slow_farm(folder)
    command = [os.path.join(SLURM, "farm_array"), "farm.yaml"]
    text = run(*command, cwd=folder)
    first, second = re.search(rf"shard: {SHARDS} tasks, array (\d+), (\d+)\n", text).groups()
    assert re.search(rf"merge: 1 tasks, array \d+, after {first}, {second}\n", text), text
    text = run(*command, cwd=folder)
    assert "jobs are under way" in text and "tasks" not in text, text
    run("scancel", f"{second}_{SHARDS - MAX_TASKS - 1}", cwd=folder)
    kill_one_bake(os.path.join(folder, "out"))
    wait_for(lambda: any("Restarts=1" in run("scontrol", "-o", "show", "job", array, cwd=folder) for array in (first, second)),
             "a requeued task", pause=0.3)
    wait_for_queue(folder)
    assert not os.path.exists(os.path.join(folder, "out", "index.html"))
    text = run(*command, cwd=folder)
    assert "shard: 1 tasks" in text, text
    wait_for_queue(folder)
    assert digests(os.path.join(folder, "out")) == wanted
    assert "nothing to do" in run(*command, cwd=folder)
    print(f"arrays on Slurm: {len(wanted)} files as made here; one task was killed, one cancelled")


def check_bake_array(folder, wanted):
    """A task and the first merge are killed: both go back into the queue. Meanwhile the same bake is not submitted again."""
    make_slow_farm(folder)
    os.makedirs(os.path.join(folder, "out", "man"))
    programs = os.path.join(folder, "programs")
    os.mkdir(programs)
    write(os.path.join(programs, "penumbra-bake"), f"""#!/bin/sh
if [ "$1" = merge ] && mkdir {programs}/killed 2>/dev/null; then kill -9 $$; fi
exec {BIN}/penumbra-bake "$@"
""")
    os.chmod(os.path.join(programs, "penumbra-bake"), 0o755)
    words = [os.path.join(SLURM, "bake_array"), str(SHARDS), "out/man/man.vis.h5", "capsule_man.glb", "--fps", "3", "--rays", str(RAYS)]
    text = run("env", f"PENUMBRA_BIN={programs}", *words, cwd=folder)
    jobs = re.match(rf"array (\d+), (\d+): {SHARDS} shards of \d+ frames; merge (\d+): ", text).groups()
    text = run("env", f"PENUMBRA_BIN={programs}", *words, cwd=folder, code=2)
    assert text.startswith(f"bake_array: out/man/man.vis.h5: still made by jobs {' '.join(jobs)}; ") and text.count("\n") == 1, text
    kill_one_bake(folder)
    wait_for_queue(folder)
    assert os.path.exists(os.path.join(programs, "killed"))
    assert digests(os.path.join(folder, "out")) == {"man/man.vis.h5": wanted["man/man.vis.h5"]}
    print("one bake as an array: the same bytes, a killed shard was baked again, a killed merge merged again")


def daemons(folder):
    alive = []
    for daemon in ("munged", "slurmctld", "slurmd"):
        with open(os.path.join(folder, daemon + ".pid")) as file:
            alive.append(int(file.read()))
    return alive


def check_all(top):
    local = make_slow_farm(os.path.join(top, "local"))
    snakemake(local)
    wanted = digests(os.path.join(local, "out"))
    assert len(wanted) == 9, wanted
    checks = {check_snakemake: "jobs", check_arrays: "arrays", check_bake_array: "bake"}
    with concurrent.futures.ThreadPoolExecutor(len(checks)) as pool:
        for done in [pool.submit(check, os.path.join(top, name), wanted) for check, name in checks.items()]:
            done.result()


def main():
    skip_without("snakemake", "sbatch", "slurmctld", "slurmd", "munged")
    if os.geteuid() != 0:
        print("skipped: slurmd starts jobs as root only")
        sys.exit(77)
    with tempfile.TemporaryDirectory() as top:
        cluster = os.path.join(top, "slurm")
        os.environ["SLURM_CONF"] = os.path.join(cluster, "slurm.conf")
        run(os.path.join(SLURM, "local_cluster"), "start", cluster, "2", f"MaxArraySize={MAX_TASKS}",
            f"AuthInfo=socket={cluster}/munge.socket,cred_expire=5", cwd=top)  # a requeued job waits for 5 s
        pids = daemons(cluster)
        try:
            assert "export SLURM_CONF=" in run(os.path.join(SLURM, "local_cluster"), "start", cluster, "2", cwd=top)
            assert daemons(cluster) == pids, "a second start started others"
            check_all(top)
        finally:
            run(os.path.join(SLURM, "local_cluster"), "stop", cluster, cwd=top)
        assert not any(os.path.exists(f"/proc/{pid}") for pid in pids), pids


main()
