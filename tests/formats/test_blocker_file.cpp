#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>

#include "formats/common/errors.h"
#include "formats/stage/blocker_file.h"
#include "formats/stage/hdf5_handle.h"
#include "tests/formats/round_trip.h"
#include "tests/formats/stage_samples.h"

namespace penumbra::test_blocker_file {
namespace {

TEST(BlockerFile, RoundTripIsExactAndDeterministic) {
    const BlockerFile file = samples::blockerFile(), back = samples::roundTrip(file, writeBlockers, readBlockers);
    EXPECT_EQ(back.joint_names, file.joint_names);
    EXPECT_EQ(back.mesh_sha256, file.mesh_sha256);
    EXPECT_EQ(back.skin_sha256, file.skin_sha256);
    EXPECT_EQ(back.blockers.spheres, file.blockers.spheres);
    EXPECT_EQ(back.blockers.joints, file.blockers.joints);
    EXPECT_EQ(back.method, file.method);
    EXPECT_EQ(back.scale, file.scale);
    EXPECT_EQ(back.mesh_area, file.mesh_area);
    EXPECT_EQ(back.area, file.area);
    EXPECT_EQ(toJson(back.provenance), toJson(file.provenance));
}

std::string refusalAfter(const std::function<void(BlockerFile&)>& damage) {
    const samples::Folder folder("wrong_blockers");
    const auto path = folder.path / "x.blockers.h5";
    BlockerFile file = samples::blockerFile();
    damage(file);
    writeBlockers(path, file);
    try {
        readBlockers(path);
    } catch (const InvalidInput& error) {
        return error.what();
    }
    return "accepted";
}

// Each file is wrong in one field, which the message names.
TEST(BlockerFile, WrongFilesAreRefused) {
    struct Case {
        const char* field;
        std::function<void(BlockerFile&)> damage;
    };
    using B = BlockerFile;
    const std::vector<Case> cases = {
        {"/blockers/joint", [](B& b) { b.blockers.joints[2] = 2; }},
        {"/blockers/joint", [](B& b) { b.blockers = {}; }},
        {"/blockers/joint",
         [](B& b) {
             b.blockers.spheres.resize(kMaxBlockers + 1, b.blockers.spheres[0]);
             b.blockers.joints.resize(kMaxBlockers + 1);
         }},
        {"/blockers/radius", [](B& b) { b.blockers.spheres[1].radius = 0; }},
        {"/blockers/radius", [](B& b) { b.blockers.spheres[1].radius = -0.5f; }},
        {"/blockers/radius", [](B& b) { b.blockers.spheres[0].radius = 1e30f; }},
        {"/blockers/center", [](B& b) { b.blockers.spheres[2].center.z = -1e30f; }},
        {"/skin/joint_names", [](B& b) { b.joint_names[1] = "root"; }},
        {"mesh_sha256", [](B& b) { b.mesh_sha256 = "b"; }},
        {"skin_sha256", [](B& b) { b.skin_sha256[5] = 'C'; }},
        {"scale", [](B& b) { b.scale = 0; }},
        {"mesh_area", [](B& b) { b.mesh_area = -1; }},
        {"area", [](B& b) { b.area = 0; }},
    };
    for (const Case& c : cases) {
        const std::string refusal = refusalAfter(c.damage);
        EXPECT_THAT(refusal, testing::HasSubstr("x.blockers.h5: "));
        EXPECT_THAT(refusal, testing::HasSubstr(c.field));
        EXPECT_EQ(refusal.find('\n'), std::string::npos);
    }
}

// Files that h5py writes may hold what our writer refuses.
TEST(BlockerFile, NumbersThatAreNotFiniteAreRefused) {
    const samples::Folder folder("nan_blockers");
    const auto path = folder.path / "x.blockers.h5";
    for (const float bad : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
        writeBlockers(path, samples::blockerFile());
        {
            const Hdf5Handle file(H5Fopen(path.c_str(), H5F_ACC_RDWR, H5P_DEFAULT), H5Fclose, "open");
            const Hdf5Handle radius(H5Dopen(file, "/blockers/radius", H5P_DEFAULT), H5Dclose, "radius");
            const std::array<float, 3> values{1, bad, 1};
            checkHdf5(H5Dwrite(radius, H5T_NATIVE_FLOAT, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()), "write");
        }
        try {
            readBlockers(path);
            ADD_FAILURE() << bad << " was accepted";
        } catch (const InvalidInput& error) {
            EXPECT_THAT(error.what(), testing::HasSubstr("/blockers/radius"));
        }
    }
}

TEST(BlockerFile, BelongsToOneCharacter) {
    const VisibilityHeader header = samples::visibilityHeader(1, 2);
    BlockerFile file = samples::blockerFile();
    EXPECT_THROW(checkCharacter(file, header.mesh, *header.skin), InvalidInput);
    setCharacter(header.mesh, *header.skin, file);
    EXPECT_NO_THROW(checkCharacter(file, header.mesh, *header.skin));
    EXPECT_NO_THROW(checkCharacter(file, withBacks(header.mesh), withBacks(*header.skin)));  // baked with --two-sided
    Mesh moved = header.mesh;
    moved.rest_positions[0].x += 1;
    EXPECT_THROW(checkCharacter(file, moved, *header.skin), InvalidInput);
    Skin skin = *header.skin;
    skin.joint_names.back() += "2";
    EXPECT_THROW(checkCharacter(file, header.mesh, skin), InvalidInput);
    skin = *header.skin;
    skin.weights[0] *= 0.5f;
    EXPECT_THROW(checkCharacter(file, header.mesh, skin), InvalidInput);
}

TEST(CasterSphere, MovesAndScalesWithItsBone) {
    const CasterSphere sphere{{1, 2, 3}, 0.5f};
    EXPECT_EQ(movedBy(Affine{}, sphere), sphere);
    const CasterSphere moved = movedBy(Affine{{0, -2, 0, 10, 2, 0, 0, 20, 0, 0, -2, 30}}, sphere);
    EXPECT_EQ(moved.center, (Vec3{6, 22, 24}));
    EXPECT_FLOAT_EQ(moved.radius, 1);
    // the scale is the cubic root of the volume's scale
    EXPECT_FLOAT_EQ(movedBy(Affine{{8, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}}, sphere).radius, 1);
}

}  // namespace
}  // namespace penumbra::test_blocker_file
