// An FBX file is scanned for what its readers get wrong, whatever way it is written, and damage is named.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <random>

#include "formats/common/errors.h"
#include "formats/rig/fbx/fbx_faults.h"
#include "formats/rig/fbx/fbx_takes.h"
#include "formats/rig/rig_build.h"
#include "tests/formats/fbx_samples.h"

namespace penumbra::test_fbx_scan {
namespace {

using samples::FbxRig;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

FbxScan scanText(const std::string& bytes) { return scanOf(parseFbxTree(bytes, "a.fbx"), "a.fbx"); }
FbxScan scanRig(const FbxRig& rig) { return scanText(samples::asciiFile(rig.root)); }

TEST(FbxScan, SameOfEveryWayToWriteAFile) {
    FbxRig rig = samples::turningRig(8);
    rig.setProperty("Model", FbxRig::kArm, FbxRig::property("Lcl Scaling", {1.0, 2.0, 1.0}));
    std::vector<FbxScan> scans = {scanRig(rig)};
    for (const std::uint32_t version : {7400u, 7500u})
        for (const bool deflated : {false, true})
            scans.push_back(scanText(samples::binaryFile(rig.root, version, deflated)));
    for (const FbxScan& scan : scans) {
        ASSERT_EQ(scan.models.size(), 3u);
        EXPECT_EQ(scan.models[2].name, "arm");
        EXPECT_EQ(scan.models[2].kind, "LimbNode");
        EXPECT_EQ(scan.models[2].parent, 1);
        EXPECT_EQ(scan.models[2].inherit, 1);
        EXPECT_EQ(scan.models[2].scale[1], 2);
        EXPECT_EQ(scan.time_mode, 6);
        ASSERT_EQ(scan.geometries.size(), 1u);
        EXPECT_EQ(scan.geometries[0].vertices, 18u);
        ASSERT_EQ(scan.geometries[0].skins.size(), 1u);
        ASSERT_EQ(scan.geometries[0].skins[0].clusters.size(), 2u);
        EXPECT_EQ(scan.geometries[0].skins[0].clusters[1].model, 2);
        EXPECT_THAT(scan.geometries[0].skins[0].clusters[1].vertices, ElementsAre(12, 13, 14, 15, 16, 17));
        ASSERT_EQ(scan.takes.size(), 1u);
        EXPECT_EQ(scan.takes[0].name, "turn");
        EXPECT_EQ(scan.takes[0].stop, 1);
        ASSERT_EQ(scan.tracks.size(), 1u);
        ASSERT_TRUE(scan.tracks[0].curves[2].has_value());
        EXPECT_THAT(scan.tracks[0].curves[2]->times, ElementsAre(0, 1));
        EXPECT_THAT(scan.tracks[0].curves[2]->values, ElementsAre(0, 90));
        EXPECT_THAT(scan.tracks[0].curves[2]->flags, ElementsAre(8, 8));
        EXPECT_THAT(assimpFaults(scan),
                    ElementsAre(HasSubstr("node 'arm': the curves of Lcl Rotation are not linear")));
        EXPECT_THAT(converterFaults(scan), IsEmpty());
        EXPECT_TRUE(hasVisibleMesh(scan));
        EXPECT_TRUE(hasKeys(scan, 0));
    }
    EXPECT_EQ(scans[0].version, 7400);
    EXPECT_EQ(scans.back().version, 7500);
}

TEST(FbxScan, EveryTruncationIsNoticed) {
    const FbxRig rig = samples::turningRig();
    for (const std::string& whole : {samples::binaryFile(rig.root, 7400, true),
                                     samples::binaryFile(rig.root, 7500, false), samples::asciiFile(rig.root)}) {
        ASSERT_NO_THROW(scanText(whole));
        const std::size_t end = whole.find_last_not_of('\n');
        for (std::size_t n = 0; n < end; n += n < 300 || n > end - 300 ? 1 : 7) {
            const std::string cut(whole.data(), n);  // a copy: sanitizers see what is read behind it
            EXPECT_THROW(scanText(cut), InvalidInput) << "first " << n << " of " << whole.size() << " bytes";
        }
    }
}

TEST(FbxScan, DamageIsRefusedOrHarmless) {
    const FbxRig rig = samples::turningRig();
    std::mt19937 random(3);
    int refused = 0;
    for (const std::string& whole : {samples::binaryFile(rig.root, 7400, true),
                                     samples::binaryFile(rig.root, 7500, false), samples::asciiFile(rig.root)})
        for (int i = 0; i < 1500; ++i) {
            std::string bytes = whole;
            for (unsigned k = 0; k < 1 + random() % 4; ++k) bytes[random() % bytes.size()] = char(random());
            try {
                const FbxScan scan = scanText(bytes);
                assimpFaults(scan);
                converterFaults(scan);
                fbxNotes(scan);
                converterNotes(scan);
            } catch (const InvalidInput&) {
                ++refused;
            }
        }
    EXPECT_GT(refused, 500);
}

// Readers of FBX leave out such a mesh, or such a polygon.
TEST(FbxScan, DamagedPolygonsAreRefused) {
    const std::string whole = samples::asciiFile(samples::turningRig().root);
    const auto refusal = [&](const std::string& array, const std::function<std::string(std::string)>& change) {
        const std::size_t first = whole.find("a: ", whole.find(array + ": *")) + 3;
        const std::size_t end = whole.find_first_of(" \r\n}", first);
        std::string bytes = whole;
        bytes.replace(first, end - first, change(whole.substr(first, end - first)));
        try {
            scanText(bytes);
        } catch (const InvalidInput& error) {
            return std::string(error.what());
        }
        return std::string("it was read");
    };
    const auto withFirst = [](const std::string& number) {
        return [=](const std::string& list) { return number + list.substr(list.find(',')); };
    };
    EXPECT_EQ(refusal("PolygonVertexIndex", withFirst("17")), "it was read");
    EXPECT_THAT(refusal("PolygonVertexIndex", withFirst("18")), HasSubstr("PolygonVertexIndex: vertex 18 of 18"));
    EXPECT_THAT(refusal("PolygonVertexIndex", withFirst("-19")), HasSubstr("PolygonVertexIndex: vertex 18 of 18"));
    EXPECT_THAT(
        refusal("PolygonVertexIndex", [](const std::string& list) { return list.substr(0, list.rfind(',')) + ",0"; }),
        HasSubstr("its last polygon does not end"));
}

// --- Faults ---------------------------------------------------------------------------------------------------------

struct Case {
    const char* name;
    std::function<void(FbxRig&)> change;
    const char *assimp, *converter;  // text of the expected faults; "": there is none
    std::int64_t flag = 4;
};

void setScale(FbxRig& rig, std::int64_t inherit) {
    rig.setProperty("Model", FbxRig::kRoot, FbxRig::property("Lcl Scaling", {1.0, 2.0, 1.0}));
    for (samples::FbxSample& p : rig.object("Model", FbxRig::kArm).children[0].children)
        if (std::get<std::string>(p.values[0]) == "InheritType") p.values[4] = inherit;
}

void addShapes(FbxRig& rig, const samples::FbxNumbers& full_weights, int shapes) {
    rig.section("Objects").add(
        {"Deformer", {std::int64_t(500), std::string("Deformer::b"), std::string("BlendShape")}, {}});
    rig.section("Objects").add(
        {"Deformer",
         {std::int64_t(501), std::string("SubDeformer::smile"), std::string("BlendShapeChannel")},
         {{"DeformPercent", {50.0}, {}}, {"FullWeights", {full_weights}, {}}}});
    rig.link(500, FbxRig::kGeometry);
    rig.link(501, 500);
    for (int s = 0; s < shapes; ++s) {
        rig.section("Objects").add(
            {"Geometry", {std::int64_t(510 + s), std::string("Geometry::s"), std::string("Shape")}, {}});
        rig.link(510 + s, 501);
    }
}

const samples::FbxNumbers kEnds{0, 1}, kStill{0, 0};

const Case kCases[] = {
    {"linear", [](FbxRig&) {}, "", ""},
    {"steps", [](FbxRig&) {}, "are not linear", "", 2},
    {"pivot",
     [](FbxRig& rig) {
         rig.setProperty("Model", FbxRig::kArm, FbxRig::property("RotationPivot", {20.0, 0.0, 0.0}));
     },
     "turns about a pivot", ""},
    {"layers",
     [](FbxRig& rig) {
         rig.layer(402, FbxRig::kTake);
         rig.curves(402, FbxRig::kArm, "Lcl Rotation", {{}, {}, {kEnds, {30, 30}}});
     },
     "has several layers", ""},
    {"layers about several axes",
     [](FbxRig& rig) {
         rig.layer(402, FbxRig::kTake);
         rig.curves(402, FbxRig::kArm, "Lcl Rotation", {{kEnds, {30, 30}}});
     },
     "has several layers", "its layers accumulate turns about several axes"},
    {"layers about several axes, angle by angle",
     [](FbxRig& rig) {
         rig.layer(402, FbxRig::kTake);
         rig.setProperty("AnimationLayer", 402, FbxRig::property("RotationAccumulationMode", {std::int64_t(1)}));
         rig.curves(402, FbxRig::kArm, "Lcl Rotation", {{kEnds, {30, 30}}});
     },
     "has several layers", ""},
    {"z alone behind x",
     [](FbxRig& rig) {
         rig.curves(FbxRig::kLayer, FbxRig::kRoot, "Lcl Translation", {{kEnds, kStill}, {}, {{0, 1, 2}, {0, 10, 20}}});
         rig.setProperty("AnimationStack", FbxRig::kTake, FbxRig::property("LocalStart", {std::int64_t(0)}));
         for (samples::FbxSample& p : rig.object("AnimationStack", FbxRig::kTake).children[0].children)
             if (std::get<std::string>(p.values[0]) == "LocalStop") p.values[4] = std::int64_t(2 * FbxRig::kTicks);
     },
     "", "is not keyed on all axes over its take: bake the animation on export"},
    {"a part of the keys",
     [](FbxRig& rig) {
         rig.curves(FbxRig::kLayer, FbxRig::kRoot, "Lcl Translation", {{{0, 1, 2}, {0, 10, 20}}});
     },
     "is a part of its keys", ""},
    {"segment scale compensation", [](FbxRig& rig) { setScale(rig, 2); },
     "node 'arm' does not inherit the scale of 'root'",
     "node 'arm' does not inherit the scale of 'root' (segment scale compensation): turn that off"},
    {"scale that is inherited", [](FbxRig& rig) { setScale(rig, 1); }, "", ""},
    {"same names", [](FbxRig& rig) { rig.model(250, "arm", "Null", 0); }, "bone 'arm' has the name of another node",
     ""},
    {"geometric transform",
     [](FbxRig& rig) {
         rig.setProperty("Model", FbxRig::kMesh, FbxRig::property("GeometricTranslation", {1.0, 0.0, 0.0}));
     },
     "node 'body' has a geometric transform and a skin", ""},
    {"shapes", [](FbxRig& rig) { addShapes(rig, {100}, 1); }, "mesh 'body' has blend shapes", ""},
    {"in-betweens",
     [](FbxRig& rig) {
         addShapes(rig, {50, 100}, 2);
     },
     "has blend shapes", "shape 'smile' has in-betweens"},
    {"vertex group",
     [](FbxRig& rig) {
         addShapes(rig, {100, 20}, 1);
     },
     "has blend shapes", "shape 'smile' is limited to a vertex group"},
    {"audio",
     [](FbxRig& rig) {
         rig.section("Objects").add(
             {"Audio", {std::int64_t(600), std::string("Audio::song"), std::string("Clip")}, {}});
     },
     "", "export without audio"},
    {"ticks of FBX 2020",
     [](FbxRig& rig) {
         rig.section("FBXHeaderExtension").add({"OtherFlags", {}, {{"TCDefinition", {std::int64_t(0)}, {}}}});
     },
     "", "TCDefinition"},
    {"extrapolation",
     [](FbxRig& rig) {
         for (samples::FbxSample& node : rig.section("Objects").children)
             if (node.name == "AnimationCurve")
                 node.add({"Post-Extrapolation", {}, {{"Type", {std::int64_t('R')}, {}}}});
         for (samples::FbxSample& p : rig.object("AnimationStack", FbxRig::kTake).children[0].children)
             if (std::get<std::string>(p.values[0]) == "LocalStop") p.values[4] = std::int64_t(2 * FbxRig::kTicks);
     },
     "go on behind their keys", "its curves go on behind their keys: bake the animation on export"},
    {"instances",
     [](FbxRig& rig) {
         rig.model(260, "twin", "Mesh", 0);
         rig.link(FbxRig::kGeometry, 260);
         rig.setProperty("Model", 260, FbxRig::property("GeometricTranslation", {1.0, 0.0, 0.0}));
     },
     "has a geometric transform and a skin", "is drawn with several geometric transforms"},
};

TEST(FbxFaults, AreNamedForEachReader) {
    for (const Case& test : kCases) {
        FbxRig rig = samples::turningRig(test.flag);
        test.change(rig);
        for (const std::string& bytes : {samples::asciiFile(rig.root), samples::binaryFile(rig.root, 7400, true)}) {
            const FbxScan scan = scanText(bytes);
            for (const auto& [faults, said] :
                 {std::pair(assimpFaults(scan), test.assimp), std::pair(converterFaults(scan), test.converter)}) {
                if (*said == '\0')
                    EXPECT_THAT(faults, IsEmpty()) << test.name;
                else
                    EXPECT_THAT(faults, Contains(HasSubstr(said))) << test.name;
            }
        }
    }
}

TEST(FbxFaults, CutWeightsAreCounted) {
    FbxRig rig = samples::turningRig();
    for (std::int64_t k = 0; k < 4; ++k) rig.cluster(320 + k, FbxRig::kRoot, {12, 13}, {0.25, k == 0 ? 1.0 : 0.0}, 0);
    EXPECT_FALSE(hasOtherRate(scanRig(rig)));
    const std::vector<FbxCutWeights> cuts = cutWeights(scanRig(rig));
    ASSERT_EQ(cuts.size(), 1u);  // vertex 12: 1 and four times 0.25
    EXPECT_EQ(cuts[0].vertices, 1u);
    EXPECT_DOUBLE_EQ(cuts[0].most, 0.125);
    EXPECT_THAT(textOf(converterNotes(scanRig(rig)).at(0)),
                HasSubstr("1 vertices keep the 4 largest, and lose up to 12.5% of their weight"));
}

TEST(FbxFaults, FramesBetweenThoseOfTheConverterAreSaid) {
    FbxScan scan = scanRig(samples::turningRig());
    EXPECT_TRUE(converterNotes(scan).empty());
    scan.time_mode = 10;  // 25 a second
    ASSERT_EQ(converterNotes(scan).size(), 1u);
    EXPECT_EQ(converterNotes(scan)[0].feature, "frame rate");
}

// --- Clips ----------------------------------------------------------------------------------------------------------

TEST(FbxTakes, ClipsAreTheirPartOfTheKeys) {
    FbxRig rig;
    const samples::FbxNumbers times{0.5, 1, 2, 3};
    rig.curves(FbxRig::kLayer, FbxRig::kArm, "Lcl Rotation", {{times, {0, 1, 2, 3}}});
    rig.take(410, "late", 1, 2.5);
    rig.curves(411, FbxRig::kArm, "Lcl Rotation", {{times, {0, 1, 2, 3}}});
    rig.take(420, "nonsense", 7, 7);
    rig.curves(421, FbxRig::kArm, "Lcl Rotation", {{times, {0, 1, 2, 3}}});
    const FbxScan scan = scanRig(rig);
    ASSERT_EQ(scan.takes.size(), 3u);
    const auto span = [&](int take) { return std::pair(spanOfClip(scan, take)->first, spanOfClip(scan, take)->last); };
    EXPECT_EQ(span(0), std::pair(0.5, 1.0));  // the take lasts from 0 to 1 s, and the keys begin at 0.5 s
    EXPECT_EQ(span(1), std::pair(1.0, 2.5));
    EXPECT_EQ(span(2), std::pair(0.5, 3.0));
}

TEST(FbxTakes, CutsInterpolateTheirEnds) {
    RigSource source;
    source.clips.resize(1);
    const float half = std::sqrt(0.5f);
    source.clips[0].channels = {
        {0, Channel::Path::kTranslation, Interpolation::kLinear, {0, 1, 2, 4}, {0, 0, 0, 1, 0, 0, 2, 0, 0, 8, 0, 0}},
        {0, Channel::Path::kRotation, Interpolation::kLinear, {0, 4}, {0, 0, 0, 1, 0, 0, half, half}},
        {0, Channel::Path::kScale, Interpolation::kLinear, {1}, {5, 6, 7}}};
    cutClip(source, 0, 0.5, 3);
    const Clip& clip = source.clips[0];
    EXPECT_EQ(clip.duration, 2.5);
    EXPECT_THAT(clip.channels[0].times, ElementsAre(0, 0.5, 1.5, 2.5));
    EXPECT_THAT(clip.channels[0].values, ElementsAre(0.5, 0, 0, 1, 0, 0, 2, 0, 0, 5, 0, 0));
    EXPECT_THAT(clip.channels[1].times, ElementsAre(0, 2.5));
    const double first = std::numbers::pi / 4 / 8, last = first * 6;  // halves of 90 degrees / 8 and 6/8
    EXPECT_NEAR(clip.channels[1].values[2], std::sin(first), 1e-6);
    EXPECT_NEAR(clip.channels[1].values[6], std::sin(last), 1e-6);
    EXPECT_THAT(clip.channels[2].times, ElementsAre(0, 0.5, 2.5));
    EXPECT_THAT(clip.channels[2].values, ElementsAre(5, 6, 7, 5, 6, 7, 5, 6, 7));
}

}  // namespace
}  // namespace penumbra::test_fbx_scan
