#!/usr/bin/python3
"""Includes go one way: sh <- formats <- each of bake, fit, pack, player; sh <- formats/asset <- runtime <- pack, player.

Those four never include one another; a file on disk is their only contract. Another rule holds for third-party
libraries: a library stays behind the one file (or few files) that names it, so that it can be replaced there. Exits 1
and lists every line that breaks a rule."""
import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
SH = {"sh", "sh/brdf", "sh/cast", "sh/far", "sh/height", "sh/light"}  # everybody sees the maths
# Folder or room -> the rooms that it may include beside itself. A room that is not listed may not exist.
FORMATS = {f"formats/{room}" for room in ("common", "asset", "brdf", "image", "stage", "rig", "cache", "source", "scene",
                                      "height", "camera", "capture")}
RUNTIME = {"runtime", *(f"runtime/{room}" for room in ("papers", "evaluate", "sun", "shade", "cast", "glsl", "capi"))}
FIT = {f"fit/{room}" for room in ("numerics", "clusters", "models", "light", "reflectance", "blockers", "visibility")}
PAPERS = {f"fit/papers/{room}" for room in ("align", "capture", "transfer", "lobes", "operators", "compare")}
VIEW = {"player/view", "player/view/playback", "player/view/window"}
MAY_INCLUDE = {
    "sh": set(),
    **{f"sh/{room}": {"sh"} for room in ("brdf", "far", "light")},
    **{f"sh/{room}": {"sh", "sh/far"} for room in ("cast", "height")},
    "formats/common": SH,
    **{f"formats/{room}": SH | {"formats/common"} for room in ("asset", "brdf", "image", "stage", "rig")},
    **{f"formats/rig/{room}": SH | {"formats/common", "formats/rig"} for room in ("fbx", "gltf")},
    "formats/rig/assimp": SH | {"formats/common", "formats/rig", "formats/rig/fbx"},
    "formats/camera": SH | {"formats/common", "formats/image"},
    "formats/capture": SH | {"formats/common", "formats/image", "formats/camera"},
    "formats/scene": SH | {"formats/common", "formats/asset", "formats/camera", "formats/height"},
    "formats/cache": SH | {"formats/common", "formats/rig"},
    "formats/source": SH | {"formats/common", "formats/rig", "formats/cache"},
    "formats/height": SH | {"formats/common", "formats/cache", "formats/image"},
    "bake/common": SH | FORMATS,
    "bake/source": SH | {"bake/common"} | FORMATS,
    "bake/trace": SH | {"bake/common", "bake/source"} | FORMATS,
    "bake/poses": SH | {"bake/common", "bake/source"} | FORMATS,
    **{f"bake/{room}": SH | {"bake/common", "bake/source", "bake/trace"} | FORMATS for room in ("fields", "visibility")},
    "bake/reference": SH | {"bake/common", "bake/source", "bake/trace", "bake/visibility"} | FORMATS,
    "bake/pilot": SH | {"bake/common", "bake/source", "bake/poses", "bake/fields", "bake/visibility"} | FORMATS,
    "bake/info": SH | {"bake/visibility"} | FORMATS,
    "bake": SH | {"bake/common", "bake/source", "bake/trace", "bake/poses", "bake/fields", "bake/visibility",
             "bake/pilot", "bake/reference", "bake/info"} | FORMATS,
    "fit/numerics": SH | FORMATS,
    **{f"fit/{room}": SH | {"fit/numerics"} | FORMATS
       for room in ("blockers", "clusters", "models", "light", "reflectance")},
    "fit/visibility": SH | {"fit/numerics", "fit/clusters", "fit/models"} | FORMATS,
    "fit/page": SH | FORMATS,
    "fit/camera": SH | {"fit/numerics"} | FORMATS,
    "fit/report": SH | FIT | FORMATS,  # what several commands do alike
    **{f"fit/papers/{room}": SH | FIT | FORMATS for room in ("capture", "transfer", "lobes", "operators")},
    "fit/papers/align": SH | {"fit/camera"} | FORMATS,
    "fit/papers/compare": SH | FIT | PAPERS | {"fit/page"} | FORMATS,
    "fit/papers": SH | FIT | PAPERS | {"fit/report", "fit/page"} | FORMATS,
    "fit": SH | FIT | {"fit/camera", "fit/report", "fit/page", "fit/papers"} | FORMATS,  # no other room includes fit/papers
    "pack/compress": SH | RUNTIME | FORMATS,
    **{f"pack/{room}": SH | RUNTIME | {"pack/compress"} | FORMATS for room in ("sections", "check")},
    "pack/export": SH | RUNTIME | {"pack/compress"} | FORMATS,
    "pack": SH | RUNTIME | {"pack/compress", "pack/sections", "pack/check", "pack/export"} | FORMATS,
    **{f"runtime{room}": SH | {"formats/common", "formats/asset"} for room in ("", "/papers", "/sun")},
    "runtime/web": {"runtime"},
    "runtime/evaluate": SH | {"runtime/papers", "formats/common", "formats/asset"},
    "runtime/shade": SH | {"runtime/papers", "runtime/evaluate", "formats/common", "formats/asset"},
    "runtime/cast": SH | {"runtime/evaluate", "runtime/shade", "formats/common", "formats/asset"},
    "runtime/glsl": SH | (RUNTIME - {"runtime/capi"}) | {"formats/common", "formats/asset"},
    "runtime/capi": SH | RUNTIME | {"formats/common", "formats/asset"},
    "player/gl": SH | RUNTIME | FORMATS,
    "player/papers/transfer": SH | RUNTIME | FORMATS,
    "player/frame": SH | RUNTIME | {"player/gl", "player/papers/transfer"} | FORMATS,
    "player/draw": SH | RUNTIME | {"player/gl", "player/frame"} | FORMATS,
    "player/papers": SH | RUNTIME | {"player/frame", "player/gl", "player/papers/transfer"} | FORMATS,
    "player/scene": SH | RUNTIME | {"player/frame", "player/gl", "player/papers"} | FORMATS,
    **{f"player/{room}": SH | RUNTIME | {"player/gl", "player/frame", "player/draw", "player/papers", "player/papers/transfer",
       "player/scene"} | FORMATS for room in ("render", "view/playback")},
    "player/view": SH | RUNTIME | {"player/gl", "player/frame", "player/draw", "player/papers", "player/papers/transfer", "player/scene",
                   "player/view/playback"} | FORMATS,
    "player/view/window": SH | RUNTIME | VIEW | {"player/gl", "player/frame", "player/draw", "player/papers/transfer", "player/scene",
                          "player/composite"} | FORMATS,
    "player/composite": SH | RUNTIME | {"player/gl", "player/frame", "player/draw", "player/papers", "player/scene", "player/render"} | FORMATS,
    "player/bench": SH | RUNTIME | {"player/gl", "player/frame", "player/draw", "player/papers/transfer", "player/render",
                    "player/scene"} | FORMATS,
    "player": SH | RUNTIME | {"player/gl", "player/frame", "player/draw", "player/render", "player/papers", "player/scene",
               "player/bench", "player/composite"} | VIEW | FORMATS,
}
# The evaluator that engines link may see the asset format and what is in every program, but no other file format.
RUNTIME_FORMATS = {"formats/asset/asset_file.h", "formats/asset/mapped_file.h", "formats/asset/other_sides.h", "formats/common/mesh.h", "formats/common/model_kind.h", "formats/common/fp16.h",
                   "formats/common/errors.h"}
# Library header -> the files that may name it.
EDGES = {
    r"embree[34]/": ["bake/trace/embree.h"],
    r"bake/trace/embree\.h": ["bake/trace/occlusion_embree.cpp", "tests/bench/bench_bake.cpp"],
    r"hdf5\.h|H5\w*\.h": ["formats/stage/hdf5_handle.h", "formats/stage/hdf5_handle.cpp", "formats/stage/visibility_file.cpp"],
    r"tbb/|oneapi/": ["formats/common/parallel_for.cpp", "tests/"],
    r"tiny_gltf\.h": ["formats/rig/gltf/rig_gltf"],
    r"assimp/": ["formats/rig/assimp/rig_assimp"],
    r"zlib\.h": ["formats/cache/inflate_file.cpp", "formats/cache/zip_archive.cpp", "formats/rig/fbx/fbx_tree.cpp", "tests/"],
    r"meshoptimizer\.h": ["formats/rig/gltf/rig_meshopt", "tests/"],
    r"OpenEXR/|Imf\w*\.h|Imath": ["formats/image/image_", "tests/formats/test_height_file.cpp",
                                     "tests/formats/test_light_pictures.cpp", "tests/formats/test_light_shapes.cpp"],
    r"png\.h": ["formats/image/image_", "tests/formats/test_image_file.cpp",
                  "tests/formats/test_height_file.cpp", "tests/formats/test_texture_file.cpp"],
    r"jpeglib\.h|jerror\.h": ["formats/image/image_jpeg.cpp"],
    r"CLI/": ["formats/common/command_line.h", "formats/common/options.h", "formats/common/name_list_option.h", "formats/common/name_option.h"],
    r"EGL/|GL/": ["player/gl/"],
    r"GLFW/": ["player/view/window/view_window.cpp"],
    r"imgui|backends/imgui": ["player/view/"],
    r"Eigen/": ["fit/", "pack/", "formats/brdf/fit_slices.cpp", "formats/camera/tag_pose.cpp", "tests/"],
    r"apriltag/": ["formats/camera/tag_family"],
    r"linux/videodev2\.h": ["formats/camera/video_device.cpp", "tests/formats/test_video_device.cpp"],
    r"ceres/|glog/": ["fit/numerics/quasi_newton.cpp", "fit/camera/align_tracks.cpp", "fit/camera/solve_camera.cpp"],  # GPL parts: never in the player or in pack
    r"flatbuffers/|asset_generated\.h": ["formats/asset/", "pack/", "tests/"],
}


def folder_of(relative):
    """Returns the room that a file stands in: "fit/models" for fit/models/features.cpp, "sh" for sh/vec3.h."""
    return relative.rpartition("/")[0]


def problems(path):
    relative = path.relative_to(ROOT).as_posix()
    folder = folder_of(relative)
    if folder not in MAY_INCLUDE and not folder.startswith("tests"):
        yield f"{relative}: {folder} is no room of MAY_INCLUDE"
    for number, line in enumerate(path.read_text().splitlines(), 1):
        match = re.match(r'\s*#\s*include\s*([<"])([^>"]+)[>"]', line)
        if not match:
            continue
        quote, header = match.groups()
        target = folder_of(header)
        if quote == '"' and folder in MAY_INCLUDE and target in MAY_INCLUDE and target not in MAY_INCLUDE[folder] | {folder}:
            yield f"{relative}:{number}: {folder} may not include {header}"
        if folder in RUNTIME and target.startswith("formats") and header not in RUNTIME_FORMATS:
            yield f"{relative}:{number}: {folder} may not include {header}"
        for pattern, homes in EDGES.items():
            if re.match(pattern, header) and not any(relative.startswith(home) for home in homes):
                yield f"{relative}:{number}: {header} belongs behind {', '.join(homes)}"


def main():
    sources = [p for folder in ("sh", "formats", "runtime", "bake", "fit", "pack", "player", "tests")
               for p in sorted((ROOT / folder).rglob("*")) if p.suffix in (".cpp", ".h")]
    found = [problem for path in sources for problem in problems(path)]
    print("\n".join(found) if found else f"{len(sources)} files, every include goes the right way")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
