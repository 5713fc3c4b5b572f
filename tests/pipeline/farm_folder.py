"""A farm of synthetic rigs that takes seconds, for the tests of the pipeline."""
import functools
import os
import re
import shutil
import subprocess
import sys
import traceback

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
SCRIPTS = os.path.join(ROOT, "scripts")
FARM = """output: out
defaults: {{fps: 3, shards: {shards}, bake: {{rays: 16}}, fit: {{model: linear, clusters: 2}}}}
rigs:
  bend: {{files: [bend.glb], holdout: [sway]}}
  man: {{files: [capsule_man.glb], holdout: [walk], materials: [clay], lights: [grey]}}
materials:
  clay: {{analytic: lambert}}
  gold: {{analytic: "ggx:alpha=0.4"}}
lights:
  grey: {{analytic: "uniform:radiance=1"}}
  sky: {{analytic: sky}}
pictures: {{frames: 1, size: 32}}
"""


def make_farm(folder, bins, shards=1):
    """Makes FOLDER/farm.yaml and its rigs. The programs of `bins` are used."""
    os.environ["PENUMBRA_BIN"] = os.path.abspath(bins)
    os.makedirs(folder, exist_ok=True)
    for rig in ("bend.glb", "capsule_man.glb"):
        shutil.copy(os.path.join(bins, "..", "samples", rig), folder)
    write(os.path.join(folder, "farm.yaml"), FARM.format(shards=shards))


def write(path, text):
    with open(path, "w") as file:
        file.write(text)


def replace(path, old, new):
    with open(path) as file:
        text = file.read()
    assert old in text, (path, old)
    write(path, text.replace(old, new))


def snakemake(folder, *words, code=0, env=None):
    """Runs Snakemake and returns all that it printed."""
    command = ["snakemake", *words, "-s", os.path.join(SCRIPTS, "farm", "Snakefile"), "--configfile", "farm.yaml"]
    if "--profile" not in words:
        command.append("-c2")
    result, text = run_forked(command, folder, env) if imported_snakemake() else run_program(command, folder, env)
    assert result == code, (words, result, text)
    return text


def run_program(command, folder, env):
    """Exit code and output of a command."""
    done = subprocess.run(command, cwd=folder, env=env, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    return done.returncode, done.stdout


@functools.cache
def imported_snakemake():
    """Whether Snakemake's modules could be imported here, which is most of what an idle run of it does."""
    try:
        import snakemake.workflow
        import smart_open  # the Snakefile's reader imports it late
        return hasattr(snakemake, "main") and bool(smart_open)
    except ImportError:
        return False


def run_forked(command, folder, env):
    """As run_program(), in a fork of this process, which has imported Snakemake already."""
    sys.stdout.flush()
    sys.stderr.flush()
    read, write_end = os.pipe()
    pid = os.fork()
    if pid == 0:
        os.close(read)
        os._exit(snakemake_here(command, folder, env, write_end))
    os.close(write_end)
    with os.fdopen(read) as pipe:
        text = pipe.read()
    return os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1]), text


def snakemake_here(command, folder, env, output):
    """Runs Snakemake in this process, which ends afterwards, and returns its exit code.

    It forgets what the test imported of the farm, because the Snakefile of the command must import its own.
    """
    for descriptor in (1, 2):
        os.dup2(output, descriptor)
    os.close(output)
    sys.stdin = open(os.devnull)
    os.chdir(folder)
    if env is not None:
        os.environ.clear()
        os.environ.update(env)
    for name in [name for name in sys.modules if name.split(".")[0] in ("farm", "usage")]:
        del sys.modules[name]
    sys.argv = command
    code = 1
    try:
        sys.modules["snakemake"].main(command[1:])
        code = 0
    except SystemExit as end:
        code = end.code if isinstance(end.code, int) else int(end.code is not None)
    except BaseException:
        traceback.print_exc()
    sys.stdout.flush()
    sys.stderr.flush()
    return code


def outputs_made(text):
    """Returns the outputs of the jobs that Snakemake ran, or would run."""
    return set(re.findall(r"^    output: (\S+)", text, re.M))


def skip_without(*programs):
    for program in programs:
        if not shutil.which(program):
            print(f"skipped: {program} is not installed (scripts/setup installs it)")
            sys.exit(77)
