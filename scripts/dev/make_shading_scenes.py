#!/usr/bin/python3
"""Writes fit/reflectance/shading_scene_table.cpp from tests/golden/scene_seed11.json, which states the scenes' origin.

    scripts/dev/make_shading_scenes.py >fit/reflectance/shading_scene_table.cpp

Numbers keep all their digits."""
import json
import pathlib

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent


def rows_of(values, per_row, indent):
    texts = [repr(v) for v in values]
    return ",\n".join(indent + ", ".join(texts[i:i + per_row]) for i in range(0, len(texts), per_row))


def part_of(kind, x, y, z, cosine=None):
    return f"{{OccluderPart::{'kWall' if kind == 'wall' else 'kCap'}, {{{x!r}, {y!r}, {z!r}}}, {cosine or 0.0!r}}}"


def main():
    scenes = json.loads((ROOT / "tests/golden/scene_seed11.json").read_text())
    parts = [part_of(*part) for occluder in scenes["occluders"] for part in occluder["parts"]]
    counts = [len(occluder["parts"]) for occluder in scenes["occluders"]]
    print("// Written by scripts/dev/make_shading_scenes.py from tests/golden/scene_seed11.json; not to be edited.\n"
          '#include "fit/reflectance/shading_scene_table.h"\n\n// clang-format off\nnamespace penumbra {\n')
    print(f"const std::array<OccluderPart, {len(parts)}> kSceneParts = {{{{")
    print(",\n".join("    " + part for part in parts) + "}};\n")
    print(f"const std::array<int, {len(counts)}> kScenePartCounts = {{")
    print(rows_of(counts, 30, "    ") + "};\n")
    views = scenes["views"]
    print(f"const std::array<Vec3d, {len(views)}> kSceneViews = {{{{")
    print(",\n".join("    {" + ", ".join(repr(x) for x in view) + "}" for view in views) + "}};\n")
    lights = scenes["lights"]
    print(f"const std::array<std::array<double, {len(lights[0])}>, {len(lights)}> kSceneLights = {{{{")
    print(",\n".join("    {{\n" + rows_of(light, 4, "     ") + "}}" for light in lights) + "}};\n")
    print("}  // namespace penumbra")


if __name__ == "__main__":
    main()
