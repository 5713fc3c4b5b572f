// Tests virtual x.vis.h5: the frames of other files, refused unless each file is there and is what it was.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "formats/common/errors.h"
#include "formats/common/sha256.h"
#include "formats/stage/visibility_check.h"
#include "tests/formats/stage_samples.h"

namespace penumbra::test_visibility_virtual {
namespace {
using testing::HasSubstr;
namespace fs = std::filesystem;

// Three files of 4 frames in shards/, and an index of their 12 frames in turn in out/.
struct Index {
    samples::Folder folder;
    VisibilityHeader whole = samples::localHeader(20, 12);
    VirtualSources sources;
    fs::path path;

    explicit Index(const std::string& name, Precision precision = Precision::kFloat32) : folder(name) {
        fs::create_directories(folder.path / "shards");
        fs::create_directories(folder.path / "out");
        for (std::uint32_t s = 0; s < 3; ++s) {
            const fs::path shard = shardPath(s);
            VisibilityWriter writer(shard, samples::localHeader(20, 4), precision);
            for (std::uint32_t f = 0; f < 4; ++f) writer.writeFrame(samples::visibilityFrame(whole, 3 * f + s));
            writer.finish();
            sources.files.push_back("../shards/" + shard.filename().string());
            sources.sha256.push_back(sha256OfFile(shard));
            sources.frames_of_file.push_back(4);
        }
        for (std::uint32_t f = 0; f < 12; ++f) sources.source.push_back({f % 3, f / 3});
        path = folder.path / "out" / "x.vis.h5";
        writeVirtualVisibility(path, whole, precision, sources);
    }
    fs::path shardPath(std::uint32_t s) const { return folder.path / "shards" / (std::to_string(s) + ".vis.h5"); }
};

template <class Error>
std::string refusal(const fs::path& path) {
    try {
        VisibilityReader reader(path);
    } catch (const Error& error) {
        return error.what();
    }
    ADD_FAILURE() << "accepted, or refused in another way";
    return "";
}

TEST(VisibilityVirtual, ShowsTheFramesOfItsFiles) {
    const Index index("virtual");
    const VisibilityReader reader(index.path);
    EXPECT_TRUE(reader.isVirtual());
    checkFrames(reader);
    for (std::size_t f = 0; f < 12; ++f) {
        const VisibilityFrame expected = samples::visibilityFrame(index.whole, f), found = reader.readFrame(f);
        EXPECT_EQ(found.coefficients, expected.coefficients) << f;
        EXPECT_EQ(found.local_coefficients, expected.local_coefficients) << f;
        EXPECT_EQ(found.positions, expected.positions) << f;
        EXPECT_EQ(found.pose, expected.pose) << f;
        EXPECT_EQ(reader.readPose(f).bones, expected.bones) << f;
    }
    const std::size_t begin = 7, end = 31, n2 = index.whole.coefficientCount(), row = (end - begin) * n2;
    std::vector<float> out(12 * row);
    reader.readVertices(begin, end, out);
    for (std::size_t f = 0; f < 12; ++f) {
        const std::vector<float> frame = samples::visibilityFrame(index.whole, f).coefficients;
        EXPECT_TRUE(std::equal(&frame[begin * n2], &frame[end * n2], &out[f * row])) << f;
    }
    std::vector<float> local(12 * 36);
    EXPECT_EQ(reader.header().local, index.whole.local);
    reader.readLocalVertices(30, 31, local);
    EXPECT_EQ(local[5 * 36 + 7], samples::visibilityFrame(index.whole, 5).local_coefficients[30 * 36 + 7]);
    EXPECT_EQ(VisibilityReader(Index("virtual_f16", Precision::kFloat16).path).precision(), Precision::kFloat16);
}

TEST(VisibilityVirtual, IsFoundThroughLinks) {
    const Index index("virtual_link");
    fs::create_directories(index.folder.path / "a/b");
    fs::create_symlink("../../out/x.vis.h5", index.folder.path / "a/b/link.vis.h5");
    fs::create_symlink("../out", index.folder.path / "a/out");
    for (const char* name : {"a/b/link.vis.h5", "a/out/x.vis.h5"})
        EXPECT_EQ(VisibilityReader(index.folder.path / name).readFrame(5).coefficients,
                  samples::visibilityFrame(index.whole, 5).coefficients);
}

TEST(VisibilityVirtual, NamesAFileThatIsMissingOrChanged) {
    const Index index("virtual_gone");
    const std::string bytes = samples::bytesOf(index.shardPath(1));
    fs::remove(index.shardPath(1));
    EXPECT_THAT(refusal<IoError>(index.path), HasSubstr("1.vis.h5"));
    fs::create_directory(index.shardPath(1));
    EXPECT_THAT(refusal<IoError>(index.path), HasSubstr("1.vis.h5"));
    fs::remove(index.shardPath(1));
    for (std::size_t at = 0; at < bytes.size(); at += 97) {
        std::string changed = bytes;
        changed[at] ^= 1;
        samples::writeBytes(index.shardPath(1), changed);
        EXPECT_THAT(refusal<InvalidInput>(index.path), HasSubstr("1.vis.h5")) << at;
    }
    samples::writeBytes(index.shardPath(1), bytes);
    EXPECT_EQ(VisibilityReader(index.path).header().frames.frameCount(), 12u);
}

TEST(VisibilityVirtual, RefusesAListThatDoesNotFit) {
    Index index("virtual_lists");
    const VirtualSources good = index.sources;
    const auto rewrite = [&] { writeVirtualVisibility(index.path, index.whole, Precision::kFloat32, index.sources); };
    index.sources.sha256[2][0] ^= 1;
    rewrite();
    EXPECT_THAT(refusal<InvalidInput>(index.path), HasSubstr("2.vis.h5"));
    index.sources = good;
    index.sources.files[2] = "../out/x.vis.h5";  // itself
    rewrite();
    EXPECT_THAT(refusal<InvalidInput>(index.path), HasSubstr("has changed"));
    // This file has other vertices.
    samples::writeVisibility(index.shardPath(2), samples::visibilityHeader(9, 4), Precision::kFloat32);
    index.sources = good;
    index.sources.sha256[2] = sha256OfFile(index.shardPath(2));
    rewrite();
    EXPECT_THAT(refusal<InvalidInput>(index.path), HasSubstr("2.vis.h5: /frames/positions"));
    // This one has no local moments.
    samples::writeVisibility(index.shardPath(2), samples::visibilityHeader(20, 4), Precision::kFloat32);
    index.sources.sha256[2] = sha256OfFile(index.shardPath(2));
    rewrite();
    EXPECT_THAT(refusal<InvalidInput>(index.path), HasSubstr("2.vis.h5: /visibility/local: missing"));
    // This one has fewer frames than the list wants.
    samples::writeVisibility(index.shardPath(2), samples::localHeader(20, 3), Precision::kFloat32);
    index.sources.sha256[2] = sha256OfFile(index.shardPath(2));
    rewrite();
    EXPECT_THAT(refusal<InvalidInput>(index.path), HasSubstr("/virtual/frame_in_file"));
}

}  // namespace
}  // namespace penumbra::test_visibility_virtual
