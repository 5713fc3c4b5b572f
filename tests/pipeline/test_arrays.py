"""The scripts of Slurm's job arrays without Slurm: a task and its signals, long lines, an sbatch that refuses; and what the farm's
YAML file says of occluders in folders with a colon.

usage: test_arrays.py BIN
"""
import os
import shlex
import signal
import subprocess
import sys
import tempfile
import time

from farm_folder import SCRIPTS, write

sys.path.insert(0, SCRIPTS)
from farm.config import ConfigError, Unreadable, an_occluder

TASK = os.path.join(SCRIPTS, "farm", "slurm", "task")
BAKE_ARRAY = os.path.join(SCRIPTS, "farm", "slurm", "bake_array")
STOPS = """import signal, sys, time
def stop(*_):
    open("stopped", "w").close()
    sys.exit(4)
signal.signal(signal.SIGTERM, stop)
open("started", "w").close()
time.sleep(60)
"""


def program(path, text):
    write(path, text)
    os.chmod(path, 0o755)


def start_task(*words):
    write("commands", shlex.join(words) + "\n")
    return subprocess.Popen([TASK, "commands"], env={**os.environ, "SLURM_ARRAY_TASK_ID": "0"}, start_new_session=True,
                            stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)


def wait_for(path, seconds):
    end = time.monotonic() + seconds
    while not os.path.exists(path):
        assert time.monotonic() < end, path
        time.sleep(0.02)


def check_task():
    """Tries lines of 200 KB, exit codes of commands, and SIGTERM as Slurm sends it, to all processes."""
    words = [f"shard-{i:06}.vis.h5" for i in range(10000)]
    count = start_task(sys.executable, "-c", "import sys; print(len(sys.argv), 'words'); sys.exit(3)", *words)
    text = count.communicate()[0]
    assert count.returncode == 3 and text.startswith("10001 words\n") and os.path.getsize("commands") > 128 * 1024, (count.returncode, text)
    write("stops.py", STOPS)
    task = start_task(sys.executable, "stops.py")
    wait_for("started", 30)
    os.killpg(task.pid, signal.SIGTERM)
    wait_for("stopped", 5)  # at once on an idle machine
    task.communicate()


def bake_array(*words, code, **environment):
    path = os.path.abspath("programs") + ":" + os.environ["PATH"]
    result = subprocess.run([BAKE_ARRAY, *words], capture_output=True, text=True,
                            env={**os.environ, "PATH": path, "PENUMBRA_BIN": os.path.abspath("programs"), **environment})
    assert result.returncode == code, (words, result)
    return result.stderr


def check_bake_array():
    """Refuses what is no number of shards. An sbatch takes some arrays and refuses the next. A folder's name has a
    %."""
    os.mkdir("programs")
    program("programs/penumbra-bake", "#!/bin/sh\necho 9 frames\n")
    program("programs/squeue", "#!/bin/sh\n")
    program("programs/scontrol", "#!/bin/sh\necho 'MaxArraySize = 2'\n")
    program("programs/sbatch", '#!/bin/sh\necho "$@" >>asked\nn=$(wc -l <asked)\n'
            '[ $n -le $TAKES ] || { echo "sbatch: error: no" >&2; exit 1; }\necho $n\n')
    for shards in ("0", "-1", "many", "1.5", "08"):
        text = bake_array(shards, "x.vis.h5", "rig.glb", code=1, TAKES="9")
        assert f"not '{shards}'" in text and "bake_array N OUT.vis.h5" in text and not os.path.exists("x.vis.h5.shards"), text
    assert bake_array("5", "50%A.vis.h5", "rig.glb", code=4, TAKES="2").endswith(
        "sbatch: error: no\nbake_array: submitted, without what should follow: array 1, 2\n")
    assert "--output=50%%A.vis.h5.shards/%A_%a.log" in open("asked").read(), open("asked").read()
    os.remove("asked")
    assert bake_array("5", "x.vis.h5", "rig.glb", code=4, TAKES="0") == "sbatch: error: no\n"
    os.remove("asked")
    assert "array 1, 2, 3\n" in bake_array("5", "x.vis.h5", "rig.glb", code=4, TAKES="3")
    bake_array("5", "x.vis.h5", "rig.glb", code=0, TAKES="9")


def check_colons(top):
    """Single files and folders may lie in a folder with a colon, but what is split at colons may not."""
    folder = os.path.join(top, "a:b")
    os.makedirs(os.path.join(folder, "frames"))
    for place in (folder, top):
        for name in ("body.obj", "body.mdd", "f_1.obj"):
            write(os.path.join(place, name), "")
    write(os.path.join(folder, "frames", "f_1.obj"), "")
    for given in ("body.obj", "frames"):
        assert an_occluder("occluder", given, folder) == os.path.join(folder, given)
    for given, place in (("body.obj:body.mdd", folder), ("f_%d.obj", folder), ("a:b/body.obj:a:b/body.mdd", top), ("a:b/f_#.obj", top),
                         (f"{top}/body.obj:body.mdd", folder)):
        try:
            assert False, ("taken", an_occluder("occluder", given, place))
        except ConfigError as error:
            assert str(error).endswith(f"folder with a colon: {folder}"), (given, str(error))
    for given in ("body.obj:body.mdd", f"{top}/body.obj:{top}/body.mdd"):
        assert an_occluder("occluder", given, top) == f"{top}/body.obj:{top}/body.mdd"
    assert an_occluder("occluder", f"{top}/body.obj:{top}/body.mdd", folder) == f"{top}/body.obj:{top}/body.mdd"
    try:
        assert False, an_occluder("occluder", "body.obj:nobody.mdd", top)
    except Unreadable as error:
        assert "no such file" in str(error), error


with tempfile.TemporaryDirectory() as top:
    os.chdir(top)
    check_task()
    check_bake_array()
    check_colons(os.path.join(top, "colons"))
    os.chdir("/")
print("arrays: long lines, signals, refusals; occluders and colons")
