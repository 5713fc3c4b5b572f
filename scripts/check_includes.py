#!/usr/bin/python3
"""Includes go one way: sh <- formats <- each of bake, fit, pack, player; those four meet only in files on disk.

Also: a library stays behind the one file (or few files) that names it, so that it can be replaced there. Exits 1 and lists
every line that breaks a rule."""
import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
MAY_INCLUDE = {
    "sh": {"sh"},
    "formats": {"sh", "formats"},
    "bake": {"sh", "formats", "bake"},
    "fit": {"sh", "formats", "fit"},
    "pack": {"sh", "formats", "pack", "player/runtime"},  # penumbra-pack check runs the evaluator that engines link
    "player/runtime": {"sh", "formats", "player/runtime"},
    "player": {"sh", "formats", "player", "player/runtime"},
}
# The evaluator that engines link may see the asset format and what is in every program, no other file format.
RUNTIME_FORMATS = {"formats/asset_file.h", "formats/mesh.h", "formats/fp16.h", "formats/errors.h"}
# Library header -> the files that may name it.
EDGES = {
    r"embree3/": ["bake/occlusion_embree.cpp", "tests/bench/"],
    r"hdf5\.h|H5\w*\.h": ["formats/hdf5_handle.h", "formats/hdf5_handle.cpp", "formats/visibility_file.cpp"],
    r"tbb/|oneapi/": ["formats/parallel_for.cpp", "tests/"],
    r"tiny_gltf\.h": ["formats/rig_gltf"],
    r"assimp/": ["formats/rig_assimp"],
    r"zlib\.h": ["formats/inflate_index.cpp", "formats/zip_archive.cpp", "tests/"],
    r"meshoptimizer\.h": ["formats/rig_", "tests/"],
    r"OpenEXR/|Imf\w*\.h|Imath": ["formats/image_"],
    r"png\.h": ["formats/image_", "tests/formats/test_image_file.cpp"],
    r"CLI/": ["formats/command_line.h", "formats/name_list_option.h", "formats/name_option.h"],
    r"EGL/|GL/": ["player/"],
    r"GLFW/": ["player/view_window.cpp"],
    r"imgui|backends/imgui": ["player/view_"],
    r"Eigen/": ["fit/", "tests/"],
    r"flatbuffers/|asset_generated\.h": ["formats/asset_", "pack/", "tests/"],
}


def folder_of(relative):
    return "player/runtime" if relative.startswith("player/runtime/") else relative.split("/")[0]


def problems(path):
    relative = path.relative_to(ROOT).as_posix()
    folder = folder_of(relative)
    for number, line in enumerate(path.read_text().splitlines(), 1):
        match = re.match(r'\s*#\s*include\s*([<"])([^>"]+)[>"]', line)
        if not match:
            continue
        quote, header = match.groups()
        target = folder_of(header)
        if quote == '"' and folder in MAY_INCLUDE and target in MAY_INCLUDE and target not in MAY_INCLUDE[folder]:
            yield f"{relative}:{number}: {folder} may not include {header}"
        if folder == "player/runtime" and target == "formats" and header not in RUNTIME_FORMATS:
            yield f"{relative}:{number}: player/runtime may not include {header}"
        for pattern, homes in EDGES.items():
            if re.match(pattern, header) and not any(relative.startswith(home) for home in homes):
                yield f"{relative}:{number}: {header} belongs behind {', '.join(homes)}"


def main():
    sources = [p for folder in ("sh", "formats", "bake", "fit", "pack", "player", "tests")
               for p in sorted((ROOT / folder).rglob("*")) if p.suffix in (".cpp", ".h")]
    found = [problem for path in sources for problem in problems(path)]
    print("\n".join(found) if found else f"{len(sources)} files, every include goes the right way")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
