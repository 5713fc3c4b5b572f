// Every format of point caches gives the flapping sheet of scripts/samples/flapping_sheet.py, which is known by
// formula.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <csignal>
#include <cstdlib>
#include <random>

#include "formats/cache/zip_archive.h"
#include "formats/common/errors.h"
#include "formats/common/parallel_for.h"
#include "formats/common/random_bytes.h"
#include "formats/source/source_readers.h"
#include "tests/formats/flapping_sheet.h"
#include "tests/formats/rig_samples.h"
#include "tests/formats/sheet_files.h"

namespace penumbra::test_point_cache {
namespace {

using samples::distanceToSheet;
using samples::expectSheet;
using samples::kFloat;
using samples::kSheetFrames;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::StartsWith;

std::filesystem::path sample(const std::string& name) {
    return std::filesystem::path(PENUMBRA_BINARY_DIR) / ".." / "samples" / name;
}

std::filesystem::path scratch(const std::string& name) {
    return std::filesystem::path(testing::TempDir()) / ("penumbra_cache_" + name);
}

TEST(PointCacheNumpy, CompressedFloatsAndQuads) {
    const PointCache cache = readPointCache({sample("sheet.npz")}, {});
    expectSheet(cache, kFloat);
    EXPECT_EQ(cache.clips[0].name, "sheet");
    EXPECT_DOUBLE_EQ(cache.clips[0].times[12], 1.0);
    EXPECT_LE(distanceToSheet(cache, cache.mesh.rest_positions, 0), kFloat);
    EXPECT_THAT(cache.files_read, ElementsAre(sample("sheet.npz")));
}

TEST(PointCacheNumpy, BigEndianStoredDoublesWithARest) {
    const PointCache cache = readPointCache({sample("sheet_f64.npz")}, {});
    expectSheet(cache, kFloat);
    EXPECT_LE(distanceToSheet(cache, cache.mesh.rest_positions, 6), kFloat);
    EXPECT_DOUBLE_EQ(cache.clips[0].times[12], 12 / kCacheFps);
}

// The step is 1.5/65535. Half of it, in three coordinates, is 2e-5.
TEST(PointCacheNumpy, QuantisedWithUnevenTimes) {
    const PointCache cache = readPointCache({sample("sheet_q.npz")}, {});
    expectSheet(cache, 2.1e-5);
    for (std::size_t f = 0; f < kSheetFrames; ++f) EXPECT_DOUBLE_EQ(cache.clips[0].times[f], double(f * f) / 144);
}

TEST(PointCacheNumpy, UnitsAndUpOfAnArrayWithFacesBeside) {
    const PointCacheOptions options{.metres = metresOfUnit("cm"), .z_up = true, .fps = 60};
    for (const auto& paths : {std::pair("sheet_z_cm.npy", "sheet_faces.npy"), {"sheet_faces.npy", "sheet_z_cm.npy"}}) {
        const PointCache cache = readPointCache({sample(paths.first), sample(paths.second)}, options);
        expectSheet(cache, kFloat);
        EXPECT_EQ(cache.clips[0].name, "sheet_z_cm");
        EXPECT_DOUBLE_EQ(cache.clips[0].times[12], 0.2);
        EXPECT_EQ(cache.files_read.size(), 2u);
    }
}

// Without the seam's double of each of five rows there are 40 points. The slit's are at two places in all frames but
// the first.
TEST(PointCache, WeldsWhatNeverParts) {
    const PointCache cache = readPointCache({sample("sheet.npz")}, {});
    EXPECT_EQ(cache.mesh.vertexCount(), samples::kSheetPoints);
    for (std::uint32_t row = 0; row < 5; ++row) {
        const auto& point = cache.mesh.source_vertex;
        EXPECT_EQ(point[35 + row], point[row * 7 + 3]);
        EXPECT_NE(point[40 + row], point[row * 7 + 5]);
        EXPECT_EQ(cache.mesh.rest_positions[point[40 + row]], cache.mesh.rest_positions[point[row * 7 + 5]]);
    }
}

TEST(PointCache, SamplesBetweenKeysAreLinear) {
    const PointCache cache = readPointCache({sample("sheet.npz")}, {});
    const std::vector<Vec3> a = readFrame(cache, 0, 3), b = readFrame(cache, 0, 4);
    const std::vector<Vec3> quarter = samplePositions(cache, 0, 3.25 / 12);
    for (std::size_t v = 0; v < a.size(); ++v)
        EXPECT_LE(length(toDouble(quarter[v]) - (0.75 * toDouble(a[v]) + 0.25 * toDouble(b[v]))), kFloat);
    EXPECT_EQ(samplePositions(cache, 0, 3.0 / 12), a);
    EXPECT_EQ(samplePositions(cache, 0, -1), readFrame(cache, 0, 0));
    EXPECT_EQ(samplePositions(cache, 0, 7), readFrame(cache, 0, 12));
}

TEST(PointCache, FramesAreTheKeysOrResampled) {
    const PointCache cache = readPointCache({sample("sheet.npz"), sample("sheet_q.npz")}, {});
    const FrameList keys = sampleFrames(cache, {}, 0);
    EXPECT_EQ(keys.frameCount(), 26u);
    EXPECT_THAT(keys.clip_names, ElementsAre("sheet", "sheet_q"));
    EXPECT_DOUBLE_EQ(keys.time[13 + 5], 25.0 / 144);
    const FrameList resampled = sampleFrames(cache, {"sheet_q"}, 4);
    EXPECT_THAT(resampled.time, ElementsAre(0, 0.25, 0.5, 0.75, 1));
    try {
        sampleFrames(cache, {"flag"}, 0);
        FAIL();
    } catch (const UsageError& error) {
        EXPECT_STREQ(error.what(), "clips: no clip 'flag'; the cache has sheet, sheet_q");
    }
}

// The seam parts in no clip, and the slit in both.
TEST(PointCache, SeveralFilesAreClipsOfOneMesh) {
    const PointCache cache = readPointCache({sample("sheet.npz"), sample("sheet.npz")}, {});
    EXPECT_EQ(cache.mesh.vertexCount(), samples::kSheetPoints);
    EXPECT_EQ(cache.clips[1].name, "sheet#2");
    EXPECT_EQ(readFrame(cache, 1, 7), readFrame(cache, 0, 7));
}

TEST(PointCache, UnitsAreRead) {
    EXPECT_DOUBLE_EQ(metresOfUnit("inch"), 0.0254);
    EXPECT_DOUBLE_EQ(metresOfUnit("2.5e-2"), 0.025);
    for (const char* units : {"", "km", "0", "-1", "nan", "inf", "1m", " 1"})
        EXPECT_THROW(metresOfUnit(units), std::invalid_argument);
}

// Any thread reads any place as if it were alone.
TEST(ZipArchive, ManyThreadsReadOneDeflatedMember) {
    std::mt19937 random(5);
    std::string data(8 << 20, '\0');
    for (char& c : data) c = char(random() % 64);
    samples::writeText(scratch("noise.zip"), samples::zipOf({{.name = "noise", .data = data, .compress = true}}));
    const RandomBytes bytes = openMember(openZip(scratch("noise.zip")), "noise").value();
    ASSERT_EQ(bytes.size, data.size());
    parallelFor(100, 8, [&](std::size_t i) {
        const std::size_t offset = (i * 7919 * 4099) % data.size(), size = std::min(data.size() - offset, 3 + 251 * i);
        const std::vector<std::byte> got = readBytes(bytes, offset, size);
        EXPECT_EQ(std::memcmp(got.data(), data.data() + offset, size), 0) << "offset " << offset;
    });
    EXPECT_FALSE(openMember(openZip(scratch("noise.zip")), "silence").has_value());
}

// The refusal names the archive, the member and the folder.
TEST(ZipArchive, SaysWhereItCannotInflate) {
    const std::filesystem::path file = scratch("full.zip");
    samples::writeText(file, samples::zipOf({{.name = "a", .data = std::string(9000, 'a'), .compress = true}}));
    const auto problem = [&] {
        try {
            openMember(openZip(file), "a");
        } catch (const IoError& error) {
            return std::string(error.what());
        }
        return std::string("was inflated");
    };
    const std::string start = file.string() + ": 'a': cannot be inflated into ";
    // 1. A folder without room.
    const char* const usual = std::getenv("TMPDIR");
    const std::string before = usual ? usual : "";
    ::setenv("TMPDIR", "/proc/self", 1);
    EXPECT_THAT(problem(), StartsWith(start + "/proc/self"));
    // 2. No room any more while it is written. Without TMPDIR that is in /var/tmp.
    ::unsetenv("TMPDIR");
    rlimit limit{}, little{};
    ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &limit), 0);
    little = {5000, limit.rlim_max};
    const auto handler = std::signal(SIGXFSZ, SIG_IGN);
    ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &little), 0);
    const std::string said = problem();
    ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &limit), 0);
    std::signal(SIGXFSZ, handler);
    EXPECT_THAT(said, StartsWith(start + "/var/tmp"));
    EXPECT_THAT(said, HasSubstr("File too large"));
    EXPECT_EQ(problem(), "was inflated");
    if (usual) ::setenv("TMPDIR", before.c_str(), 1);
}

TEST(ZipArchive, SizesOf64Bits) {
    samples::ZipEntry verts{.name = "verts.npy", .data = samples::sheetVerts(), .compress = true, .zip64 = true};
    samples::ZipEntry faces{.name = "faces.npy", .data = samples::sheetFaces(), .zip64 = true};
    samples::writeText(scratch("zip64.npz"), samples::zipOf({verts, faces}, true));
    expectSheet(readPointCache({scratch("zip64.npz")}, {}), kFloat);
}

}  // namespace
}  // namespace penumbra::test_point_cache
