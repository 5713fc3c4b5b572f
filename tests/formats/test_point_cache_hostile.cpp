// Each wrong or damaged point cache is refused with the file's name and the field or frame, and none crashes the
// reader.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "formats/common/errors.h"
#include "formats/source/source_readers.h"
#include "tests/formats/flapping_sheet.h"
#include "tests/formats/rig_samples.h"

namespace penumbra::test_point_cache_hostile {
namespace {

using samples::bytesOf;
using samples::npy;
using samples::sheetFaces;
using samples::sheetVerts;
using samples::ZipEntry;
using testing::HasSubstr;

std::filesystem::path scratch(const std::string& name) {
    return std::filesystem::path(testing::TempDir()) / ("penumbra_hostile_cache_" + name);
}

void readEverything(const std::vector<std::filesystem::path>& paths) {
    const PointCache cache = readPointCache(paths, {});
    for (std::size_t c = 0; c < cache.clips.size(); ++c)
        for (std::size_t k = 0; k < cache.clips[c].times.size(); ++k) readFrame(cache, c, k);
}

// Returns what reading all frames says. The test fails where they are read, or refused with something else than
// Error.
template <class Error = InvalidInput>
std::string refusal(const std::vector<std::filesystem::path>& paths) {
    try {
        readEverything(paths);
    } catch (const Error& error) {
        EXPECT_THAT(error.what(), testing::Not(HasSubstr("\n")));
        return error.what();
    } catch (const std::exception& error) {
        ADD_FAILURE() << paths[0] << ": another kind of error: " << error.what();
        return {};
    }
    ADD_FAILURE() << paths[0] << " was read";
    return {};
}

template <class Error = InvalidInput>
void expectRefusal(const std::vector<ZipEntry>& entries, const std::string& message) {
    samples::writeText(scratch("case.npz"), samples::zipOf(entries));
    const std::string said = refusal<Error>({scratch("case.npz")});
    EXPECT_THAT(said, HasSubstr(scratch("case.npz").string()));
    EXPECT_THAT(said, HasSubstr(message));
}

ZipEntry array(const std::string& key, const std::string& bytes) { return {.name = key + ".npy", .data = bytes}; }

TEST(PointCacheHostile, EveryTruncationOfAnNpz) {
    const std::string whole =
        samples::zipOf({{.name = "verts.npy", .data = sheetVerts(1), .compress = true}, array("faces", sheetFaces())});
    samples::writeText(scratch("whole.npz"), whole);
    ASSERT_NO_THROW(readEverything({scratch("whole.npz")}));
    for (std::size_t n = 0; n < whole.size(); ++n) {
        samples::writeText(scratch("cut.npz"), whole.substr(0, n));
        ASSERT_THROW(readEverything({scratch("cut.npz")}), InvalidInput) << "first " << n << " bytes";
    }
}

// A checksum covers every member. A changed byte is refused, unless it says nothing (a date, a version).
TEST(PointCacheHostile, EveryChangedByteOfAnNpz) {
    std::string bytes =
        samples::zipOf({{.name = "verts.npy", .data = sheetVerts(1), .compress = true}, array("faces", sheetFaces())});
    std::size_t read = 0;
    for (char& c : bytes) {
        c = char(c ^ 0x41);
        samples::writeText(scratch("flip.npz"), bytes);
        try {
            readEverything({scratch("flip.npz")});
            ++read;
        } catch (const InvalidInput&) {
        } catch (const Unsupported&) {
        }
        c = char(c ^ 0x41);
    }
    EXPECT_LE(read, 104u);  // out of 1,003: dates, versions, and fields of local headers that the directory repeats
}

TEST(PointCacheHostile, EveryTruncationOfAnNpy) {
    const std::string whole = sheetVerts(1);
    samples::writeText(scratch("faces.npy"), sheetFaces());
    samples::writeText(scratch("whole.npy"), whole);
    ASSERT_NO_THROW(readEverything({scratch("whole.npy"), scratch("faces.npy")}));
    for (std::size_t n = 0; n < whole.size(); ++n) {
        samples::writeText(scratch("cut.npy"), whole.substr(0, n));
        ASSERT_THROW(readEverything({scratch("cut.npy"), scratch("faces.npy")}), InvalidInput) << n << " bytes";
    }
}

TEST(PointCacheHostile, WrongArraysAreNamed) {
    const ZipEntry verts = array("verts", sheetVerts(2)), faces = array("faces", sheetFaces());
    expectRefusal({faces}, "has neither 'verts' nor 'verts_q'");
    expectRefusal({verts}, "has no faces, and no mesh comes with it");
    expectRefusal({verts, faces, array("verts_q", sheetVerts(1))}, "has both 'verts' and 'verts_q'");
    expectRefusal({array("verts_q", npy("<u2", "1, 2, 3", std::string(12, '\0'))), faces}, "no 'q_lo'");
    expectRefusal({array("verts", npy("<f4", "2, 45, 2", std::string(720, '\0'))), faces},
                  "'verts': f4 [2,45,2] is not [frames, vertices, 3]");
    expectRefusal({array("verts", npy("<f4", "0, 45, 3", "")), faces}, "has no frames");
    expectRefusal({array("verts", npy("<f4", "1, 45, 3", std::string(540, '\0'))), faces}, "all at one place");
    expectRefusal({array("verts", npy("<f4", "99999999, 99999999, 99999999", "")), faces}, "needs another size");
    expectRefusal({array("verts", npy("<f4", "999999999999, 999999999999, 3", "")), faces}, "needs another size");
    expectRefusal({array("verts", npy("<i4", "1, 1, 3", std::string(12, '\0'))), faces}, "is not of floats");
    expectRefusal<Unsupported>({array("verts", npy("<f2", "1, 1, 3", std::string(6, '\0'))), faces}, "type '<f2'");
    expectRefusal<Unsupported>({array("verts", npy("|O", "1, 1, 3", "")), faces}, "type '|O'");
    expectRefusal<Unsupported>(
        {array("verts", npy("{'descr': '<f4', 'fortran_order': True, 'shape': (1,), }", "abcd")), faces},
        "column-major");
    expectRefusal({array("verts", npy("{'descr': '<f4', 'shape': (1,)}", "abcd")), faces}, "header is damaged");
    expectRefusal({array("verts", npy("{'descr': '<f4', 'fortran_order': False, 'shape': (-1,)}", "")), faces},
                  "header is damaged");
    expectRefusal({verts, array("faces", npy("<i4", "1, 3", bytesOf(std::array{0, 1, 45})))},
                  "'faces': face 0 names vertex 45 of 45");
    expectRefusal({verts, array("faces", npy("<i4", "1, 3", bytesOf(std::array{0, -1, 4})))}, "names vertex -1");
    expectRefusal({verts, array("faces", npy("<f4", "1, 3", std::string(12, '\0')))}, "is not integers");
    expectRefusal({verts, array("faces", npy("<i4", "1, 3", std::string(12, '\0')))}, "no triangle with an area");
    expectRefusal({verts, faces, array("fps", npy("<f4", "", bytesOf(0.0f)))}, "'fps': is not above 0");
    expectRefusal({verts, faces, array("fps", npy("<f4", "2,", bytesOf(std::array{1.f, 2.f})))}, "is not one number");
    expectRefusal({verts, faces, array("times", npy("<f8", "2,", bytesOf(std::array{1.0, 1.0})))},
                  "ascending at frame 1");
    expectRefusal({verts, faces, array("times", npy("<f8", "3,", bytesOf(std::array{1.0, 2.0, 3.0})))},
                  "not one time for each of 2 frames");
    expectRefusal({verts, faces, array("rest", npy("<f4", "1, 3", std::string(12, '\0')))}, "'rest': f4 [1,3]");
}

TEST(PointCacheHostile, DamagedArchives) {
    const ZipEntry faces = array("faces", sheetFaces());
    ZipEntry verts = array("verts", sheetVerts(1));
    verts.stated_size = verts.data.size() + 1;
    expectRefusal({verts, faces}, "'verts.npy': its two sizes differ");
    verts.compress = true;
    expectRefusal({verts, faces}, "'verts.npy': its data are shorter than stated");
    verts.stated_size = verts.data.size() - 1;
    expectRefusal({verts, faces}, "'verts.npy': its data are longer than stated");
    verts.stated_size = std::uint64_t(1) << 31;
    expectRefusal({verts, faces}, "'verts.npy': states more bytes than it can hold");
    verts.stated_size = 0;
    verts.behind = "x";
    expectRefusal({verts, faces}, "'verts.npy': bytes follow the end of its compressed data");
    expectRefusal<Unsupported>({{.name = "verts.npy", .data = "", .method = 14}, faces}, "packed by method 14");
    EXPECT_THROW(readPointCache({scratch("nowhere.npz")}, {}), IoError);
    EXPECT_THROW(readPointCache({testing::TempDir() + "/nowhere.abc"}, {}), Unsupported);
}

TEST(PointCacheHostile, NumbersThatAreNotFiniteNameFrameAndVertex) {
    std::string verts = sheetVerts(2);
    const float infinite = std::numeric_limits<float>::infinity(), nan = std::numeric_limits<float>::quiet_NaN();
    for (const float wrong : {infinite, -infinite, nan}) {
        verts.replace(verts.size() - 8, 4, bytesOf(wrong));
        expectRefusal({array("verts", verts), array("faces", sheetFaces())},
                      "'verts': frame 1: vertex 44 is not at a finite place");
    }
}

TEST(PointCacheHostile, FilesThatDoNotBelongTogether) {
    const ZipEntry verts = array("verts", sheetVerts(1)), faces = array("faces", sheetFaces());
    samples::writeText(scratch("sheet.npz"), samples::zipOf({verts, faces}));
    const std::string other = npy("<u4", "1, 3", bytesOf(std::array{0, 1, 8}));
    samples::writeText(scratch("other.npz"), samples::zipOf({verts, array("faces", other)}));
    EXPECT_THAT(refusal({scratch("sheet.npz"), scratch("other.npz")}), HasSubstr("its faces are not those of"));
    samples::writeText(scratch("small.npy"), npy("<f4", "1, 3, 3", std::string(36, '\0')));
    EXPECT_THAT(refusal({scratch("sheet.npz"), scratch("small.npy")}), HasSubstr("small.npy: has 3 vertices"));
    samples::writeText(scratch("faces.npy"), sheetFaces());
    EXPECT_THAT(refusal({scratch("small.npy"), scratch("faces.npy")}), HasSubstr("faces.npy: names 45 vertices"));
    EXPECT_THAT(refusal({scratch("faces.npy")}), HasSubstr("no positions come with it"));
    EXPECT_THAT(refusal({scratch("small.npy")}), HasSubstr("has no faces"));
}

}  // namespace
}  // namespace penumbra::test_point_cache_hostile
