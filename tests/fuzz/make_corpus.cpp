// Writes the seed corpora of the fuzz targets: small valid inputs, one folder a target, so that a short run starts
// inside the formats instead of at their magic numbers. `scripts/dev/fuzz --corpus` runs it.
//   make_corpus SAMPLES OUT      SAMPLES: the rigs and sheets of scripts/samples/make_samples.py
#include <cstdio>

#include "formats/image/image_file.h"
#include "formats/rig/rig_bytes.h"
#include "formats/rig/rig_import.h"
#include "tests/formats/brdf_samples.h"
#include "tests/formats/fbx_samples.h"
#include "tests/formats/sheet_files.h"
#include "tests/formats/stage_samples.h"
#include "tests/formats/textured_rig.h"
#include "tests/formats/tiny_jpeg.h"
#include "tests/fuzz/tiny_inputs.h"

namespace {

using namespace penumbra;
namespace fs = std::filesystem;

void write(const fs::path& path, const std::string& bytes) {
    fs::create_directories(path.parent_path());
    std::ofstream(path, std::ios::binary | std::ios::trunc) << bytes;
}

fs::path inFolder(const fs::path& folder, const std::string& name) {
    fs::create_directories(folder);
    return folder / name;
}

std::string textOf(const std::vector<std::byte>& bytes) {
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

// The targets of assets share their inputs; each takes every second one.
void writeAssets(const fs::path& out) {
    const std::vector<std::vector<std::byte>>& assets = tinyAssets();
    for (std::size_t i = 0; i < assets.size(); ++i)
        write(out / (i % 2 ? "fuzz_c_api" : "fuzz_asset") / ("tiny" + std::to_string(i) + ".pnb"), textOf(assets[i]));
}

void writeStageFiles(const fs::path& out) {
    BrdfFile brdf = samples::sampleBrdf();
    brdf.operators = samples::sampleOperators();
    writeBrdf(inFolder(out / "fuzz_brdf_file", "operators.brdf.h5"), brdf);
    writeBrdf(out / "fuzz_brdf_file" / "steps.brdf.h5", tinySteps());
    writeBrdf(out / "fuzz_brdf_file" / "principled.brdf.h5", tinyPrincipled());
    for (const BrdfFile& looks : tinyNewLooks()) writeBrdf(out / "fuzz_brdf_file" / (looks.name + ".brdf.h5"), looks);
    LightFile light = samples::sampleLight();
    light.lobes = samples::sampleLobes();
    light.window = {1, 0.5};
    writeLight(inFolder(out / "fuzz_light_file", "lobes.light.h5"), light);
    writeLight(out / "fuzz_light_file" / "suns.light.h5", tinySunny());
    writePoseFile(inFolder(out / "fuzz_pose_file", "sampled.poses.h5"), samples::poseFile());
    writeFields(inFolder(out / "fuzz_field_file", "two_parts.fields.h5"), samples::fieldFile());
    writeBlockers(inFolder(out / "fuzz_blocker_file", "three.blockers.h5"), samples::blockerFile());
    writeTransfer(inFolder(out / "fuzz_transfer_file", "linear.transfer.h5"),
                  samples::transferModel(TransferModelKind::kLinear));
    writeTransfer(inFolder(out / "fuzz_transfer_file", "pca.transfer.h5"),
                  samples::transferModel(TransferModelKind::kPca));
    writeLobes(inFolder(out / "fuzz_lobe_file", "two.lobes.h5"), samples::lobeModel());
    writePoseFile(inFolder(out / "fuzz_pose_file", "mixed.poses.h5"), samples::mixedPoseFile());
    write(out / "fuzz_model_file" / "tube.model.h5", tinyModels().front());
    write(out / "fuzz_model_file" / "composed.model.h5", tinyModels().back());
    samples::writeVisibility(inFolder(out / "fuzz_visibility_file", "strip.vis.h5"), samples::visibilityHeader(1, 2),
                             Precision::kFloat16);
    samples::writeVisibility(out / "fuzz_visibility_file" / "sheet.vis.h5", samples::sheetHeader(2, 2),
                             Precision::kFloat32);
    samples::writeVisibility(out / "fuzz_visibility_file" / "points.vis.h5", samples::pointsHeader(2),
                             Precision::kFloat16);
    samples::writeVisibility(out / "fuzz_visibility_file" / "local.vis.h5", samples::localHeader(1, 2),
                             Precision::kFloat16);
}

void writeTables(const fs::path& out) {
    const RgbBrdf ggx = rgbBrdf(parseBrdf("ggx:color=1/0.5/0.25"));
    const fs::path brdfs = out / "fuzz_brdf_source";
    write(brdfs / "isotropic.txt", samples::isotropicTable(ggx, 2, 3));
    write(brdfs / "orthotropic.txt", samples::anisotropicTable(ggx, "orthotropic", 2, 2, 4));
    write(brdfs / "scattered.txt", samples::scatteredFile(ggx, 3, 3));
    write(brdfs / "fits.txt", "name, diffuse_r, diffuse_g, diffuse_b\na, 0.1, 0.2, 0.3\n");
    const fs::path inputs = out / "fuzz_input_table";
    write(inputs / "seconds.csv", "seconds,wind,ball.x\n0,1,2\n0.5,1.5,2.5\n1,2,3e1\n");
    const fs::path scenes = out / "fuzz_scene";
    write(scenes / "least.json", R"({"version": 1, "characters": [{"asset": "a.pnb"}]}
)");
    write(
        scenes / "full.json",
        R"({"version": 1, "characters": [{"name": "a", "asset": "a.pnb", "clip": "walk", "time": 0.5, "position": [1, 0, -2],
"yaw": 90, "scale": 1, "material": "clay", "slots": {"body": "skin"}}, {"asset": "a.pnb"}], "props": [{"asset": "b.pnb"}],
"ground": {"height": -1, "centre": [0, 0, 1], "size": 8, "resolution": 64, "albedo": [0.1, 0.2, 0.3]},
"light": {"asset": "l.pnb", "name": "sky", "rotation": "yaw=3"}, "camera": "yaw=2"}
)");
    write(scenes / "pose.json",
          R"({"version": 1, "characters": [{"asset": "a.pnb", "pose": {"file": "a.poses.json", "frame": 2}}]}
)");
    write(
        scenes / "heights.json",
        R"({"version": 1, "characters": [{"asset": "a.pnb", "on_ground": true}], "ground": {"height": -1, "material": "sand", "heights": {"file": "d.npz",
"array": "elevation", "cells": [30, 20], "scale": 0.1, "offset": 3, "border": "periodic", "no_data": -9, "fill": 0, "fps": 10, "time": 2, "order": 4, "step": 2}}}
)");
    write(out / "fuzz_bone_poses" / "one.poses.json",
          R"({"format": "penumbra.bone_poses", "version": 1, "joints": ["hip"], "poses": [{"clip": "walk", "time": 0.5,
"bones": [[1, 0, 0, 0.5, 0, 1, 0, 0, 0, 0, 1, 0]], "rotations": [[0, 0.1, 0]]}]}
)");
    write(
        out / "fuzz_camera_poses" / "two.poses.json",
        R"({"format": "penumbra.camera_poses", "version": 1, "camera": {"f": 640, "cx": 319.5, "cy": 239.5, "size": [640, 480], "k1": -0.1, "k2": 0.02},
"frames": [{"file": "a.jpg", "R": [[1, 0, 0], [0, -1, 0], [0, 0, -1]], "t": [0, 0.1, 2], "margin": 0.9}, {"file": "b.jpg"}]}
)");
    write(
        out / "fuzz_bracket_file" / "ball.json",
        R"({"camera": {"f": 600, "cx": 319.5, "cy": 239.5, "size": [640, 480], "k1": -0.1, "k2": 0.01}, "response": "find",
 "tag": "36h11:3:0.7", "pictures": [{"file": "a.jpg", "exposure": 4}, {"file": "b.jpg", "exposure": 1}]}
)");
    write(out / "fuzz_bracket_file" / "walk.json",
          R"({"camera": {"f": 600, "size": [640, 480]}, "response": "srgb",
 "pictures": [{"file": "a.jpg", "exposure": 4, "R": [[1, 0, 0], [0, 1, 0], [0, 0, 1]], "t": [0, 0, 2]}]}
)");
    write(out / "fuzz_colmap_model" / "two.txt",
          std::string("# cameras\n1 RADIAL 640 480 600 320 240 -0.1 0.02\n") + '\0' +
              "# images\n1 1 0 0 0 0 0 2 1 a.jpg\n10 20 -1 30 40 5\n2 0.9 0.1 0 0 0 0.5 2 1 b c.jpg\n\n");
    write(inputs / "frames.csv", "clip,frame,wind\nwave,0,1\nwave,1,2\n\"gust\",0,-3\n");
}

// Heights as an array, as the header of raw numbers, and as a grey picture of 16 bits.
void writeHeights(const fs::path& out) {
    const fs::path heights = out / "fuzz_height_file";
    std::string header = "{'descr': '<i2', 'fortran_order': False, 'shape': (2, 3), }";
    header.resize(117, ' ');
    header += '\n';
    write(heights / "still.npy",
          std::string("\x93NUMPY\x01\x00\x76\x00", 10) + header + std::string("\0\0\1\0\2\0\3\0\4\0\5\0", 12));
    write(heights / "bil.hdr",
          "NROWS 2\nNCOLS 3\nNBITS 16\nNBANDS 1\nBYTEORDER M\nLAYOUT BIL\nPIXELTYPE SIGNEDINT\n"
          "SKIPBYTES 0\nNODATA -32768\n");
    write(heights / "numbers.bil", "NROWS 2\nNCOLS 3\nNODATA 5\n\n" + std::string("\0\0\1\0\2\0\3\0\4\0\5\0", 12));
    Image exr{2, 2, {{1, 2, 3}, {4, 5, 6}, {7, 8, 9}, {10, 11, 12}}, {}};
    writeExr(heights / "red.exr", exr);
    constexpr unsigned char kGrey[] = {0x89, 0x50, 0x4e, 0x47, 0x0d, 0x0a, 0x1a, 0x0a, 0x00, 0x00, 0x00, 0x0d, 0x49,
                                       0x48, 0x44, 0x52, 0x00, 0x00, 0x00, 0x03, 0x00, 0x00, 0x00, 0x02, 0x10, 0x00,
                                       0x00, 0x00, 0x00, 0xe8, 0x8f, 0xe5, 0x85, 0x00, 0x00, 0x00, 0x12, 0x49, 0x44,
                                       0x41, 0x54, 0x78, 0x9c, 0x63, 0x60, 0x60, 0x64, 0x64, 0xf8, 0xff, 0x9f, 0x01,
                                       0x42, 0x01, 0x00, 0x14, 0x1a, 0x04, 0x01, 0xde, 0x89, 0xb4, 0xf8, 0x00, 0x00,
                                       0x00, 0x00, 0x49, 0x45, 0x4e, 0x44, 0xae, 0x42, 0x60, 0x82};
    write(heights / "grey.png", std::string(reinterpret_cast<const char*>(kGrey), sizeof kGrey));
}

void writeImages(const fs::path& out) {
    Image image{4, 3, {}, {}};
    for (int i = 0; i < 12; ++i) {
        image.pixels.push_back({float(i) / 12, 0.5f, float(i % 4)});
        image.alpha.push_back(float(i % 3) / 2);
    }
    writeExr(inFolder(out / "fuzz_image", "alpha.exr"), image);
    writePng(out / "fuzz_image" / "alpha.png", image, 1);
    image.alpha.clear();
    writeExr(out / "fuzz_image" / "plain.exr", image);
    std::string hdr = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\nEXPOSURE=2\n\n-Y 2 +X 3\n";
    for (int i = 0; i < 6; ++i) hdr += {char(128 + i), char(64 * i), char(7), char(129)};
    write(out / "fuzz_image" / "flat.hdr", hdr);
    std::string colors =
        "#?RADIANCE\nFORMAT= 32-bit_rle_rgbe\nEXPOSURE=\t+2\nCOLORCORR=2 1 0.5\n"
        "PRIMARIES=.708 .292 .17 .797 .131 .046 .3127 .329\n\n-Y 1 +X 2\n";
    for (int i = 0; i < 2; ++i) colors += {char(128 + i), char(64 * i), char(7), char(129)};
    write(out / "fuzz_image" / "colors.hdr", colors);
}

// Pictures of surfaces, and a rig that has one.
void writeTextures(const fs::path& out) {
    const std::string png = samples::greyPng(3, {0, 50, 100, 150, 200, 250});
    const std::vector<std::byte> jpeg = samples::tinyJpeg();
    write(out / "fuzz_texture" / "grey.png", png);
    write(out / "fuzz_texture" / "halves.jpg", {reinterpret_cast<const char*>(jpeg.data()), jpeg.size()});
    samples::EditableGlb glb = samples::texturedRig(
        {{samples::triangleAt(0), {samples::Uv{0, 0}, samples::Uv{2, 0}, samples::Uv{0, 1}}}}, png);
    glb.json["samplers"] = {{{"wrapS", 33648}, {"wrapT", 33071}}};
    glb.json["textures"][0]["sampler"] = 0;
    glb.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"]["extensions"]["KHR_texture_transform"] = {
        {"scale", {0.5, 2.0}}, {"rotation", 0.3}, {"offset", {0.1, 0.2}}};
    write(out / "fuzz_base_colors" / "textured.glb", glb.bytes());
    write(out / "fuzz_rig" / "textured.glb", glb.bytes());
}

// A triangle that moves, in every format of positions.
void writeCaches(const fs::path& out) {
    const fs::path binary = out / "fuzz_point_cache_binary", numpy = out / "fuzz_point_cache_numpy";
    using samples::ordered;
    std::vector<float> numbers;
    for (int i = 0; i < 2 * 3 * 3; ++i) numbers.push_back(float(i * i % 7) / 4);
    std::string little, big;
    for (const float number : numbers) {
        little += ordered(number, std::endian::little);
        big += ordered(number, std::endian::big);
    }
    const auto low = [](auto value) { return ordered(value, std::endian::little); };
    const auto high = [](auto value) { return ordered(value, std::endian::big); };
    write(binary / "triangle.pc2", std::string("POINTCACHE2\0", 12) + low(std::int32_t(1)) + low(std::int32_t(3)) +
                                       low(0.0f) + low(1.0f) + low(std::int32_t(2)) + little);
    write(binary / "triangle.mdd", high(std::int32_t(2)) + high(std::int32_t(3)) + high(0.0f) + high(0.5f) + big);
    write(binary / "sheet.obj", samples::sheetObj(3));
    write(binary / "ascii.ply", samples::sheetPly(3, "ascii"));
    write(binary / "binary.ply", samples::sheetPly(3, "binary_little_endian"));
    const std::string verts = samples::npy("<f4", "2, 3, 3", little),
                      faces = samples::npy("<u4", "1, 3", samples::bytesOf(std::vector<std::uint32_t>{0, 1, 2}));
    write(numpy / "triangle.npy", verts);
    write(numpy / "stored.npz", samples::zipOf({{"verts.npy", verts}, {"faces.npy", faces}}));
    write(numpy / "deflated.npz", samples::zipOf({{"verts.npy", verts, true}, {"faces.npy", faces, true}}, true));
}

void copyRigs(const fs::path& samples, const fs::path& out) {
    write(out / "fuzz_bvh" / "two_joints.bvh",
          "HIERARCHY\nROOT a\n{\nOFFSET 0 1 0\nCHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation\n"
          "JOINT b\n{\nOFFSET 0 1 0\nCHANNELS 1 Yrotation\nEnd Site\n{\nOFFSET 0 1 0\n}\n}\n}\n"
          "MOTION\nFrames: 2\nFrame Time: 0.04\n0 1 0 0 0 0 0\n1 2 3 10 20 30 90\n");
    for (const char* name : {"weights_u16.glb", "quantized.glb", "sparse.glb", "interpolation.glb", "swing.glb"})
        write(out / "fuzz_rig" / name, samples::readText(samples / name));
    write(out / "fuzz_rig" / "sheet_morph.glb", samples::readText(samples / "sheet_morph.glb"));
    write(out / "fuzz_point_cache_gltf" / "sheet_morph.glb", samples::readText(samples / "sheet_morph.glb"));
    write(out / "fuzz_collada_text" / "swing.dae", samples::readText(samples / "swing.dae"));
    const samples::FbxRig rig = samples::turningRig();
    write(out / "fuzz_fbx_scan" / "text.fbx", samples::asciiFile(rig.root));
    write(out / "fuzz_fbx_scan" / "deflated.fbx", samples::binaryFile(rig.root, 7400, true));
    write(out / "fuzz_fbx_scan" / "wide.fbx", samples::binaryFile(rig.root, 7500, false));
    write(out / "fuzz_rig_bytes" / "swing", textOf(bytesOf(importWithAssimp(samples / "swing.fbx"))));
}

// Cases of the targets that make their files themselves.
void writeRecipes(const fs::path& out) {
    // The whole journal; half of it, then zeros; nothing but the case.
    write(out / "fuzz_bake_journal" / "whole", "\xff");
    write(out / "fuzz_bake_journal" / "half", std::string("\x80\0\0\0\0\0\0\0\0", 9));
    write(out / "fuzz_bake_journal" / "none", std::string("\0penumbra", 9));
    // Four frames of one good shard; of two shards; of a file that is virtual itself.
    write(out / "fuzz_visibility_virtual" / "one", std::string("\3\1\0\1\1\0\0\0\0\1\1\0\1\2\3\1", 16));
    write(out / "fuzz_visibility_virtual" / "two", std::string("\3\2\0\1\1\1\0\1\0\1\1\1\0\1\2\3\1", 17));
    write(out / "fuzz_visibility_virtual" / "nested", std::string("\1\1\3\1\1\0\0\1\1\0\1\1", 12));
}

}  // namespace

int main(int argc, char** argv) {
    if (argc != 3) {
        std::fprintf(stderr, "usage: make_corpus SAMPLES OUT\n");
        return 1;
    }
    const fs::path samples = argv[1], out = argv[2];
    writeAssets(out);
    writeStageFiles(out);
    writeTables(out);
    writeHeights(out);
    writeImages(out);
    writeTextures(out);
    writeCaches(out);
    copyRigs(samples, out);
    writeRecipes(out);
    return 0;
}
