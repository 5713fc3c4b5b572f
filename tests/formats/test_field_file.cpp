#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>

#include "formats/common/errors.h"
#include "formats/common/part_table.h"
#include "formats/stage/field_file.h"
#include "tests/formats/round_trip.h"
#include "tests/formats/stage_samples.h"

namespace penumbra::test_field_file {
namespace {

bool sameBoxes(const PartField& a, const PartField& b) {
    for (std::size_t i = 0; i < 2; ++i)
        if (a.boxes[i].low != b.boxes[i].low || a.boxes[i].high != b.boxes[i].high ||
            a.boxes[i].size != b.boxes[i].size)
            return false;
    return true;
}

TEST(FieldFile, RoundTripIsExactAndDeterministic) {
    const FieldFile fields = samples::fieldFile(), back = samples::roundTrip(fields, writeFields, readFields);
    EXPECT_EQ(back.joint_names, fields.joint_names);
    EXPECT_EQ(back.part_of_joint, fields.part_of_joint);
    EXPECT_EQ(back.steps, fields.steps);
    EXPECT_EQ(back.vertex_count, fields.vertex_count);
    EXPECT_EQ(back.mesh_sha256, fields.mesh_sha256);
    EXPECT_EQ(back.rays, fields.rays);
    EXPECT_EQ(back.fields.fade, fields.fields.fade);
    EXPECT_EQ(back.fields.values, fields.fields.values);
    EXPECT_EQ(back.fields.distances, fields.fields.distances);
    ASSERT_EQ(back.fields.parts.size(), fields.fields.parts.size());
    for (std::size_t p = 0; p < back.fields.parts.size(); ++p) {
        const PartField &a = back.fields.parts[p], &b = fields.fields.parts[p];
        EXPECT_TRUE(a.joint == b.joint && a.center == b.center && a.radius == b.radius && sameBoxes(a, b)) << p;
        EXPECT_TRUE(a.scale == b.scale && a.distance_scale == b.distance_scale) << p;
    }
    EXPECT_EQ(toJson(back.provenance), toJson(fields.provenance));
    EXPECT_EQ(back.partName(1), "Ellbogen-\xc3\xa4");
}

// A static object has one part and no joints.
TEST(FieldFile, AMeshWithoutJointsHasOnePart) {
    FieldFile fields = samples::fieldFile();
    fields.joint_names.clear();
    fields.part_of_joint.clear();
    fields.steps = {0};
    fields.fields.parts.resize(1);
    fields.fields.values.resize(1);
    fields.fields.distances.resize(1);
    const FieldFile back = samples::roundTrip(fields, writeFields, readFields);
    EXPECT_TRUE(back.joint_names.empty());
    EXPECT_EQ(back.partName(0), "");
}

// The second part alone, as --parts 1:2 makes it.
FieldFile shard() {
    FieldFile fields = samples::fieldFile();
    fields.shard = FieldShard{1, 2};
    fields.fields.parts.erase(fields.fields.parts.begin());
    fields.fields.values.erase(fields.fields.values.begin());
    fields.fields.distances.erase(fields.fields.distances.begin());
    return fields;
}

TEST(FieldFile, AShardIsNoWhole) {
    const samples::Folder folder("shard");
    const auto path = folder.path / "x.fields.h5";
    writeFields(path, shard());
    const FieldFile back = readFieldShard(path);
    ASSERT_TRUE(back.shard);
    EXPECT_EQ(back.shard->first_part, 1u);
    EXPECT_EQ(back.partCount(), 2u);
    EXPECT_THROW(readFields(path), InvalidInput);
}

// Each file is wrong in one field, which the message names.
TEST(FieldFile, WrongFilesAreRefused) {
    struct Case {
        const char* field;
        std::function<void(FieldFile&)> damage;
    };
    using F = FieldFile;
    const std::vector<Case> cases = {
        {"/parts/joint", [](F& f) { f.fields.parts[1].joint = 3; }},
        {"/parts/joint", [](F& f) { f.fields.parts[0].joint = 1; }},
        {"/parts/radius", [](F& f) { f.fields.parts[1].radius = 0; }},
        {"/parts/radius", [](F& f) { f.fields.parts[0].radius = -1; }},
        {"/parts/radius", [](F& f) { f.fields.parts[0].radius = 1e30f; }},
        {"/parts/centre", [](F& f) { f.fields.parts[0].center.y = -1e30f; }},
        {"/parts/box_high", [](F& f) { f.fields.parts[0].boxes[1].high.z = -2; }},
        {"/parts/box_high", [](F& f) { f.fields.parts[1].boxes[0].high.x = -0.5f; }},
        {"/parts/box_low", [](F& f) { f.fields.parts[1].boxes[0].low.x = -1e38f; }},
        {"/parts/box_size", [](F& f) { f.fields.parts[1].boxes[0].size[1] = 1; }},
        {"/parts/box_size", [](F& f) { f.fields.parts[1].boxes[0].size[1] = kMaxFieldPoints + 1; }},
        {"/fields/values",
         [](F& f) {
             f.fields.parts[1].boxes[0].size = {1024, 1024, 1024};
         }},
        {"/fields/values", [](F& f) { f.fields.parts[1].boxes[1].size[2] = 3; }},
        {"/fields/values", [](F& f) { f.fields.values[0][5] = -128; }},
        {"/fields/distances", [](F& f) { f.fields.distances[0].pop_back(); }},
        {"/parts/scale", [](F& f) { f.fields.parts[1].scale[2][3] = -1e-3f; }},
        {"/parts/distance_scale", [](F& f) { f.fields.parts[0].distance_scale = -1e-3f; }},
        {"/skin/joint_names", [](F& f) { f.joint_names[1] = "root"; }},
        {"/skin/part_of_joint", [](F& f) { f.part_of_joint[2] = 2; }},
        {"/skin/part_of_joint", [](F& f) { f.part_of_joint[1] = 0; }},
        {"fade", [](F& f) { f.fields.fade = 0; }},
        {"rays", [](F& f) { f.rays = 0; }},
        {"vertex_count", [](F& f) { f.vertex_count = 0; }},
        {"mesh_sha256", [](F& f) { f.mesh_sha256 = "b"; }},
        {"mesh_sha256", [](F& f) { f.mesh_sha256[5] = 'B'; }},
    };
    const samples::Folder folder("wrong_fields");
    const auto path = folder.path / "x.fields.h5";
    for (const Case& c : cases) {
        FieldFile fields = samples::fieldFile();
        c.damage(fields);
        writeFields(path, fields);
        try {
            readFields(path);
            ADD_FAILURE() << c.field << " was accepted";
        } catch (const InvalidInput& error) {
            EXPECT_THAT(error.what(), testing::HasSubstr("x.fields.h5: ")) << c.field;
            EXPECT_THAT(error.what(), testing::HasSubstr(c.field));
        }
    }
}

TEST(FieldFile, AShardBeyondTheWholeIsRefused) {
    const samples::Folder folder("beyond");
    FieldFile fields = shard();
    fields.shard->first_part = 2;
    writeFields(folder.path / "x.fields.h5", fields);
    EXPECT_THROW(readFieldShard(folder.path / "x.fields.h5"), InvalidInput);
}

// A bake with --two-sided stores backs, which the fields know nothing of.
TEST(FieldFile, AMeshWithBacksHasTheHashOfItsFronts) {
    const Mesh mesh = samples::visibilityHeader(1, 2).mesh;
    EXPECT_EQ(meshSha256(withBacks(mesh)), meshSha256(mesh));
    Mesh moved = mesh;
    moved.rest_positions[0].x += 1;
    EXPECT_NE(meshSha256(moved), meshSha256(mesh));
}

}  // namespace
}  // namespace penumbra::test_field_file
