// Sequences of mesh files, MDD and PC2 caches and glTF morph targets give the same sheet as NumPy's files
// (test_point_cache.cpp).
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <bit>
#include <cmath>

#include "formats/cache/mesh_file.h"
#include "formats/common/errors.h"
#include "formats/source/source_readers.h"
#include "tests/formats/flapping_sheet.h"
#include "tests/formats/rig_samples.h"
#include "tests/formats/sheet_files.h"
#include "tests/formats/textured_rig.h"

namespace penumbra::test_point_cache_formats {
namespace {

using samples::expectSheet;
using samples::kFloat;
using samples::kSheetFrames;
using samples::sheetFrame;
using samples::sheetMdd;
using samples::sheetObj;
using samples::sheetPc2;
using samples::sheetPly;
using samples::writeSheets;
using samples::writeText;
using testing::ElementsAre;
using testing::EndsWith;
using testing::HasSubstr;

// Makes a new folder.
std::filesystem::path folder(const std::string& name) {
    const std::filesystem::path path = std::filesystem::path(testing::TempDir()) / ("penumbra_sequence_" + name);
    std::filesystem::remove_all(path);
    std::filesystem::create_directories(path);
    return path;
}

TEST(PointCacheSequence, ObjByPatternFolderAndFirstFile) {
    const std::filesystem::path place = folder("obj");
    writeSheets(place, "frame_", ".obj", [](std::size_t f) { return sheetObj(f); });
    for (const char* name : {"frame_%04d.obj", "frame_%d.obj", "frame_*.obj", "frame_####.obj", "frame_0000.obj"}) {
        const PointCache cache = readPointCache({place / name}, {.fps = 12});
        expectSheet(cache, kFloat);
        EXPECT_EQ(cache.clips[0].name, "frame");
        EXPECT_DOUBLE_EQ(cache.clips[0].times[12], 1);
        EXPECT_EQ(cache.files_read.size(), kSheetFrames);
        EXPECT_TRUE(isPointCache(place / name));
    }
    const PointCache all = readPointCache({place}, {});
    expectSheet(all, kFloat);
    EXPECT_DOUBLE_EQ(all.clips[0].times[12], 12 / kCacheFps);
    EXPECT_EQ(readPointCache({place / "frame_0004.obj"}, {}).clips[0].times.size(), 9u);
}

TEST(PointCacheSequence, PlyInEveryEncoding) {
    for (const char* format : {"ascii", "binary_little_endian", "binary_big_endian"}) {
        const std::filesystem::path place = folder("ply");
        writeSheets(place, "sheet.", ".ply", [&](std::size_t f) { return sheetPly(f, format); });
        expectSheet(readPointCache({place / "sheet.*.ply"}, {}), kFloat);
    }
}

// The numbers have no leading zeros and start at 8. 8, 9, 10, ... is their order, not that of the names.
TEST(PointCacheSequence, NumbersAreOrderedAsNumbers) {
    const std::filesystem::path place = folder("numbers");
    for (std::size_t f = 0; f < kSheetFrames; ++f)
        writeText(place / ("a" + std::to_string(f + 8) + ".obj"), sheetObj(f));
    expectSheet(readPointCache({place}, {}), kFloat);
}

template <class Error = InvalidInput>
std::string refusal(const std::vector<std::filesystem::path>& paths) {
    try {
        const PointCache cache = readPointCache(paths, {});
        for (std::size_t c = 0; c < cache.clips.size(); ++c)
            for (std::size_t k = 0; k < cache.clips[c].times.size(); ++k) readFrame(cache, c, k);
    } catch (const Error& error) {
        return error.what();
    } catch (const std::exception& error) {
        ADD_FAILURE() << "another kind of error: " << error.what();
        return {};
    }
    ADD_FAILURE() << paths[0] << " was read";
    return {};
}

TEST(PointCacheSequence, MissingAndDoubleNumbersAreNamed) {
    const std::filesystem::path place = folder("missing");
    writeSheets(place, "frame_", ".obj", [](std::size_t f) { return sheetObj(f); });
    writeText(place / "frame_00003.obj", sheetObj(3));
    EXPECT_THAT(refusal({place}), HasSubstr("has the number of"));
    std::filesystem::remove(place / "frame_00003.obj");
    std::filesystem::remove(place / "frame_0007.obj");
    EXPECT_THAT(refusal({place}), HasSubstr("frame_0007.obj: is missing in the sequence that goes on with"));
    writeText(place / "ball_0000.obj", sheetObj(3));
    EXPECT_THAT(refusal({place}), HasSubstr("several sequences, ball_*.obj and frame_*.obj"));
    EXPECT_THAT(refusal({place / "cloth_*.obj"}), HasSubstr("cloth_*.obj: no numbered files"));
    EXPECT_THROW(readPointCache({folder("empty")}, {}), IoError);
    EXPECT_THROW(readPointCache({place / "frame_0008.obj", place / "frame_0008.obj"}, {}), UsageError);
    EXPECT_THROW(readPointCache({place / "nowhere/frame_*.obj"}, {}), IoError);
    EXPECT_THROW(readPointCache({place / "frame_0099.obj"}, {}), IoError);
}

// Every fifth number is there, exported with a step, and each file is a key. Two files do not tell a step from a gap.
TEST(PointCacheSequence, StepsOfNumbersAreFramesWithANote) {
    const std::filesystem::path place = folder("steps");
    for (const unsigned f : {5u, 10u}) writeText(place / samples::format("s_%04u.obj", f), sheetObj(f));
    EXPECT_THAT(refusal({place}), HasSubstr("s_0006.obj: is missing in the sequence that goes on with"));
    for (const unsigned f : {15u, 20u, 25u}) writeText(place / samples::format("s_%04u.obj", f), sheetObj(f));
    const PointCache cache = readPointCache({place / "s_####.obj"}, {.fps = 4});
    EXPECT_THAT(cache.clips[0].times, ElementsAre(0, 0.25, 0.5, 0.75, 1));
    EXPECT_LE(samples::distanceToSheet(cache, readFrame(cache, 0, 2), 15), kFloat);
    ASSERT_EQ(cache.notes.size(), 1u);
    EXPECT_THAT(cache.notes[0], HasSubstr("s_####.obj: numbers in steps of 5; each file is one frame"));
    EXPECT_EQ(readPointCache({place / "s_0010.obj"}, {}).clips[0].times.size(), 4u);
    std::filesystem::remove(place / "s_0015.obj");
    EXPECT_THAT(refusal({place}), HasSubstr("s_0015.obj: is missing in the sequence in steps of 5 that goes on with"));
    writeText(place / "s_0016.obj", sheetObj(16));
    EXPECT_THAT(refusal({place}), HasSubstr("s_0006.obj: is missing in the sequence that goes on with"));
    writeSheets(place, "whole_", ".obj", [](std::size_t f) { return sheetObj(f); });
    EXPECT_TRUE(readPointCache({place / "whole_####.obj"}, {}).notes.empty());
}

// A byte order mark hides no line. A weight of 1 and colours are passed over; by another weight readers disagree.
TEST(PointCacheSequence, WhatElseAVertexOfAnObjHas) {
    const std::filesystem::path place = folder("marks");
    const std::string whole = sheetObj(9), vertices = whole.substr(whole.find("v "));
    const auto after = [&](const std::string& numbers) {
        std::string text = vertices;
        return text.insert(text.find('\n'), numbers);
    };
    writeSheets(place, "frame_", ".obj", [](std::size_t f) { return sheetObj(f); });
    for (const std::string& text :
         {"\xef\xbb\xbf" + vertices, after(" 1.0"), after(" 0.5 0.25 1"), after(" 0.5 0.25 1 1 # red")}) {
        writeText(place / "frame_0009.obj", text);
        expectSheet(readPointCache({place}, {.fps = 12}), kFloat);
    }
    for (const std::string numbers : {" 2", " 0.5 # half"}) {
        writeText(place / "frame_0009.obj", after(numbers));
        EXPECT_THAT(refusal({place}), HasSubstr("frame_0009.obj: line 1: the weight w of a vertex is not 1"));
    }
}

TEST(PointCacheSequence, ChangedTopologyNamesTheFrame) {
    const std::filesystem::path place = folder("topology");
    const auto write = [&](const std::string& changed) {
        writeSheets(place, "frame_", ".obj", [](std::size_t f) { return sheetObj(f); });
        writeText(place / "frame_0009.obj", changed);
        return refusal({place});
    };
    const std::string whole = sheetObj(9);
    for (const std::string& message :
         {write("v 1 2 3\n" + whole), write(whole + "f 1 2 3\n"), write(whole.substr(0, whole.rfind("f "))),
          write(whole.substr(0, whole.rfind("f ")) + "f 1 2 3 4\n")}) {
        EXPECT_THAT(message, HasSubstr("frame_0009.obj: "));
        EXPECT_THAT(message, EndsWith("unlike " + (place / "frame_0000.obj").string()));
    }
    EXPECT_THAT(write("v 1 2 3\n" + whole), HasSubstr("has 46 vertices, not 45"));
    EXPECT_THAT(write(whole.substr(0, whole.rfind("f ")) + "f 1 2 3 4\n"), HasSubstr("its triangle 46 has other"));
    std::string nan = whole;
    const std::size_t number = nan.find("v ", 40) + 2;
    nan.replace(number, nan.find(' ', number) - number, "nan");
    EXPECT_THAT(write(nan), HasSubstr("frame_0009.obj: vertex 2 is not at a finite place"));
}

TEST(MeshFile, ObjFacesAndParts) {
    const MeshFile mesh = parseObj(
        "# a comment\r\nmtllib none.mtl\nv 0 0 0\nv +1 0 0 1\n  v 1 1 0 0.5 0.5 0.5\nv 0 1 0\nvt 0 0\nvn 0 0 1\n"
        "o pane\nusemtl glass\nf 1/1/1 2//1 3/1 -1 # quad\nv 0 0 \\\n 1\ng frame\nf -1 \\\n1 2\n",
        "text");
    EXPECT_EQ(mesh.positions.size(), 5u);
    EXPECT_EQ(mesh.positions[4], (Vec3d{0, 0, 1}));
    EXPECT_THAT(mesh.triangles, ElementsAre(Triangle{0, 1, 2}, Triangle{0, 2, 3}, Triangle{4, 0, 1}));
    EXPECT_THAT(mesh.slots, ElementsAre("pane/glass", "frame/glass"));
    EXPECT_THAT(mesh.slot_of_vertex, ElementsAre(0, 0, 0, 0, 1));
    EXPECT_TRUE(parseObj("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3", "text").slots.empty());
}

// Three faces meet at one edge, and two of them run through it in the same direction. A half-edge mesh has no room
// for them.
TEST(MeshFile, FacesThatAreNoManifoldAreKept) {
    const MeshFile mesh = parseObj("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nv 0 -1 0\nf 1 2 3\nf 2 1 4\nf 1 2 5\n", "text");
    EXPECT_EQ(mesh.positions.size(), 5u);
    EXPECT_EQ(mesh.triangles.size(), 3u);
}

TEST(MeshFile, WrongObjNamesTheLine) {
    const std::string vertices = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
    const auto message = [](const std::string& text) {
        try {
            parseObj(text, "x.obj");
        } catch (const InvalidInput& error) {
            return std::string(error.what());
        }
        return std::string("was read");
    };
    EXPECT_EQ(message("v 0 0\n"), "x.obj: line 1: a vertex needs three numbers");
    EXPECT_EQ(message(vertices + "v 1 1 1x\n"), "x.obj: line 4: a vertex needs three numbers");
    EXPECT_EQ(message(vertices + "f 1 2\n"), "x.obj: line 4: a face needs three vertices");
    EXPECT_EQ(message(vertices + "f 1 2 4\n"), "x.obj: line 4: a face names vertex 4 of 3");
    EXPECT_EQ(message(vertices + "f 0 1 2\n"), "x.obj: line 4: a face names vertex 0 of 3");
    EXPECT_EQ(message(vertices + "f -4 1 2\n"), "x.obj: line 4: a face names vertex -4 of 3");
    EXPECT_EQ(message(vertices + "f 1 2 a\n"), "x.obj: line 4: 'a' is not a vertex of a face");
    EXPECT_EQ(message(vertices + "f 1 2 99999999999999999999\n"),
              "x.obj: line 4: '99999999999999999999' is not a vertex of a face");
    EXPECT_EQ(message("f 1 2 3\n" + vertices), "x.obj: line 1: a face names vertex 1 of 0");
    EXPECT_EQ(message("\n\n"), "x.obj: has no vertices");
}

// Other elements and properties stand around those that are read.
TEST(MeshFile, PlyWithOtherElements) {
    const MeshFile mesh = parsePly(
        "ply\r\nformat ascii 1.0\r\ncomment by hand\r\nelement note 2\r\nproperty list uchar int words\r\n"
        "element face 1\r\nproperty uchar red\r\nproperty list uchar uint vertex_index\r\nelement vertex 4\r\n"
        "property uchar red\r\nproperty double z\r\nproperty float x\r\nproperty float y\r\nend_header\r\n"
        "0\r\n2 5 6\r\n255 4 0 1 2 3\r\n9 3 1 2\r\n9 6 4 5\r\n9 9 7 8\r\n9 12 10 11\r\n",
        "text");
    EXPECT_THAT(mesh.positions, ElementsAre(Vec3d{1, 2, 3}, Vec3d{4, 5, 6}, Vec3d{7, 8, 9}, Vec3d{10, 11, 12}));
    EXPECT_THAT(mesh.triangles, ElementsAre(Triangle{0, 1, 2}, Triangle{0, 2, 3}));
}

TEST(MeshFile, WrongPlyIsRefused) {
    const std::string start = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n";
    const std::string whole = start +
                              "property float z\nelement face 1\nproperty list uchar int vertex_indices\n"
                              "end_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
    ASSERT_NO_THROW(parsePly(whole, "x.ply"));
    const auto message = [&](const std::string& from, const std::string& to) {
        std::string text = whole;
        text.replace(text.find(from), from.size(), to);
        try {
            parsePly(text, "x.ply");
        } catch (const InvalidInput& error) {
            return std::string(error.what());
        }
        return std::string("was read");
    };
    EXPECT_THAT(message("ply", "PLY"), HasSubstr("is not a PLY file"));
    EXPECT_THAT(message("ascii", "binary_middle_endian"), HasSubstr("unknown format"));
    EXPECT_THAT(message("format ascii 1.0\n", ""), HasSubstr("has no format"));
    EXPECT_THAT(message("float x", "half x"), HasSubstr("unknown type 'half'"));
    EXPECT_THAT(message("float x", "float u"), HasSubstr("needs one property x"));
    EXPECT_THAT(message("vertex 3", "vertex 4000000000"), HasSubstr("element vertex: the file is too short"));
    EXPECT_THAT(message("vertex 3", "vertex 99999999999999999999"), HasSubstr("element vertex: its number"));
    EXPECT_THAT(message("face 1", "face 2"), HasSubstr("face 1: the file is cut short"));
    EXPECT_THAT(message("3 0 1 2", "4000000000 0 1 2"), HasSubstr("face 0: a list is longer than the file"));
    EXPECT_THAT(message("3 0 1 2", "3 0 1 3"), HasSubstr("a face names vertex 3 of 3"));
    EXPECT_THAT(message("3 0 1 2", "3 0 1 -1"), HasSubstr("face 0: names a vertex that does not exist"));
    EXPECT_THAT(message("3 0 1 2", "2 0 1"), HasSubstr("face 0: needs three vertices"));
    EXPECT_THAT(message("1 0 0", "1 b 0"), HasSubstr("vertex 1: 'b' is not a number"));
}

TEST(MeshFile, EveryTruncationOfAPly) {
    for (const char* format : {"ascii", "binary_big_endian"}) {
        const std::string whole = sheetPly(3, format);
        // Without its line end, or with fewer digits of the last number, an ASCII file is still whole.
        for (std::size_t n = 0; n + 3 < whole.size(); ++n)
            EXPECT_THROW(parsePly(whole.substr(0, n), "x.ply"), InvalidInput) << n << " bytes of " << format;
    }
}

TEST(PointCacheBinary, MddHasTimesOfItsOwn) {
    const std::filesystem::path place = folder("mdd");
    writeText(place / "rest.obj", sheetObj(0));
    writeText(place / "sheet.mdd", sheetMdd());
    const PointCache cache = readPointCache({place / "sheet.mdd", place / "rest.obj"}, {});
    expectSheet(cache, kFloat);
    for (std::size_t f = 0; f < kSheetFrames; ++f) EXPECT_FLOAT_EQ(float(cache.clips[0].times[f]), float(1 + f) / 8);
    EXPECT_THAT(cache.files_read, ElementsAre(place / "sheet.mdd", place / "rest.obj"));
    EXPECT_DOUBLE_EQ(readPointCache({place / "sheet.mdd", place / "rest.obj"}, {.fps = 6}).clips[0].times[12], 2);
    EXPECT_EQ(sampleFrames(cache, {}, 4).frameCount(), 7u);
    EXPECT_THAT(refusal({place / "sheet.mdd"}), HasSubstr("sheet.mdd: has no faces, and no mesh comes with it"));
}

TEST(PointCacheBinary, Pc2HasAStartAndAStep) {
    const std::filesystem::path place = folder("pc2");
    writeText(place / "rest.ply", sheetPly(0, "binary_little_endian"));
    writeText(place / "sheet.pc2", sheetPc2(10, 0.5));
    const PointCache cache = readPointCache({place / "rest.ply", place / "sheet.pc2"}, {.fps = 25});
    expectSheet(cache, kFloat);
    for (std::size_t f = 0; f < kSheetFrames; ++f)
        EXPECT_DOUBLE_EQ(cache.clips[0].times[f], (10 + 0.5 * double(f)) / 25);
}

TEST(PointCacheBinary, WrongCachesAreRefused) {
    const std::filesystem::path place = folder("wrong");
    writeText(place / "rest.obj", sheetObj(0));
    writeText(place / "small.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    const auto said = [&](const std::string& name, std::string bytes, std::size_t offset, const std::string& change) {
        bytes.replace(offset, change.size(), change);
        writeText(place / name, bytes);
        return refusal({place / name, place / "rest.obj"});
    };
    const std::string mdd = sheetMdd(), pc2 = sheetPc2(0, 1);
    EXPECT_THAT(said("a.mdd", mdd, 0, std::string(4, '\0')), HasSubstr("a.mdd: says that it has 0 frames"));
    EXPECT_THAT(said("a.mdd", mdd, 4, std::string(4, '\xff')), HasSubstr("says that it has -1 vertices"));
    EXPECT_THAT(said("a.mdd", mdd, 7, "\x2e"), HasSubstr("bytes, and 13 frames of 46 vertices take"));
    EXPECT_THAT(said("a.mdd", mdd, 12, std::string(4, '\0')),
                HasSubstr("times are not finite and ascending at frame 1"));
    EXPECT_THAT(said("a.mdd", mdd, mdd.size() - 4, std::string("\x7f\xc0\0\0", 4)),
                HasSubstr("a.mdd: frame 12: vertex 44 is not at a finite place"));
    EXPECT_THAT(said("a.mdd", mdd + "x", 0, ""), HasSubstr("frames of 45 vertices take"));
    EXPECT_THAT(said("a.pc2", pc2, 0, "Q"), HasSubstr("is not a PC2 cache"));
    EXPECT_THAT(said("a.pc2", pc2, 24, std::string(4, '\0')), HasSubstr("its sample rate is not above 0"));
    EXPECT_THAT(said("a.pc2", pc2, 28, std::string("\0\0\1\0", 4)), HasSubstr("and 65536 frames of 45"));
    writeText(place / "good.pc2", pc2);
    EXPECT_THAT(refusal({place / "good.pc2", place / "small.obj"}), HasSubstr("small.obj: has 3 vertices, and "));
    for (std::size_t n = 0; n < 200; ++n) {
        writeText(place / "cut.pc2", pc2.substr(0, n));
        EXPECT_THROW(readPointCache({place / "cut.pc2", place / "rest.obj"}, {}), InvalidInput) << n;
        writeText(place / "cut.mdd", mdd.substr(0, n));
        EXPECT_THROW(readPointCache({place / "cut.mdd", place / "rest.obj"}, {}), InvalidInput) << n;
    }
}

std::filesystem::path morphSample() { return samples::samplePath("sheet_morph"); }

TEST(PointCacheGltf, MorphTargetsOfANodeThatIsTurned) {
    // The clip "lift" also moves the node, so that the file is a rig for whoever does not ask for a cache.
    EXPECT_FALSE(isPointCache(morphSample()));
    samples::EditableGlb alone = samples::EditableGlb::of("sheet_morph");
    alone.json["animations"][1]["channels"].erase(1);
    const std::filesystem::path flapping = std::filesystem::path(testing::TempDir()) / "penumbra_flapping.glb";
    writeText(flapping, alone.bytes());
    EXPECT_TRUE(isPointCache(flapping));
    EXPECT_FALSE(isPointCache(samples::samplePath("bend")));
    const PointCache cache = readPointCache({morphSample()}, {});
    ASSERT_EQ(cache.clips.size(), 2u);
    EXPECT_EQ(cache.clips[0].name, "flap");
    ASSERT_EQ(cache.clips[0].times.size(), kSheetFrames);
    EXPECT_EQ(cache.mesh.vertexCount(), samples::kSheetPoints);
    EXPECT_THAT(cache.mesh.slots, ElementsAre("sheet/default"));
    // Targets are differences of floats, scaled by 2.
    for (std::size_t f = 0; f < kSheetFrames; ++f)
        EXPECT_LE(samples::distanceToSheet(cache, readFrame(cache, 0, f), double(f)), 5e-7) << "frame " << f;
    EXPECT_LE(samples::distanceToSheet(cache, cache.mesh.rest_positions, 0), 5e-7);
}

// The keys of the sample show one target each. Whatever is not a play of frames in order is a rig with weights.
TEST(PointCacheGltf, IsOneWhereTargetsArePlayedInOrder) {
    constexpr std::size_t kTargets = kSheetFrames - 1;
    const auto isCacheWith = [](const std::vector<std::vector<float>>& keys, std::size_t targets) {
        samples::EditableGlb glb = samples::EditableGlb::of("sheet_morph");
        std::vector<float> times, weights;
        for (std::size_t k = 0; k < keys.size(); ++k) {
            times.push_back(float(k));
            weights.insert(weights.end(), keys[k].begin(), keys[k].begin() + std::ptrdiff_t(targets));
        }
        glb.json["meshes"][0]["primitives"][0]["targets"].get_ref<nlohmann::json::array_t&>().resize(targets);
        nlohmann::json clip = glb.json["animations"][0];
        samples::addAttribute(glb, "_TIMES", "SCALAR", 1, times);
        samples::addAttribute(glb, "_WEIGHTS", "SCALAR", 1, weights);
        clip["samplers"][0]["input"] = glb.attributes()["_TIMES"];
        clip["samplers"][0]["output"] = glb.attributes()["_WEIGHTS"];
        glb.attributes().erase("_TIMES");
        glb.attributes().erase("_WEIGHTS");
        glb.json["animations"] = nlohmann::json::array({clip});
        const std::filesystem::path path = std::filesystem::path(testing::TempDir()) / "played.glb";
        writeText(path, glb.bytes());
        return isPointCache(path);
    };
    const auto at = [](double place) {
        std::vector<float> weights(kTargets);
        for (std::size_t t = 0; t < kTargets; ++t)
            weights[t] = float(std::max(0.0, 1 - std::abs(place - double(t + 1))));
        return weights;
    };
    std::vector<std::vector<float>> between, twice;
    for (int half = 0; half <= 2 * int(kTargets); ++half) between.push_back(at(0.5 * half));
    for (int key = 0; key < 20; ++key) twice.push_back(at(std::min(key, 13) % 13 + std::max(0, key - 13)));
    EXPECT_TRUE(isCacheWith(between, kTargets));
    EXPECT_TRUE(isCacheWith(twice, kTargets));
    // Weights in bytes do not add up to one, so that places of frames far back are off by more than their steps.
    const auto inBytes = [](std::vector<float> weights) {
        for (float& w : weights) w = std::round(255 * w) / 255;
        return weights;
    };
    const double near_end = double(kTargets) - 0.5;
    EXPECT_TRUE(
        isCacheWith({at(0), inBytes(at(near_end)), inBytes(at(near_end + 0.02)), at(double(kTargets))}, kTargets));
    EXPECT_FALSE(isCacheWith(between, 7));
    EXPECT_FALSE(isCacheWith({between.begin(), between.end() - 2}, kTargets)) << "the last target is never shown";
    EXPECT_FALSE(isCacheWith({at(0), at(5), at(3), at(12)}, kTargets)) << "not in order";
    std::vector<float> mixed = at(6);
    mixed[1] = 0.5f;
    EXPECT_FALSE(isCacheWith({at(0), mixed, at(12)}, kTargets));
    std::vector<float> more = at(6);
    more[5] = 1.5f;
    EXPECT_FALSE(isCacheWith({at(0), more, at(12)}, kTargets));
}

// A flat cubic is at 5/32 after a quarter of the way: 3/16 - 2/64. The node is linear, so it is at 1/4.
TEST(PointCacheGltf, BetweenKeysAsTheFileSays) {
    const PointCache cache = readPointCache({morphSample()}, {});
    EXPECT_THAT(cache.clips[1].times, ElementsAre(0, 1));
    const std::vector<Vec3> quarter = samplePositions(cache, 1, 0.25);
    const std::vector<Vec3d> first = sheetFrame(0), last = sheetFrame(12);
    for (std::size_t v = 0; v < first.size(); ++v) {
        const Vec3d expected = first[v] + 5.0 / 32 * (last[v] - first[v]) + Vec3d{0, 0.25, 0};
        EXPECT_LE(length(toDouble(quarter[cache.mesh.source_vertex[v]]) - expected), 5e-7);
    }
    EXPECT_THROW(readPointCache({morphSample()}, {.fps = 24}), UsageError);
}

TEST(PointCacheGltf, WrongMorphsAreRefused) {
    const auto said = [](const std::function<void(samples::EditableGlb&)>& damage) {
        samples::EditableGlb glb = samples::EditableGlb::of("sheet_morph");
        damage(glb);
        const std::filesystem::path path = std::filesystem::path(testing::TempDir()) / "penumbra_morph.glb";
        writeText(path, glb.bytes());
        return refusal({path});
    };
    using Glb = samples::EditableGlb;
    EXPECT_THAT(said([](Glb& g) { g.json["meshes"][0]["primitives"][0]["targets"].erase(3); }),
                HasSubstr("the numbers of times and values do not fit"));
    EXPECT_THAT(said([](Glb& g) { g.json["meshes"][0]["weights"] = {1, 2}; }), HasSubstr("2 weights for 12 morph"));
    EXPECT_THAT(said([](Glb& g) {
                    auto& target = g.json["meshes"][0]["primitives"][0]["targets"][2]["POSITION"];
                    g.json["accessors"][target.get<std::size_t>()]["count"] = 44;
                }),
                HasSubstr("morph target 2"));
    EXPECT_THAT(said([](Glb& g) { g.json["meshes"][0]["primitives"][0].erase("targets"); }),
                HasSubstr("has no animation of morph targets"));
}

}  // namespace
}  // namespace penumbra::test_point_cache_formats
