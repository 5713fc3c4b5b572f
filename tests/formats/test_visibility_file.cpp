#include <gtest/gtest.h>

#include <algorithm>

#include "formats/common/errors.h"
#include "formats/common/fp16.h"
#include "formats/stage/hdf5_handle.h"
#include "formats/stage/visibility_check.h"
#include "tests/formats/stage_samples.h"

namespace penumbra::test_visibility_file {
namespace {

void expectSame(const VisibilityHeader& a, const VisibilityHeader& b) {
    EXPECT_EQ(a.order, b.order);
    EXPECT_EQ(a.quantity, b.quantity);
    EXPECT_EQ(a.rays, b.rays);
    EXPECT_EQ(a.seed, b.seed);
    EXPECT_EQ(a.bounces, b.bounces);
    EXPECT_EQ(a.colors, b.colors);
    EXPECT_EQ(a.ground_y, b.ground_y);
    EXPECT_EQ(a.distance, b.distance);
    EXPECT_EQ(a.local, b.local);
    EXPECT_EQ(a.mesh.triangles, b.mesh.triangles);
    EXPECT_EQ(a.mesh.rest_positions, b.mesh.rest_positions);
    EXPECT_EQ(a.mesh.source_vertex, b.mesh.source_vertex);
    EXPECT_EQ(a.mesh.slots, b.mesh.slots);
    EXPECT_EQ(a.mesh.slot_of_vertex, b.mesh.slot_of_vertex);
    EXPECT_EQ(a.mesh.two_sided, b.mesh.two_sided);
    EXPECT_EQ(a.rest_normals, b.rest_normals);
    EXPECT_EQ(a.edges, b.edges);
    EXPECT_EQ(a.input_names, b.input_names);
    EXPECT_EQ(a.frames.clip_names, b.frames.clip_names);
    EXPECT_EQ(a.frames.clip, b.frames.clip);
    EXPECT_EQ(a.frames.time, b.frames.time);
    ASSERT_EQ(a.shard.has_value(), b.shard.has_value());
    if (a.shard) {
        EXPECT_EQ(a.shard->clip_names, b.shard->clip_names);
        EXPECT_EQ(a.shard->clip_frames, b.shard->clip_frames);
        EXPECT_EQ(a.shard->frame_in_clip, b.shard->frame_in_clip);
    }
    EXPECT_EQ(a.pose_size, b.pose_size);
    EXPECT_EQ(a.pose_parameterisation, b.pose_parameterisation);
    EXPECT_EQ(toJson(a.provenance), toJson(b.provenance));
    ASSERT_EQ(a.skin.has_value(), b.skin.has_value());
    if (!a.skin) return;
    EXPECT_EQ(a.skin->joint_names, b.skin->joint_names);
    EXPECT_EQ(a.skin->parents, b.skin->parents);
    EXPECT_EQ(a.skin->joints, b.skin->joints);
    EXPECT_EQ(a.skin->weights, b.skin->weights);
    EXPECT_EQ(a.skin->rest_transforms, b.skin->rest_transforms);
    EXPECT_EQ(a.skin->inverse_bind, b.skin->inverse_bind);
}

void expectSame(const VisibilityFrame& a, const VisibilityFrame& b) {
    EXPECT_EQ(a.positions, b.positions);
    EXPECT_EQ(a.normals, b.normals);
    EXPECT_EQ(a.bones, b.bones);
    EXPECT_EQ(a.pose, b.pose);
    EXPECT_EQ(a.coefficients, b.coefficients);
    EXPECT_EQ(a.local_coefficients, b.local_coefficients);
    EXPECT_EQ(a.indirect, b.indirect);
    EXPECT_EQ(a.hit_shares, b.hit_shares);
}

// Reads the file at `path` and writes all of it again, which must give the same bytes.
void expectSameBytesAgain(const std::filesystem::path& path, Precision precision) {
    const std::filesystem::path other = path.parent_path() / "again";
    const VisibilityReader reader(path);
    VisibilityWriter writer(other, reader.header(), precision);
    for (std::size_t f = 0; f < reader.header().frames.time.size(); ++f) writer.writeFrame(reader.readFrame(f));
    writer.finish();
    EXPECT_TRUE(samples::bytesOf(path) == samples::bytesOf(other)) << "what was read is written otherwise";
}

// 150 frames and 202 vertices are two whole blocks of frames and a rest, and four columns of chunks.
TEST(VisibilityFile, RoundTripInFloat32) {
    const samples::Folder folder("vis_f32");
    const VisibilityHeader header = samples::visibilityHeader(100, 150);
    samples::writeVisibility(folder.path / "x.vis.h5", header, Precision::kFloat32);
    EXPECT_EQ(folder.entries(), 1u);
    const VisibilityReader reader(folder.path / "x.vis.h5");
    expectSame(reader.header(), header);
    for (std::size_t f : {0u, 63u, 64u, 149u}) expectSame(reader.readFrame(f), samples::visibilityFrame(header, f));
    EXPECT_TRUE(reader.readPose(5).coefficients.empty());
    EXPECT_EQ(reader.readPose(5).pose, samples::visibilityFrame(header, 5).pose);
    expectSameBytesAgain(folder.path / "x.vis.h5", Precision::kFloat32);
}

TEST(VisibilityFile, KeepsLocalMoments) {
    const samples::Folder folder("vis_local");
    const VisibilityHeader header = samples::localHeader(100, 70);
    for (Precision precision : {Precision::kFloat32, Precision::kFloat16}) {
        samples::writeVisibility(folder.path / "x.vis.h5", header, precision);
        const VisibilityReader reader(folder.path / "x.vis.h5");
        expectSame(reader.header(), header);
        VisibilityFrame expected = samples::visibilityFrame(header, 65);
        if (precision == Precision::kFloat16)
            for (std::vector<float>* numbers : {&expected.coefficients, &expected.local_coefficients})
                for (float& c : *numbers) c = halfToFloat(floatToHalf(c));
        expectSame(reader.readFrame(65), expected);
        EXPECT_TRUE(reader.readPose(65).local_coefficients.empty());
        expectSameBytesAgain(folder.path / "x.vis.h5", precision);
    }
}

TEST(VisibilityFile, ReadsLocalMomentsOverAllFrames) {
    const samples::Folder folder("vis_local_vertices");
    const VisibilityHeader header = samples::localHeader(100, 70);
    samples::writeVisibility(folder.path / "x.vis.h5", header, Precision::kFloat32);
    const VisibilityReader reader(folder.path / "x.vis.h5");
    const std::size_t begin = 60, end = 131, m2 = 36;
    std::vector<float> out(70 * (end - begin) * m2);
    reader.readLocalVertices(begin, end, out);
    for (std::size_t f = 0; f < 70; ++f) {
        const std::vector<float> frame = samples::visibilityFrame(header, f).local_coefficients;
        EXPECT_TRUE(std::equal(&frame[begin * m2], &frame[end * m2], &out[f * (end - begin) * m2])) << f;
    }
}

TEST(VisibilityFile, KeepsThePlaceOfAShard) {
    const samples::Folder folder("vis_shard");
    VisibilityHeader header = samples::visibilityHeader(2, 4);  // two frames of each clip
    header.shard = ShardPlace{{"idle", "run", "walk"}, {9, 5, 4}, {1, 3, 0, 4}};
    samples::writeVisibility(folder.path / "x.vis.h5", header, Precision::kFloat32);
    expectSame(VisibilityReader(folder.path / "x.vis.h5").header(), header);
    expectSameBytesAgain(folder.path / "x.vis.h5", Precision::kFloat32);
    const auto refused = [&](const ShardPlace& place) {
        header.shard = place;
        samples::writeVisibility(folder.path / "x.vis.h5", header, Precision::kFloat32);
        EXPECT_THROW(VisibilityReader(folder.path / "x.vis.h5"), InvalidInput);
    };
    refused({{"idle", "run"}, {9, 5}, {1, 3, 0, 4}});             // frames of a clip that it does not list
    refused({{"idle", "run", "walk"}, {9, 5, 4}, {1, 4, 0, 4}});  // walk has frames 0..3
    refused({{"idle", "run", "walk"}, {9, 5, 4}, {1, 1, 0, 4}});  // not ascending
    refused({{"idle", "run", "run"}, {9, 5, 4}, {1, 3, 0, 4}});   // not unique
}

TEST(VisibilityShard, RangesOfFrames) {
    EXPECT_EQ(rangesText({}, 3), "");
    EXPECT_EQ(rangesText({{"a", 3}, {"a", 4}, {"a", 6}, {"b", 7}}, 3), "'a' 3:5, 'a' 6:7, 'b' 7:8");
    EXPECT_EQ(rangesText({{"a", 0}, {"a", 2}, {"a", 4}, {"b", 0}}, 2), "'a' 0:1, 'a' 2:3 and 2 more");
}

TEST(VisibilityFile, ReadsVerticesOverAllFrames) {
    const samples::Folder folder("vis_vertices");
    const VisibilityHeader header = samples::visibilityHeader(100, 70);
    samples::writeVisibility(folder.path / "x.vis.h5", header, Precision::kFloat32);
    const VisibilityReader reader(folder.path / "x.vis.h5");
    const std::size_t begin = 60, end = 131, n2 = header.coefficientCount();
    std::vector<float> out(70 * (end - begin) * n2);
    reader.readVertices(begin, end, out);
    for (std::size_t f = 0; f < 70; ++f) {
        const std::vector<float> frame = samples::visibilityFrame(header, f).coefficients;
        EXPECT_TRUE(std::equal(&frame[begin * n2], &frame[end * n2], &out[f * (end - begin) * n2])) << f;
    }
}

TEST(VisibilityFile, Float16KeepsTheNearestHalf) {
    const samples::Folder folder("vis_f16");
    const VisibilityHeader header = samples::visibilityHeader(3, 2);
    samples::writeVisibility(folder.path / "x.vis.h5", header, Precision::kFloat16);
    VisibilityFrame expected = samples::visibilityFrame(header, 1);
    for (float& c : expected.coefficients) c = halfToFloat(floatToHalf(c));
    expectSame(VisibilityReader(folder.path / "x.vis.h5").readFrame(1), expected);
    expectSameBytesAgain(folder.path / "x.vis.h5", Precision::kFloat16);
}

TEST(VisibilityFile, WithoutSkinAndPose) {
    const samples::Folder folder("vis_plain");
    VisibilityHeader header = samples::visibilityHeader(2, 3);
    header.skin.reset();
    header.pose_size = 0;
    header.ground_y.reset();
    header.quantity = "mirrored_visibility";
    samples::writeVisibility(folder.path / "x.vis.h5", header, Precision::kFloat32);
    const VisibilityReader reader(folder.path / "x.vis.h5");
    expectSame(reader.header(), header);
    expectSame(reader.readFrame(2), samples::visibilityFrame(header, 2));
    expectSameBytesAgain(folder.path / "x.vis.h5", Precision::kFloat32);
}

TEST(VisibilityFile, KeepsATwoSidedSheet) {
    const samples::Folder folder("vis_sheet");
    const VisibilityHeader header = samples::sheetHeader(4, 3);
    samples::writeVisibility(folder.path / "x.vis.h5", header, Precision::kFloat32);
    const VisibilityReader reader(folder.path / "x.vis.h5");
    expectSame(reader.header(), header);
    expectSame(reader.readFrame(2), samples::visibilityFrame(header, 2));
    expectSameBytesAgain(folder.path / "x.vis.h5", Precision::kFloat32);
}

TEST(VisibilityFile, KeepsTransferWithBounces) {
    const samples::Folder folder("vis_transfer");
    VisibilityHeader header = samples::sheetHeader(40, 70);
    header.quantity = kDiffuseTransfer;
    header.bounces = 3;
    header.colors.albedo.assign(header.mesh.vertexCount(), {0.5f, 0.25f, 0});
    header.colors.transmission.assign(header.mesh.vertexCount(), {0.5f, 0, 0.75f});
    samples::writeVisibility(folder.path / "x.vis.h5", header, Precision::kFloat32);
    const VisibilityReader reader(folder.path / "x.vis.h5");
    expectSame(reader.header(), header);
    for (std::size_t f : {0u, 69u}) expectSame(reader.readFrame(f), samples::visibilityFrame(header, f));
    const VisibilityFrame last = samples::visibilityFrame(header, 69);
    EXPECT_EQ(reader.readHitShares(69)[1], last.hit_shares[1]);
    const std::size_t numbers = header.indirectCount();
    std::vector<float> some(70 * 2 * numbers);
    reader.readIndirectVertices(5, 7, some);
    EXPECT_TRUE(std::equal(some.end() - std::ptrdiff_t(2 * numbers), some.end(),
                           last.indirect.begin() + std::ptrdiff_t(5 * numbers)));
    expectSameBytesAgain(folder.path / "x.vis.h5", Precision::kFloat32);
}

TEST(VisibilityFile, RefusesColorsThatMakeLight) {
    const samples::Folder folder("vis_colors");
    VisibilityHeader header = samples::sheetHeader(4, 3);
    header.quantity = kDiffuseTransfer;
    header.bounces = 1;
    for (const auto& [albedo, through] : {std::pair(1.0f, 0.0f), std::pair(-0.1f, 0.0f), std::pair(0.5f, 0.6f)}) {
        header.colors.albedo.assign(header.mesh.vertexCount(), {0, albedo, 0});
        header.colors.transmission.assign(header.mesh.vertexCount(), {0, through, 0});
        samples::writeVisibility(folder.path / "x.vis.h5", header, Precision::kFloat32);
        EXPECT_THROW(VisibilityReader(folder.path / "x.vis.h5"), InvalidInput) << albedo;
    }
}

TEST(VisibilityFile, SameBytesOnARerun) {
    const samples::Folder folder("vis_rerun");
    for (Precision precision : {Precision::kFloat32, Precision::kFloat16}) {
        const VisibilityHeader header = samples::visibilityHeader(40, 70);
        samples::writeVisibility(folder.path / "a", header, precision);
        samples::writeVisibility(folder.path / "b", header, precision);
        EXPECT_EQ(samples::bytesOf(folder.path / "a"), samples::bytesOf(folder.path / "b"));
    }
}

TEST(VisibilityFile, UnfinishedWriterLeavesNothingAndKeepsTheOldFile) {
    const samples::Folder folder("vis_unfinished");
    const VisibilityHeader header = samples::visibilityHeader(2, 3);
    {
        VisibilityWriter writer(folder.path / "x.vis.h5", header, Precision::kFloat32);
        writer.writeFrame(samples::visibilityFrame(header, 0));
    }
    EXPECT_EQ(folder.entries(), 0u);
    samples::writeVisibility(folder.path / "x.vis.h5", header, Precision::kFloat32);
    const std::string before = samples::bytesOf(folder.path / "x.vis.h5");
    { VisibilityWriter writer(folder.path / "x.vis.h5", header, Precision::kFloat16); }
    EXPECT_EQ(samples::bytesOf(folder.path / "x.vis.h5"), before);
}

// Flips one bit of every 17th byte in turn: the file is refused, or the bit is of no consequence. Text attributes lie
// in HDF5's global heap, which has no checksums; only those of them that take any text can change unnoticed.
TEST(VisibilityFile, AFlippedBitIsFound) {
    const samples::Folder folder("vis_flipped");
    for (Precision precision : {Precision::kFloat32, Precision::kFloat16}) {
        samples::writeVisibility(folder.path / "whole", samples::visibilityHeader(9, 3), precision);
        const std::string whole = samples::bytesOf(folder.path / "whole");
        const VisibilityReader expected(folder.path / "whole");
        std::size_t found = 0, tried = 0;
        for (std::size_t at = 0; at < whole.size(); at += 17, ++tried) {
            std::string changed = whole;
            changed[at] ^= char(1u << at % 8);
            samples::writeBytes(folder.path / "changed", changed);
            try {
                const VisibilityReader reader(folder.path / "changed");
                checkFrames(reader);
                VisibilityHeader header = reader.header();
                header.provenance = expected.header().provenance;
                header.pose_parameterisation = expected.header().pose_parameterisation;
                expectSame(header, expected.header());
                for (std::size_t f = 0; f < 3; ++f) expectSame(reader.readFrame(f), expected.readFrame(f));
            } catch (const InvalidInput&) {
                ++found;
            } catch (const IoError&) {
                ++found;
            } catch (const Unsupported&) {
                ++found;
            }
            ASSERT_FALSE(HasFailure()) << "byte " << at;
        }
        EXPECT_GT(found, tried / 2);  // the rest is room that nothing lies in, or text
    }
}

TEST(VisibilityFile, CheckingNamesTheDataset) {
    const samples::Folder folder("vis_check");
    const VisibilityHeader header = samples::visibilityHeader(100, 150);
    samples::writeVisibility(folder.path / "x.vis.h5", header, Precision::kFloat32);
    checkFrames(VisibilityReader(folder.path / "x.vis.h5"));
    haddr_t chunk = 0;
    {
        const Hdf5Reader in = openHdf5(folder.path / "x.vis.h5");
        const Hdf5Handle dataset(H5Dopen2(in.file, "/visibility/coefficients", H5P_DEFAULT), H5Dclose, "test");
        const Hdf5Handle space(H5Dget_space(dataset), H5Sclose, "test");
        hsize_t begin[3], size = 0;
        unsigned filters = 0;
        checkHdf5(H5Dget_chunk_info(dataset, space, 7, begin, &filters, &chunk, &size), "test");
    }
    std::string bytes = samples::bytesOf(folder.path / "x.vis.h5");
    bytes[chunk + 100] ^= 4;
    samples::writeBytes(folder.path / "x.vis.h5", bytes);
    const VisibilityReader reader(folder.path / "x.vis.h5");
    try {
        checkFrames(reader);
        ADD_FAILURE() << "accepted";
    } catch (const InvalidInput& error) {
        EXPECT_NE(std::string(error.what()).find("x.vis.h5: /visibility/coefficients: damaged"), std::string::npos)
            << error.what();
    }
}

TEST(VisibilityFile, MissingFileIsAnIoError) {
    EXPECT_THROW(VisibilityReader("no/such/file.vis.h5"), IoError);
    EXPECT_THROW(VisibilityReader("/"), IoError);
    const VisibilityHeader header = samples::visibilityHeader(1, 1);
    EXPECT_THROW(VisibilityWriter("no/such/folder/x.vis.h5", header, Precision::kFloat32), IoError);
}

}  // namespace
}  // namespace penumbra::test_visibility_file
