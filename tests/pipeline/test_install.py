"""The install tree as an engine uses it: header, library, package files; the example built against it in C, by
find_package (shared and static) and by pkg-config, and run. Then the programs of the install tree, which is moved.

usage: test_install.py BIN
"""
import gzip
import os
import re
import shutil
import subprocess
import sys
import tempfile
import zipfile

BIN = os.path.abspath(sys.argv[1])
BUILD = os.path.dirname(BIN)
SOURCE = os.path.abspath(os.path.join(os.path.dirname(__file__), "..", ".."))
EXAMPLE = os.path.join(SOURCE, "docs", "examples", "shade_character.c")
CLOTH = os.path.join(SOURCE, "docs", "examples", "shade_cloth.c")
GUIDE = os.path.join(SOURCE, "docs", "c-api.md")
PYTHON = os.path.join(SOURCE, "docs", "examples", "ambient.py")
CAST = os.path.join(SOURCE, "docs", "examples", "cast_characters.c")


def run(*words, **more):
    result = subprocess.run([str(w) for w in words], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, **more)
    assert result.returncode == 0, (words, result.returncode, result.stdout[-2000:], result.stderr[-2000:])
    return result.stdout


def make_asset():
    run(BIN + "/penumbra-bake", "visibility", BIN + "/../samples/capsule_man.glb", "-o", "x.vis.h5", "--fps", 4, "--rays", 64, "--local")
    run(BIN + "/penumbra-fit", "visibility", "x.vis.h5", "-o", "x.model.h5", "--clusters", 13)
    run(BIN + "/penumbra-fit", "brdf", "--analytic", "ggx:alpha=0.3,f0=0.9", "-o", "ggx.brdf.h5")
    run(BIN + "/penumbra-fit", "light", "--analytic", "sky:elevation=40,azimuth=30", "-o", "sky.light.h5")
    run(BIN + "/penumbra-pack", "asset", "x.model.h5", "--brdf", "ggx.brdf.h5", "--light", "sky.light.h5", "-o", "x.pnb")
    run(BIN + "/penumbra-bake", "fields", BIN + "/../samples/capsule_man.glb", "-o", "f.h5", "--megabytes", 0.5)
    run(BIN + "/penumbra-fit", "visibility", "x.vis.h5", "--fields", "f.h5", "-o", "c.model.h5", "--clusters", 13)
    run(BIN + "/penumbra-pack", "asset", "c.model.h5", "-o", "c.pnb")


def check_installs_and_moves():
    """Checks what is installed, and that the tree can be moved as a whole."""
    for component in ("library", "development"):
        run("cmake", "--install", BUILD, "--prefix", os.path.abspath("first"), "--component", component)
    shutil.move("first", "tree")
    for part in ("include/penumbra.h", "lib/libpenumbra.so", "lib/libpenumbra.so.0", "lib/libpenumbra.a",
                 "lib/pkgconfig/penumbra.pc", "lib/cmake/penumbra/penumbra-config.cmake", "share/penumbra/asset.fbs", "share/penumbra/penumbra.glsl"):
        assert os.path.exists("tree/" + part), part
    header = open("tree/include/penumbra.h").read()
    declared = set(re.findall(r"PENUMBRA_API [^;(]*?(penumbra_\w+)\(", header))
    assert len(declared) > 40, declared
    symbols = run("nm", "-D", "--defined-only", "tree/lib/libpenumbra.so").split("\n")
    exported = {line.split()[-1] for line in symbols if line}
    assert exported == declared, exported ^ declared
    needed = set(re.findall(r"NEEDED\s+(\S+)", run("objdump", "-p", "tree/lib/libpenumbra.so")))
    allowed = {"libstdc++.so.6", "libm.so.6", "libgcc_s.so.1", "libc.so.6", "ld-linux-x86-64.so.2"}
    assert needed <= allowed, needed - allowed
    # The guide tells the size, and lists every handle.
    guide, size = open(GUIDE).read(), os.path.getsize("tree/lib/libpenumbra.so")
    told = float(re.search(r"about ([\d.]+) MB shared", guide).group(1))
    assert abs(told - size / 1e6) < 0.1 * told or os.path.basename(BUILD) != "release", (told, size)
    table = set(re.findall(r"^\| `(penumbra_\w+)` \| ", guide.split("## Handles")[1].split("##")[0], re.M))
    handles = set(re.findall(r"typedef struct (\w+) \1;", header))
    assert table == handles, table ^ handles
    print(f"{len(declared)} functions, no other symbol; links {', '.join(sorted(needed))}; {size // 1024} KB")


def check_header():
    """The header compiles alone, as C99 and as C++, without a warning."""
    open("header.c", "w").write("#include <penumbra.h>\nint main(void) { return penumbra_version()[0] == 0; }\n")
    for compiler, language, standard in (("cc", "c", "c99"), ("cc", "c", "c11"), ("c++", "c++", "c++98"), ("c++", "c++", "c++20")):
        warnings = [] if standard == "c++98" else ["-Wpedantic"]  # <stdint.h> itself is newer than C++98
        run(compiler, "-x", language, "-std=" + standard, "-Wall", "-Wextra", "-Wshadow", "-Werror", *warnings, "-Itree/include",
            "-fsyntax-only", "header.c")


def check_programs():
    """Checks the programs of the install tree, their pages, the add-on, and that the farm finds the programs wherever
    the tree lies."""
    for component in ("player", "programs", "documents"):
        run("cmake", "--install", BUILD, "--prefix", os.path.abspath("second"), "--component", component)
    shutil.move("second", "moved")
    for program in ("penumbra-bake", "penumbra-fit", "penumbra-pack", "penumbra-player"):
        assert run(f"moved/bin/{program}", "--version").startswith(f"{program} 0.1.0")
        verbs = re.findall(r"^  ([a-z]+) ", run(BIN + "/" + program, "--help").split("Verbs:")[1], re.M)
        with gzip.open(f"moved/share/man/man1/{program}.1.gz", "rt") as file:
            page = file.read()
        assert len(verbs) > 3 and all(f".SH {verb.upper()}\n" in page for verb in verbs), (program, verbs)
        assert page.count(".TP") > 20, program
    assert "penumbra_addon/__init__.py" in zipfile.ZipFile("moved/share/penumbra/penumbra_addon.zip").namelist()
    found = run(sys.executable, "-c", "from farm.config import programs_folder; print(programs_folder('', '.'))",
                cwd="moved/share/penumbra/scripts", env={k: v for k, v in os.environ.items() if k != "PENUMBRA_BIN"})
    assert os.path.realpath(found.strip()) == os.path.realpath("moved/bin"), found
    assert "name red paint" in " ".join(run("moved/bin/penumbra-bake", "info", "moved/share/penumbra/materials.pnb").split())
    assert os.path.exists("moved/share/doc/penumbra/docs/install.md")
    if os.path.exists(SOURCE + "/scripts/penumbra"):
        run("moved/bin/penumbra", "--help")


def check_runs(program, picture, **more):
    lines = run(program, "x.pnb", picture, **more).splitlines()
    assert len(lines) >= 4 and all(re.match(r"frame \d+: mean ambient 0\.\d+, out of range \d\.\d+$", l) for l in lines), lines
    data = open(picture, "rb").read()
    assert data.startswith(b"P6 256 256 255\n") and len(data) == 15 + 3 * 256 * 256
    lit = sum(data[15 + 3 * i:18 + 3 * i] != b"\0\0\0" for i in range(256 * 256)) / 256 / 256
    assert 0.03 < lit < 0.9, lit
    return lines, data


def check_examples():
    os.mkdir("project")
    open("project/CMakeLists.txt", "w").write(f"""cmake_minimum_required(VERSION 3.25)
project(engine LANGUAGES C)
set(CMAKE_C_STANDARD 99)
find_package(penumbra 0.1 REQUIRED)
if(NOT EXISTS "${{PENUMBRA_DATA_DIR}}/asset.fbs")
    message(FATAL_ERROR "no schema in ${{PENUMBRA_DATA_DIR}}")
endif()
add_executable(shared "{EXAMPLE}")
target_link_libraries(shared PRIVATE penumbra::penumbra m)
add_executable(static "{EXAMPLE}")
target_link_libraries(static PRIVATE penumbra::penumbra_static m)
""")
    run("cmake", "-S", "project", "-B", "project/build", "-DCMAKE_PREFIX_PATH=" + os.path.abspath("tree"))
    run("cmake", "--build", "project/build")
    environment = dict(os.environ, PKG_CONFIG_PATH=os.path.abspath("tree/lib/pkgconfig"))
    flags = run("pkg-config", "--cflags", "--libs", "penumbra", env=environment).split()
    assert run("pkg-config", "--modversion", "penumbra", env=environment) == "0.1.0\n"
    run("cc", "-std=c99", "-O2", "-Wall", "-Wextra", "-Werror", EXAMPLE, *flags, "-lm", "-o", "by_pkg_config")
    static = run("pkg-config", "--static", "--cflags", "--libs", "penumbra", env=environment).split()
    static = ["-l:libpenumbra.a" if flag == "-lpenumbra" else flag for flag in static]
    run("cc", "-std=c99", "-O2", EXAMPLE, *static, "-o", "by_pkg_config_static")
    library = {"env": dict(os.environ, LD_LIBRARY_PATH=os.path.abspath("tree/lib"))}
    expected = check_runs("project/build/shared", "shared.ppm")
    for program, more in (("project/build/static", {}), ("./by_pkg_config", library), ("./by_pkg_config_static", {})):
        assert check_runs(program, "other.ppm", **more) == expected, program
    for arguments, says in ((["x.pnb", "no.ppm", "moonwalk"], "shade_character: x.pnb has no clip moonwalk\n"),
                            (["none.pnb", "no.ppm"], "none.pnb: cannot open"), (["x.pnb", "no_folder/no.ppm"], "no_folder/no.ppm: ")):
        result = subprocess.run(["project/build/static", *arguments], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        assert result.returncode in (1, 2) and says in result.stderr and not result.stdout, (arguments, result)
        assert not os.path.exists("no.ppm")
    run("cc", "-std=c99", "-O2", "-Wall", "-Wextra", "-Werror", CLOTH, *flags, "-lm", "-o", "cloth")
    result = subprocess.run(["./cloth", "x.pnb"], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=library["env"])
    assert result.returncode == 1 and "shade_cloth: PENUMBRA_UNSUPPORTED: x.pnb: is a skinned mesh" in result.stderr, result
    run("cc", "-std=c99", "-O2", "-Wall", "-Wextra", "-Werror", CAST, *flags, "-o", "cast")
    result = subprocess.run(["./cast", "x.pnb", "no.pgm"], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=library["env"])
    assert result.returncode == 1 and "x.pnb: has neither fields of parts nor spheres" in result.stderr and not os.path.exists("no.pgm"), result
    printed = run("./cast", "c.pnb", "ground.pgm", 0.7, env=library["env"])
    means = [float(x) for x in re.findall(r"mean ambient ([0-9.]+) alone, ([0-9.]+) beside", printed) for x in x]
    grey = open("ground.pgm", "rb").read()[-256 * 256:]
    assert len(means) == 4 and means[1] < means[0] and means[3] < means[2], printed
    assert min(grey) < 140 and grey[0] > 245, (min(grey), grey[0])
    environment = library["env"]
    printed = run(sys.executable, PYTHON, "c.pnb", env=environment)
    means = [float(mean) for mean in re.findall(r"mean ambient ([0-9.]+)", printed)]
    assert len(means) > 1 and all(0.2 < mean < 1 for mean in means) and len(set(means)) > 1, printed
    result = subprocess.run([sys.executable, PYTHON, "none.pnb"], stderr=subprocess.PIPE, text=True, env=environment)
    assert result.returncode == 1 and "ambient: none.pnb: cannot open" in result.stderr, result
    print("the example in C by find_package and by pkg-config, shared and static: the same figures and picture")
    print("\n".join(expected[0][:2]))


def check_example_is_short():
    for example in (EXAMPLE, CLOTH, CAST, PYTHON):
        lines = len(open(example).readlines())
        assert lines < 100, lines


with tempfile.TemporaryDirectory() as folder:
    os.chdir(folder)
    check_example_is_short()
    make_asset()
    check_installs_and_moves()
    check_programs()
    check_header()
    check_examples()
    print("test_install: all checks passed")
    os.chdir("/")
