"""The pipeline runs again what changed, and nothing else: Snakemake, Ninja, Make and farm_stamp on tiny synthetic rigs.

usage: test_reruns.py BIN
"""
import os
import re
import shutil
import subprocess
import sys
import tempfile

import processor_time
from farm_folder import SCRIPTS, make_farm, outputs_made, replace, run_program, skip_without, snakemake, write

sys.path.insert(0, SCRIPTS)
from farm import config
from farm.camera import camera_problem
from farm.config import ConfigError, read_config
from farm.plan import buffers_of, make_plan

BIN = os.path.abspath(sys.argv[1])
OF_GOLD = {"materials/gold.brdf.h5", "bend/bend.pnb", "bend/check.json", "bend/sheet.png", "index.html"}
OF_MAN = {"man/man.vis.h5", "man/man.model.h5", "man/man.pnb", "man/man.truth.pnb", "man/check.json", "man/sheet.png", "index.html"}


def kept(text):
    """Returns the outputs of the jobs that Snakemake ran or would run, without shards."""
    return {output for output in outputs_made(text) if "/shards/" not in output}


def expect(folder, wanted, what):
    found = kept(snakemake(folder, "-n"))
    assert found == wanted, (what, "not run:", wanted - found, "run:", found - wanted)
    print(f"{what}: {len(wanted)} jobs")


def touch_everything(folder):
    for where, _, names in os.walk(folder):
        for name in names:
            if ".snakemake" not in where and ".farm" not in where:
                os.utime(os.path.join(where, name))


def check_first_run(folder):
    """All files are there and named on the page. A second run does nothing, and hardly takes longer than Snakemake needs to start."""
    made = kept(snakemake(folder))
    out = os.path.join(folder, "out")
    assert OF_GOLD | OF_MAN <= made and all(os.path.getsize(os.path.join(out, name)) for name in made), made
    page = open(os.path.join(out, "index.html")).read()
    for name in (made - {"index.html"}) | {"reports/man.man.pnb.json"}:
        assert f'href="{name}"' in page, name
    assert 'src="man/sheet.png"' in page and "http:" not in page and "https:" not in page and "<script" not in page
    command = ["snakemake", "-s", os.path.join(SCRIPTS, "farm", "Snakefile"), "--configfile", "farm.yaml", "-c2"]
    seconds, text = processor_seconds(command, folder)
    least, _ = processor_seconds(["snakemake", "--version"], folder)
    assert "Nothing to be done" in text, text
    # Measured: 2.2 times.
    assert seconds <= 5 * least, (seconds, least)
    print(f"second run: nothing to do, {seconds:.1f} s, {seconds / least:.1f} times as long as to say a version")


def processor_seconds(command, folder):
    """Seconds of processor time that a command took, and its output."""
    before = processor_time.of_ended_children()
    code, text = run_program(command, folder, None)
    assert code == 0, (command, code, text)
    return processor_time.of_ended_children() - before, text


def check_touch(folder):
    touch_everything(folder)
    expect(folder, set(), "everything touched")
    out = os.path.join(folder, "out")
    os.rename(out, out + ".old")
    shutil.copytree(out + ".old", out, copy_function=shutil.copyfile)
    shutil.rmtree(os.path.join(out, ".snakemake"))
    shutil.rmtree(out + ".old")
    expect(folder, set(), "copied without time stamps and without Snakemake's memory")
    os.rename(folder, folder + " elsewhere")
    expect(folder + " elsewhere", set(), "everything moved to another folder")
    os.rename(folder + " elsewhere", folder)
    replace(os.path.join(folder, "farm.yaml"), "output: out\n", "output: out  # a comment\n")
    expect(folder, {"index.html"}, "a comment in the YAML file")


def check_elsewhere(folder):
    """Programs, scripts or all in other folders, as of another checkout, install path or user: the same jobs, also for what
    Snakemake remembers of command lines."""
    links = folder + " links"
    os.mkdir(links)
    os.symlink(BIN, os.path.join(links, "bin"))
    shutil.copytree(SCRIPTS, os.path.join(links, "scripts"))
    environment = {**os.environ, "PENUMBRA_BIN": os.path.join(links, "bin")}
    text = snakemake(folder, env=environment)
    assert "Nothing to be done" in text, text
    words = ["snakemake", "-s", os.path.join(links, "scripts", "farm", "Snakefile"), "--configfile", "farm.yaml", "-c2"]
    text = subprocess.run(words, cwd=folder, env=environment, capture_output=True, text=True, check=True).stderr
    assert "Nothing to be done" in text, text
    os.rename(folder, folder + " elsewhere")
    assert kept(snakemake(folder + " elsewhere", "-n")) == set()
    os.rename(folder + " elsewhere", folder)
    shutil.rmtree(links)
    print("programs and scripts in another folder: 0 jobs")


def check_buffers(folder):
    """The files of a .gltf, by whose content the number of frames is remembered."""
    os.makedirs(folder)
    write(os.path.join(folder, "a.gltf"), '{"buffers": [{"uri": "a%20b.bin"}, {"uri": "data:x"}, {}, {"uri": "gone.bin"}]}')
    write(os.path.join(folder, "a b.bin"), "one")
    write(os.path.join(folder, "bad.gltf"), "[")
    assert buffers_of(os.path.join(folder, "a.gltf")) == [os.path.join(folder, "a b.bin")]
    assert buffers_of(os.path.join(folder, "bad.gltf")) == [] and buffers_of(os.path.join(folder, "a b.bin")) == []


def check_exit_codes(folder):
    """Exit code 2 means that a file cannot be read, 3 that it is not what it should be, as in the programs."""
    write(os.path.join(folder, "bad.yaml"), "output: [")
    for script in ("farm_ninja", "slurm/farm_array"):
        for name, code in (("nobody.yaml", 2), ("bad.yaml", 3)):
            result = subprocess.run([os.path.join(SCRIPTS, script), name], cwd=folder, capture_output=True, text=True)
            assert result.returncode == code and name in result.stderr and "Traceback" not in result.stderr, (script, name, result)


def check_cluster_status(folder):
    """A controller that does not answer says nothing about the job. One that does not know the job does."""
    fake = os.path.join(folder, "fake bin")
    os.makedirs(fake)
    write(os.path.join(fake, "sacct"), "#!/bin/sh\nexit 1\n")
    cases = [("JobId=7 JobState=COMPLETED Reason=None", "success"), ("JobId=7 JobState=PENDING Reason=None", "running"),
             ("JobId=7 JobState=OUT_OF_MEMORY Reason=None", "failed"),
             ("slurm_load_jobs error: Invalid job id specified", "failed"),
             ("slurm_load_jobs error: Unable to contact slurm controller (connect failure)", "running")]
    for answer, state in cases:
        write(os.path.join(fake, "scontrol"), f"#!/bin/sh\necho '{answer}'\n")
        for name in ("scontrol", "sacct"):
            os.chmod(os.path.join(fake, name), 0o755)
        found = subprocess.run([os.path.join(SCRIPTS, "farm", "slurm", "status"), "7"], capture_output=True, text=True,
                               env={**os.environ, "PATH": fake + ":" + os.environ["PATH"]}).stdout
        assert found == state + "\n", (answer, found)


def check_array_files(folder):
    """Lines of a later submission never replace those that queued tasks will read."""
    fake = os.path.join(folder, "fake sbatch")
    os.makedirs(fake)
    write(os.path.join(fake, "sbatch"), "#!/bin/sh\necho 7\n")
    os.chmod(os.path.join(fake, "sbatch"), 0o755)
    environment = {**os.environ, "PATH": fake + ":" + os.environ["PATH"]}
    yaml, arrays = os.path.join(folder, "farm.yaml"), os.path.join(folder, "out", ".farm", "arrays")
    submit = lambda: subprocess.run([os.path.join(SCRIPTS, "farm", "slurm", "farm_array"), "farm.yaml"], cwd=folder, env=environment, check=True)
    content = lambda: {name: open(os.path.join(arrays, name)).read() for name in os.listdir(arrays)}
    submit()
    before = content()
    replace(yaml, "alpha=0.4", "alpha=0.7")
    submit()
    after = content()
    assert before.items() <= after.items() and len([name for name in after if name.startswith("brdf.")]) == 2, after.keys()
    # What waits or runs is not submitted again; with other options it is named.
    write(os.path.join(fake, "squeue"), "#!/bin/sh\nfor i in 0 1 2 3 4 5 6 7; do echo 7_$i; done\n")
    os.chmod(os.path.join(fake, "squeue"), 0o755)
    result = subprocess.run([os.path.join(SCRIPTS, "farm", "slurm", "farm_array"), "farm.yaml"], cwd=folder, env=environment, capture_output=True,
                            text=True, check=True)
    assert "jobs are under way: arrays 7" in result.stdout and "tasks" not in result.stdout and content() == after, result
    replace(yaml, "alpha=0.7", "alpha=0.8")
    result = subprocess.run([os.path.join(SCRIPTS, "farm", "slurm", "farm_array"), "farm.yaml"], cwd=folder, env=environment, capture_output=True,
                            text=True)
    assert result.returncode == 3 and "materials/gold.brdf.h5: task 7_1 still makes it with other options" in result.stderr, result
    replace(yaml, "alpha=0.8", "alpha=0.4")
    shutil.rmtree(os.path.join(folder, "out"))


def check_shard_count(folder):
    """Another number of shards runs nothing: it counts when the bake must run for another reason."""
    yaml = os.path.join(folder, "farm.yaml")
    whole = open(yaml).read()
    for shards in (1, 5):
        replace(yaml, "shards: 2", f"shards: {shards}")
        expect(folder, {"index.html"}, f"{shards} shards instead of 2")  # the page follows the file
        write(yaml, whole)
    replace(yaml, "shards: 2", "shards: 5")
    replace(yaml, "holdout: [walk],", "holdout: [walk], bake: {seed: 2},")
    text = snakemake(folder, "-n")
    assert kept(text) == OF_MAN and text.count("output: man/shards/") == 5, text
    write(yaml, whole)
    expect(folder, set(), "and 2 again")


def check_new_program(folder):
    """A program built from other sources makes its outputs anew, and what follows. One built again from the same
    sources does not."""
    programs = folder + " programs"
    os.mkdir(programs)
    for name in ("bake", "fit", "pack", "player"):
        os.symlink(os.path.join(BIN, f"penumbra-{name}"), os.path.join(programs, f"penumbra-{name}"))
    environment = {**os.environ, "PENUMBRA_BIN": programs}
    fit = os.path.join(programs, "penumbra-fit")
    os.remove(fit)
    shutil.copy(os.path.join(BIN, "penumbra-fit"), fit)
    assert kept(snakemake(folder, "-n", env=environment)) == set()
    version = subprocess.run([fit, "--version"], capture_output=True, text=True, check=True).stdout
    found = re.match(r"penumbra-fit \d+\.\d+\.\d+\+([0-9a-f]{16})\n", version)
    assert found, version
    data = open(fit, "rb").read()
    assert data.count(found[1].encode()) == 1
    other = ("0" if found[1][0] != "0" else "1") + found[1][1:]
    with open(fit, "wb") as file:
        file.write(data.replace(found[1].encode(), other.encode()))
    text = snakemake(folder, "-n", env=environment)
    wanted = {output for output in OF_GOLD | OF_MAN if not output.endswith((".vis.h5", ".truth.pnb"))}
    wanted |= {"bend/bend.model.h5", "materials/clay.brdf.h5", "lights/grey.light.h5", "lights/sky.light.h5"}
    assert kept(text) == wanted, (wanted - kept(text), kept(text) - wanted)
    assert f"made by penumbra-fit {version.split()[1]}" in text and other in text, text
    shutil.rmtree(programs)
    print(f"another penumbra-fit: {len(wanted)} jobs, no bake")


def check_predict(folder):
    """`predict: true` adds the predictions, and the check that reads them."""
    yaml = os.path.join(folder, "farm.yaml")
    replace(yaml, "holdout: [walk],", "holdout: [walk], predict: true,")
    ran = kept(snakemake(folder))
    assert ran == {"man/man.pred.vis.h5", "man/check.json", "index.html"}, ran
    replace(yaml, " predict: true,", "")
    snakemake(folder)


def check_vanished_reports(folder):
    """A run deletes reports and stamps of shards that no plan knows any more."""
    out = os.path.join(folder, "out")
    old = ["reports/man.shards.000000-000099.vis.h5.json", "man/shards/000000-000099.vis.h5.stamp"]
    for name in old:
        write(os.path.join(out, name), "{}")
    os.remove(os.path.join(out, "index.html"))
    snakemake(folder)
    assert not any(os.path.exists(os.path.join(out, name)) for name in old)
    assert os.path.exists(os.path.join(out, "reports", "man.shards.000000-000015.vis.h5.json"))


def check_changes(folder):
    """Changes a material, a fit option and a rig file."""
    yaml, man = os.path.join(folder, "farm.yaml"), os.path.join(folder, "capsule_man.glb")
    replace(yaml, "alpha=0.4", "alpha=0.5")
    expect(folder, OF_GOLD, "a BRDF changed")
    ran = kept(snakemake(folder))
    assert ran == OF_GOLD, ran
    expect(folder, set(), "after that run")
    replace(yaml, "holdout: [walk],", "holdout: [walk], fit: {clusters: 3},")
    expect(folder, OF_MAN - {"man/man.vis.h5", "man/man.truth.pnb"}, "a fit option changed")
    replace(yaml, " fit: {clusters: 3},", "")
    expect(folder, set(), "and changed back")
    whole = open(man, "rb").read()
    with open(man, "ab") as file:
        file.write(b" " * 4)
    text = snakemake(folder, "-n")
    assert kept(text) == OF_MAN, kept(text)
    assert "farm: man/man.pnb: follows man/shards/000000-000015.vis.h5: made from another capsule_man.glb" in text, text
    open(man, "wb").write(whole)
    expect(folder, set(), "a rig changed and changed back")


def check_foreign(folder):
    """A file that is not what was made here stops the run and is named. When it is deleted, the run makes the same
    bytes again."""
    vis = os.path.join(folder, "out", "man", "man.vis.h5")
    whole = open(vis, "rb").read()
    subprocess.run([os.path.join(BIN, "penumbra-bake"), "visibility", os.path.join(folder, "capsule_man.glb"), "-o", vis, "-q",
                    "--fps", "3", "--rays", "16", "--seed", "2"], check=True)
    text = snakemake(folder, code=1)
    assert "man/man.vis.h5: is not the file that was made here" in text, text
    assert open(vis, "rb").read() != whole
    os.remove(vis)
    ran = kept(snakemake(folder, "bakes"))
    assert ran == {"man/man.vis.h5"}, ran
    assert open(vis, "rb").read() == whole
    os.remove(os.path.join(folder, "out", "man", "man.model.h5.stamp"))
    text = snakemake(folder, "-n")
    assert "man/man.model.h5: has no stamp" in text and "man/man.model.h5" in kept(text), text
    snakemake(folder)
    print("a foreign file is named, an unknown one made again")


def check_options():
    """Every key that goes to a program is an option that the program has."""
    for program, verb, keys in (("bake", "visibility", config.BAKE), ("bake", "fields", config.FIELDS),
                                ("fit", "visibility", config.FIT), ("pack", "asset", config.PACK), ("fit", "brdf", config.MATERIAL),
                                ("fit", "light", config.LIGHT)):
        help_text = subprocess.run([os.path.join(BIN, f"penumbra-{program}"), verb, "--help"], capture_output=True, text=True).stdout
        for key in keys:
            assert f"  --{key.replace('_', '-')} " in help_text, (program, verb, key)


def check_config_errors(folder):
    yaml = os.path.join(folder, "farm.yaml")
    whole = open(yaml).read()
    cases = [
        ("holdout: [walk]", "holdout: [walk], fbs: 3", "rigs.man.fbs: no such key; did you mean fps?"),
        ("bake: {rays: 16}", "bake: {rays: many}", "defaults.bake.rays: takes a whole number from 16, not 'many'"),
        ("bake: {rays: 16}", "bake: {rays: 4}", "defaults.bake.rays: takes a whole number from 16, not 4"),
        ("fps: 3", "fps: true", "defaults.fps: takes a number from 0.001, not True"),
        ("[capsule_man.glb]", "[nobody.glb]", "rigs.man.files[0]: no such file"),
        ("[capsule_man.glb]", "capsule_man.glb", "rigs.man.files: takes a list"),
        ("holdout: [walk], ", "", "rigs.man.holdout: missing"),
        ("materials: [clay]", "materials: [tin]", "rigs.man.materials: tin is not among materials: clay, gold"),
        ("{analytic: lambert}", "{analytic: lambert, table: farm.yaml}", "materials.clay: takes exactly one of analytic, merl, table"),
        ("{analytic: sky}", "{}", "lights.sky: takes exactly one of picture, analytic"),
        ("output: out\n", "", "output: missing"),
        ("model: linear", "model: cubic", "defaults.fit.model: takes one of linear, quadratic, neural, additive, composed, not 'cubic'"),
        ("  man:", "  the man:", "rigs: 'the man' cannot be a name"),
        ("  man:", "  materials:", "rigs.materials: a rig becomes a folder of the output"),
        ("holdout: [walk]", "holdout: [wolk]", "rigs.man.holdout: no clip 'wolk'; the bake has "),
        ("holdout: [walk]", "holdout: [walk], clips: [walk, wolk]", "rigs.man: penumbra-bake: --clips: no clip 'wolk'; the rig has "),
        ("holdout: [walk]", "holdout: [walk], clips: [walk]", "rigs.man.holdout: no clip is left to train on"),
        ("holdout: [sway]", "holdout: [bend, twist, sway]", "rigs.bend.holdout: no clip is left to train on"),
        ("size: 32", "size: 32, camera: 'yow=3'", "pictures.camera: camera has no 'yow'"),
        ("clusters: 2", "clusters: 2, convention: E4", "defaults.fit.convention: convention must be A, B or D"),
        ("rays: 16}, fit: {", "rays: 16, order: 3}, fit: {convention: A4, ",
         "rigs.bend.fit.convention: A4 needs moments of order 4; the bake has order 3"),
        ("rays: 16}", "rays: 16, order: 3}", "rigs.bend.fit.convention: D5 needs moments of order 5; the bake has order 3"),
        ("clusters: 2", "clusters: 2, convention: D6", "rigs.bend.fit.convention: D6 needs moments of order 6; the bake has order 5"),
        ("ggx:alpha=0.4", "ggx:alfa=0.4", "materials.gold: penumbra-fit: --analytic: BRDF ggx has no 'alfa'"),
        ("analytic: sky", "analytic: skye", "lights.sky: penumbra-fit: "),
    ]
    for old, new, says in cases:
        replace(yaml, old, new)
        try:
            make_plan(read_config(yaml))
            assert False, ("taken", new)
        except ConfigError as error:
            assert says in str(error), (says, str(error))
        if old is cases[0][0]:
            text = snakemake(folder, "-n", code=1)
            assert says in text and "Traceback" not in text, (says, text)
        write(yaml, whole)
    print(f"{len(cases)} mistakes in the YAML file are named")


def check_same_words(folder):
    """What the farm itself says of cameras and conventions is what the programs say."""
    run = lambda program, *words: subprocess.run([os.path.join(BIN, f"penumbra-{program}"), *words], cwd=folder, capture_output=True,
                                                 text=True)
    for text in ("yow=3", "yaw", "yaw=", "=3", "yaw=1,,", "yaw=1,yaw=2", "yaw=400", "yaw=+4", "yaw= 4", "yaw=nan", "pitch=89.5", "fov=0",
                 "distance=0", "distance=1e10", "target=1/2", "target=1/2/x", "target=x", "yaw=1_0", "yaw=\u0663", "yaw=-3.5e1", "yaw=.5,fov=1.",
                 "target=0", "target=0/1e-3/-2,distance=3,pitch=-89"):
        result = run("bake", "reference", "out/man/man.vis.h5", "--frame", "0", "--size", "8x8", "--samples", "4", "-o", "x.png",
                     "--camera", text)
        wanted = camera_problem(text)
        assert result.stderr == (f"penumbra-bake: --camera: {wanted}\n" if wanted else ""), (text, wanted, result.stderr)
    for text in ("E4", "A0", "A9", "a4", "D55", "D"):
        try:
            config.convention("--convention", text, "")
            assert False, ("taken", text)
        except ConfigError as error:
            said = run("fit", "visibility", "out/man/man.vis.h5", "--convention", text, "-o", "x.model.h5").stderr
            assert said == f"penumbra-fit: {error} (see penumbra-fit visibility --help)\n", (said, str(error))


def main():
    skip_without("snakemake")
    with tempfile.TemporaryDirectory() as name:
        folder = os.path.join(name, "a farm")
        make_farm(folder, BIN, shards=2)
        check_options()
        check_buffers(os.path.join(name, "gltf"))
        check_exit_codes(folder)
        check_cluster_status(folder)
        check_array_files(folder)
        check_config_errors(folder)
        check_first_run(folder)
        check_same_words(folder)
        check_elsewhere(folder)
        check_touch(folder)
        snakemake(folder)
        check_changes(folder)
        check_shard_count(folder)
        check_new_program(folder)
        check_predict(folder)
        check_vanished_reports(folder)
        check_foreign(folder)


main()
