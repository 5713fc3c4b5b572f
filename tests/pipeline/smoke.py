"""Every verb of the four programs on the smallest inputs, and damaged files of every kind of input: the exit codes are
as documented, and no sanitizer complains. scripts/test runs it with the programs of the sanitizer build.

usage: smoke.py BIN
"""
import concurrent.futures
import os
import random
import subprocess
import sys
import tempfile
import threading

import numpy as np

BIN = os.path.abspath(sys.argv[1])
SAMPLES = os.path.join(BIN, "..", "samples")
OK, FAILED = [0], [2, 3, 4, 5]  # exit codes; 1 is a mistake on the command line, and hardly any is here
SMALL = ["--fps", "2", "--rays", "16", "--order", "3"]
TINY = ["--size", "24x24"]
TEXTURED = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "fuzz", "corpus", "fuzz_base_colors", "textured.glb")
BOUNCE = ["--quantity", "transfer", "--bounces", "1"]
count = 0
counting = threading.Lock()  # guards `count`


def environment():
    """Leaks are not looked for: assimp and Mesa leak in every run, and the unit tests find ours."""
    both = lambda name, more: ":".join(filter(None, [os.environ.get(name), more]))
    return {**os.environ, "ASAN_OPTIONS": both("ASAN_OPTIONS", "detect_leaks=0"),
            "UBSAN_OPTIONS": both("UBSAN_OPTIONS", "print_stacktrace=1")}


def run(codes, tool, *words):
    """Runs a program, which must end with one of the codes and without a word of a sanitizer."""
    global count
    with counting:
        count += 1
    words = [str(word) for word in words]
    result = subprocess.run([os.path.join(BIN, "penumbra-" + tool), *words], capture_output=True, timeout=120, env=environment())
    said = result.stderr.decode(errors="replace")
    what = f"penumbra-{tool} {' '.join(words)}: exit code {result.returncode}\n{said}"
    assert "Sanitizer" not in said and "runtime error:" not in said, what
    assert result.returncode in codes, what


def write_inputs():
    """A light, a table of a material, a mesh with a point cache beside it, a table of inputs."""
    with open("sky.hdr", "wb") as file:
        file.write(b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 8 +X 16\n" + bytes([90, 99, 120, 128]) * 128)
    with open("skew.table", "w") as file:
        file.write("penumbra-brdf-table 1\nsymmetry isotropic\ntheta_i 2\ntheta_o 2\nphi 2\n" + 8 * "0.1 0.2 0.3\n")
    positions = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0.2]], ">f4")
    with open("quad.obj", "w") as file:
        file.writelines("v %g %g %g\n" % tuple(p) for p in positions)
        file.write("f 1 2 3 4\n")
    with open("quad.mdd", "wb") as file:
        np.array([3, 4], ">i4").tofile(file)
        np.array([0, 0.5, 1], ">f4").tofile(file)
        np.stack([positions, positions * 1.1, positions * 1.2]).astype(">f4").tofile(file)
    with open("inputs.csv", "w") as file:
        file.write("time,wind\n0,1\n10,3\n")
    with open("merl.binary", "wb") as file:
        np.array([90, 90, 180], "<i4").tofile(file)
        np.full(3 * 90 * 90 * 180, 100.0).tofile(file)


def bakes():
    """Skinned rigs of all formats, point caches, shards, poses and a picture."""
    bend, sheet = (os.path.join(SAMPLES, name) for name in ("bend.glb", "sheet.npz"))
    run(OK, "bake", "visibility", bend, "-o", "a.vis.h5", *SMALL, "--report", "r.json", "--depfile", "a.d", "-v")
    run(OK, "bake", "visibility", bend, "-o", "a.vis.h5", *SMALL, "--resume")
    run(OK, "bake", "visibility", bend, "-o", "t.vis.h5", *SMALL, "--quantity", "transfer")
    run(OK, "bake", "visibility", bend, "-o", "dry.vis.h5", *SMALL, "--dry-run")
    run(OK, "bake", "visibility", bend, "-o", "t.vis.h5", *SMALL, "--quantity", "transfer", "--bounces", 2, "--albedo", "0.5/0.4/0.3")
    run(OK, "bake", "visibility", bend, "-o", "l.vis.h5", *SMALL, "--local", "--local-steps", 1, "--local-order", 6)
    for i, part in enumerate(("0:7", "7:15")):
        run(OK, "bake", "visibility", bend, "-o", f"s{i}.vis.h5", *SMALL, "--frames", part, "--precision", "f16", "--threads", 2)
    run(OK, "bake", "merge", "s0.vis.h5", "s1.vis.h5", "-o", "m.vis.h5", "--frames", "0:15")
    run(OK, "bake", "merge", "s0.vis.h5", "s1.vis.h5", "-o", "v.vis.h5", "--frames", "0:15", "--virtual")
    run(OK, "bake", "poses", bend, "-o", "a.poses.h5", "--fps", 2, "--choose", 3, "--sample", 2)
    run(OK, "bake", "poses", bend, "-o", "poses.glb", "--fps", 2, "--choose", 3)
    fields = ["bake", "fields", bend, "--rays", 16, "--cells", 4]
    run(OK, *fields, "-o", "a.fields.h5", "--report", "r.json", "--depfile", "f.d", "--fade", "0.01", "--seed", 2)
    run(OK, *fields, "-o", "dry.fields.h5", "--dry-run")
    for i, part in enumerate(("0:1", "1:2")):
        run(OK, *fields, "-o", f"s{i}.fields.h5", "--parts", part)
    run(OK, "bake", "merge", "s1.fields.h5", "s0.fields.h5", "-o", "m.fields.h5")
    run(OK, "bake", "fields", "quad.obj", "-o", "quad.fields.h5", "--rays", 16, "--cells", 4, "--units", "cm", "--up", "z")
    run(OK, "bake", "visibility", bend, "-o", "p.vis.h5", "--rays", 16, "--order", 1, "--poses", "a.poses.h5")
    man = os.path.join(SAMPLES, "capsule_man.glb")
    run(OK, "bake", "poses", man, "-o", "mixed.poses.h5", "--fps", 1, "--choose", 3, "--mix", 2, "--cover", 1)
    run(OK, "bake", "visibility", man, "-o", "p.vis.h5", "--rays", 16, "--order", 1, "--poses", "mixed.poses.h5")
    run(OK, "bake", "visibility", sheet, "-o", "c.vis.h5", "--rays", 16, "--order", 3, "--two-sided", "--blocks", 2, "--inputs",
        "inputs.csv", "--occluder", "quad.obj", "--ground=-1")
    run(OK, "bake", "visibility", "quad.obj", "quad.mdd", "-o", "q.vis.h5", "--rays", 16, "--order", 1)
    for name in ("swing.fbx", "swing.dae", "swing.x", "props.glb", "quantized.glb", "sparse.glb"):
        run(OK, "bake", "visibility", os.path.join(SAMPLES, name), "-o", "f.vis.h5", *SMALL)
    run(OK, "bake", "visibility", TEXTURED, "-o", "x.vis.h5", *SMALL, *BOUNCE)
    for light in ("sky.hdr", "uniform"):
        run(OK, "bake", "reference", "a.vis.h5", "--frame", 1, *TINY, "--samples", 4, "--light", light, "-o", "a.png")
    run(OK, "bake", "reference", "a.vis.h5", "--frame", 1, *TINY, "--samples", 4, "--channel", "ao", "-o", "a.exr")


def fits():
    """All models, both kinds of features, materials, lights, and a small comparison."""
    fit = ["fit", "visibility", "a.vis.h5", "--clusters", 2, "--convention", "D3", "--holdout", "sway"]
    for model in ("linear", "quadratic", "neural", "additive"):
        run(OK, *fit, "--model", model, "-o", model + ".model.h5")
        run(OK, "fit", "predict", model + ".model.h5", "a.vis.h5", "-o", model + ".pred.vis.h5")
    run(OK, *fit, "--features", "joint-angles", "-o", "angles.model.h5")
    run(OK, "fit", "indirect", "additive.model.h5", "t.vis.h5", "-o", "bounced.model.h5", "--output-variance", "0.95")
    run(OK, "fit", "visibility", "c.vis.h5", "-o", "c.model.h5", "--convention", "A3", "--parts", 2, "--clusters", 2)
    run(OK, "fit", "blockers", "additive.model.h5", "-o", "a.blockers.h5", "--spheres", 5, "--seed", 2, "--report", "r.json")
    run(OK, "fit", "blockers", "c.model.h5", "-o", "c.blockers.h5", "--method", "paper", "--threads", 2)
    run(OK, "fit", "visibility", "a.vis.h5", "--model", "zh-lobes", "--lobes", 2, "--convention", "B3", "--clusters", 2, "-o", "a.lobes.h5")
    run(OK, "fit", "predict", "a.lobes.h5", "a.vis.h5", "-o", "lobes.pred.vis.h5")
    run([5], "pack", "asset", "a.lobes.h5", "-o", "no.pnb")
    run(OK, "fit", "brdf", "--analytic", "ggx:alpha=0.3,f0=0.9", "--operators", 4, "-o", "ggx.brdf.h5")
    run(OK, "fit", "brdf", "--table", "skew.table", "-o", "table.brdf.h5")
    run(OK, "fit", "brdf", "--analytic", "phong-live:exponent=20", "-o", "live.brdf.h5")
    run(OK, "fit", "brdf", "--analytic", "membrane:rho=0.5/0.3/0.1,tau=0.2", "-o", "membrane.brdf.h5")
    run(OK, "fit", "brdf", "--analytic", "membrane:rho=0.5/0.3/0.1,tau=0.2,back=open", "-o", "open.brdf.h5")
    run([1], "fit", "brdf", "--analytic", "membrane", "--operators", 2, "-o", "no.brdf.h5")
    run(OK, "fit", "brdf", "--analytic", "ggx:alpha=0.2..0.5", "--steps", 4, "-o", "steps.brdf.h5")
    for bad in ("ggx:alpha=0.5..0.2", "ggx:alpha=nan..0.2", "ggx:alpha=0.1..2", "phong-live:exponent=-1",
                "phong-live:exponent=nan", "phong-live:exponent=1e5", "membrane:rho=0.8,tau=0.3"):
        run([1], "fit", "brdf", "--analytic", bad, "-o", "no.brdf.h5")
    run(OK, "fit", "light", "sky.hdr", "-o", "sky.light.h5")
    run(OK, "fit", "light", "--analytic", "sun+overcast", "--lobe-fit", "joint", "-o", "sun.light.h5", "--window", "always")
    run(OK, "fit", "transfer", "t.vis.h5", "--order", 3, "--components", "2,4", "-o", "pca.transfer.h5", "--holdout", "sway")
    run(OK, "fit", "transfer", "a.vis.h5", "--order", 2, "--model", "linear", "-o", "l.transfer.h5", "--prior", 1)
    run(OK, "fit", "compare", "a.vis.h5", "--transfer", "--order", 2, "--holdout", "sway", "--components", "2,4", "-o",
        "transfer.html", "--bounces", "t.vis.h5")
    run(OK, "fit", "compare", "a.vis.h5", "--holdout", "sway", "--clusters", "1,2", "--output-variances", "0.9", "--models",
        "linear,additive", "--conventions", "A2", "--light", "sky.light.h5", "--light", "sun.light.h5", "-o", "compare.html")
    run(OK, "fit", "compare", "a.vis.h5", "--holdout", "sway", "--models", "zh-lobes", "--lobes", "1", "--clusters", "2",
        "--output-variances", "0.9", "--conventions", "A2", "-o", "lobes.html")


def packs():
    """Assets of every model and precision, truth, and the check against it."""
    looks = ["--brdf", "ggx.brdf.h5", "--brdf", "table.brdf.h5", "--light", "sky.light.h5", "--light", "sun.light.h5"]
    for model in ("linear", "quadratic", "neural", "additive", "c"):
        run(OK, "pack", "asset", model + ".model.h5", *looks, "-o", model + ".pnb")
    run(OK, "pack", "asset", "additive.model.h5", "--brdf", "live.brdf.h5", "--light", "sky.light.h5", "-o", "live.pnb")
    run(OK, "player", "render", "live.pnb", *TINY, "-o", "live.png")
    run(OK, "pack", "asset", "additive.model.h5", "--brdf", "steps.brdf.h5", "--light", "sky.light.h5", "-o", "steps.pnb")
    run(OK, "player", "render", "steps.pnb", *TINY, "-o", "steps.png")
    run(OK, "player", "bench", "live.pnb", "--runs", 2, *TINY)
    run([5], "pack", "asset", "additive.model.h5", "--brdf", "membrane.brdf.h5", "-o", "no.pnb")
    for precision in ("f32", "f16"):
        run(OK, "pack", "asset", "additive.model.h5", *looks, "-o", precision + ".pnb", "--precision", precision)
    for name, blockers in (("additive", "a"), ("c", "c")):
        run(OK, "pack", "asset", name + ".model.h5", "--blockers", blockers + ".blockers.h5", "-o", "blockers.pnb")
        run(OK, "bake", "info", "blockers.pnb")
    run(OK, "pack", "asset", "bounced.model.h5", *looks, "-o", "bounced.pnb", "--bounce-bytes", 900)
    run(OK, "pack", "check", "bounced.pnb", "a.vis.h5", "--bounces", "t.vis.h5")
    run(OK, "pack", "truth", "a.vis.h5", "-o", "a.truth.pnb")
    run(OK, "pack", "truth", "t.vis.h5", "-o", "t.truth.pnb")
    for name, words in (("pca", ["--precision", "i8"]), ("l", ["--albedo", "0.5/0.4/0.3"])):
        run(OK, "pack", "asset", name + ".transfer.h5", *words, "--light", "sky.light.h5", "-o", name + ".transfer.pnb")
        run(OK, "bake", "info", name + ".transfer.pnb")
    run(OK, "pack", "check", "pca.transfer.pnb", "t.vis.h5")
    run(OK, "pack", "check", "l.transfer.pnb", "a.vis.h5")
    for model in ("linear", "quadratic", "neural", "additive"):
        run(OK, "pack", "check", model + ".pnb", "a.vis.h5", "--predictions", model + ".pred.vis.h5", "--model", model + ".model.h5")
    for name in ("a.vis.h5", "c.vis.h5", "v.vis.h5", "a.poses.h5", "a.fields.h5", "s0.fields.h5", "additive.model.h5", "a.lobes.h5", "ggx.brdf.h5", "sky.light.h5", "c.pnb",
                 "a.blockers.h5", "a.truth.pnb"):
        run(OK, "bake", "info", name)
    run(OK, "bake", "info", "a.vis.h5", "--all")


def pictures():
    """Both paths, all channels, a sequence with figures, the bench, and the view as far as it needs no window."""
    truth = ["--truth", "a.truth.pnb"]
    for path in ("cpu", "glsl"):
        run(OK, "player", "render", "additive.pnb", *TINY, "--path", path, "-o", "a.png")
        run(OK, "player", "render", "f16.pnb", *TINY, "--path", path, "--light-form", "lobes", "--reflectance", "operators", "-o", "a.exr")
    for channel in ("shaded", "ao", "normals", "error", "transfer-error"):
        words = ["--truth", "t.truth.pnb"] if "error" in channel else []
        run(OK, "player", "render", "pca.transfer.pnb", *TINY, *words, "--channel", channel, "-o", "a.png")
    run(OK, "player", "bench", "pca.transfer.pnb", *TINY, "--runs", 2)
    run(OK, "player", "view", "pca.transfer.pnb", "--dry-run")
    for channel in ("ao", "normals", "clusters", "error"):
        run(OK, "player", "render", "linear.pnb", *TINY, *(truth if channel == "error" else []), "--channel", channel, "-o", "a.png")
    run(OK, "player", "render", "neural.pnb", *TINY, *truth, "--frames", "0:3", "-o", "f.%d.png")
    run(OK, "player", "measure", "neural.pnb", *TINY, *truth, "--frames", "0:3", "--sheet", "s.png", "--csv", "s.csv", "--flip")
    run(OK, "player", "render", "c.pnb", *TINY, "-o", "a.png")
    for path in ("cpu", "glsl"):
        run(OK, "player", "render", "bounced.pnb", *TINY, "--path", path, "--bounces", "indirect", "-o", "a.png")
        run(OK, "player", "render", "bounced.pnb", *TINY, "--path", path, "--channel", "ao-bounced", "-o", "a.png")
    for name, text in (("s.json", '{"version": 1, "characters": [{"asset": "additive.pnb"}], "ground": {"resolution": 8}}'),
                       ("p.csv", "x,y,z,nx,ny,nz\n0,0,0,0,1,0\n")):
        with open(name, "w") as f:
            f.write(text)
    run(OK, "player", "render", "--scene", "s.json", *TINY, "-o", "a.png")
    run(OK, "player", "probe", "s.json", "--points", "p.csv", "-o", "p.out.csv")
    run(OK, "player", "bench", "additive.pnb", "--runs", 2, *TINY, "--characters", 2)
    run(OK, "player", "bench", "--scene", "s.json", "--runs", 2, *TINY)
    with open("h.json", "w") as f:
        f.write('{"version": 1, "characters": [{"asset": "additive.pnb", "on_ground": true}], '
                '"ground": {"heights": {"analytic": "waves", "rows": 9, "columns": 12}}}')
    run(OK, "player", "render", "--scene", "h.json", "--time", 0.2, *TINY, "-o", "a.png")
    run(OK, "player", "render", "--scene", "h.json", "--path", "glsl", *TINY, "-o", "a.png")
    run(OK, "player", "probe", "h.json", "--points", "p.csv", "-o", "p.out.csv")
    run(OK, "player", "bench", "--scene", "h.json", "--runs", 2, *TINY)
    run(OK, "bake", "reference", "--scene", "h.json", "--samples", 4, *TINY, "-o", "a.png")
    run(OK, "player", "view", "additive.pnb", "sky.hdr", "--dry-run")


def spoiled(content, chance):
    """Nothing, noise, the first half, and one with changed bytes; the last may still be a file that can be read."""
    yield b"", FAILED
    yield chance.randbytes(2000), FAILED
    yield content[:len(content) // 2], FAILED
    changed = bytearray(content)
    for _ in range(8):
        changed[chance.randrange(len(changed))] ^= 1 << chance.randrange(8)
    yield bytes(changed), OK + FAILED


def damaged_files():
    """A damaged file in the place of every kind of input."""
    out = ["-o", "no.out"]
    sample = lambda name: os.path.join(SAMPLES, name)
    bake = lambda *words: ("bake", "visibility", *words, "-o", "no.vis.h5", "--rays", 16, "--order", 1, "--frames", "0:1")
    kinds = [(sample(name), lambda bad: bake(bad)) for name in ("bend.glb", "swing.fbx", "swing.dae", "swing.x", "sheet.npz")]
    kinds += [("quad.obj", lambda bad: bake(bad, "quad.mdd")), ("quad.mdd", lambda bad: bake("quad.obj", bad)),
              ("inputs.csv", lambda bad: bake(sample("sheet.npz"), "--inputs", bad)),
              ("a.poses.h5", lambda bad: bake(sample("bend.glb"), "--poses", bad)),
              ("a.fields.h5", lambda bad: ("bake", "info", bad)), ("s0.fields.h5", lambda bad: ("bake", "merge", bad, *out)),
              ("mixed.poses.h5", lambda bad: bake(sample("capsule_man.glb"), "--poses", bad)),
              ("a.vis.h5", lambda bad: ("bake", "info", bad)), ("a.vis.h5", lambda bad: ("bake", "merge", bad, *out)),
              ("a.vis.h5", lambda bad: ("fit", "visibility", bad, *out, "--convention", "A3", "--model", "linear")),
              ("a.vis.h5", lambda bad: ("pack", "truth", bad, *out)),
              ("linear.model.h5", lambda bad: ("pack", "asset", bad, *out)),
              ("linear.model.h5", lambda bad: ("fit", "predict", bad, "a.vis.h5", *out)),
              ("a.lobes.h5", lambda bad: ("fit", "predict", bad, "a.vis.h5", *out)),
              ("ggx.brdf.h5", lambda bad: ("pack", "asset", "linear.model.h5", "--brdf", bad, *out)),
              ("sky.light.h5", lambda bad: ("pack", "asset", "linear.model.h5", "--light", bad, *out)),
              ("a.blockers.h5", lambda bad: ("pack", "asset", "additive.model.h5", "--blockers", bad, *out)),
              ("sky.hdr", lambda bad: ("fit", "light", bad, *out)), ("a.exr", lambda bad: ("fit", "light", bad, *out)),
              ("skew.table", lambda bad: ("fit", "brdf", "--table", bad, *out)),
              ("merl.binary", lambda bad: ("fit", "brdf", "--merl", bad, *out, "--dry-run")),
              ("linear.pnb", lambda bad: ("player", "render", bad, *TINY, "--channel", "ao", "-o", "no.png")),
              ("linear.pnb", lambda bad: ("pack", "check", bad, "a.vis.h5")),
              ("a.truth.pnb", lambda bad: ("player", "render", "linear.pnb", *TINY, "--channel", "error", "--truth", bad, "-o", "no.png")),
              (TEXTURED, lambda bad: bake(bad, *BOUNCE))]
    chance = random.Random(14)
    runs = []
    for path, command in kinds:
        with open(path, "rb") as file:
            content = file.read()
        for bad, codes in spoiled(content, chance):
            # Runs go on at the same time, so each reads and writes files of its own.
            name = f"bad{len(runs)}" + os.path.basename(path)[os.path.basename(path).index("."):]
            with open(name, "wb") as file:
                file.write(bad)
            words = [str(word) for word in command(name)]
            runs.append((codes, *(f"no{len(runs)}{word[2:]}" if word.startswith("no.") else word for word in words)))
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        for done in [pool.submit(run, *one) for one in runs]:
            done.result()


def main():
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        for step in (write_inputs, bakes, fits, packs, pictures, damaged_files):
            before = count
            step()
            print(f"{step.__name__}: {count - before} runs", flush=True)
        os.chdir("/")
    print(f"smoke: {count} runs of the four programs, every exit code as documented")


main()
