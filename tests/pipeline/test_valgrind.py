"""Load, 1,000 frames, unload under valgrind: no invalid or uninitialised read, nothing leaked, and nothing allocated
per frame (as many allocations as for 2 frames). Both code paths.

usage: test_valgrind.py BIN
"""
import os
import re
import shutil
import subprocess
import sys
import tempfile

BIN = os.path.abspath(sys.argv[1])


def run(*words, **more):
    result = subprocess.run([str(w) for w in words], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, **more)
    assert result.returncode == 0, (words, result.returncode, result.stdout[-2000:], result.stderr[-4000:])
    return result


def make_asset():
    run(BIN + "/penumbra-bake", "visibility", BIN + "/../samples/two_skins.glb", "-o", "x.vis.h5", "--fps", 4, "--rays", 64)
    run(BIN + "/penumbra-fit", "visibility", "x.vis.h5", "-o", "x.model.h5", "--clusters", 3)
    # There is a material of every slice form. The table has no symmetry, as phi_i alone changes it.
    with open("skew.table", "w") as f:
        f.write("penumbra-brdf-table 1\nsymmetry general\ntheta_i 2\nphi_i 8\ntheta_o 2\nphi_o 8\n")
        f.writelines(f"{0.01 + 0.04 * (i // 16 % 8)} 0.2 0.1\n" for i in range(256))
    brdfs = []
    for name, words in (("skew", ["--table", "skew.table"]), ("lambert", ["--analytic", "lambert"]),
                        ("ward", ["--analytic", "ward-gmd:color=0.5/0.3/0.2"])):
        run(BIN + "/penumbra-fit", "brdf", *words, "-o", name + ".brdf.h5")
        brdfs += ["--brdf", name + ".brdf.h5"]
    run(BIN + "/penumbra-fit", "light", "--analytic", "disc:direction=1/1/0,angle=20,radiance=9/5/1+uniform:radiance=0.1/0.3/0.8",
        "-o", "rgb.light.h5")
    run(BIN + "/penumbra-pack", "asset", "x.model.h5", *brdfs, "--light", "rgb.light.h5", "-o", "x.pnb")
    info = run(BIN + "/penumbra-bake", "info", "x.pnb").stdout
    assert all("slice_form " + form in info for form in ("general", "orthotropic", "isotropic")), info
    assert re.search(r"slots +tube/default, sleeve/default, twin/default\n", info), info


def allocations(frames, path):
    result = run("valgrind", "--error-exitcode=9", "--leak-check=full", "--errors-for-leak-kinds=all", BIN + "/thousand_frames",
                 "x.pnb", frames, path)
    if "has no" in result.stdout:
        return None
    assert re.match(rf"\S+ after {frames} frames", result.stdout), result.stdout
    assert "ERROR SUMMARY: 0 errors" in result.stderr and "All heap blocks were freed" in result.stderr, result.stderr
    return int(re.search(r"total heap usage: ([\d,]+) allocs", result.stderr).group(1).replace(",", ""))


if not shutil.which("valgrind"):
    print("test_valgrind: SKIPPED, valgrind is not installed (scripts/setup brings it)")
    sys.exit(77)
with tempfile.TemporaryDirectory() as folder:
    os.chdir(folder)
    make_asset()
    frames = 1000  # for the best path; the other one takes several times as long
    for path in ("avx2", "portable"):
        few = allocations(2, path)
        if few is None:
            continue
        many = allocations(frames, path)
        assert few == many, (path, few, many)
        print(f"{path}: {frames} frames with {many} allocations, as 2 frames; nothing leaked, no error")
        frames = 100
    assert frames == 100
    print("test_valgrind: all checks passed")
    os.chdir("/")
