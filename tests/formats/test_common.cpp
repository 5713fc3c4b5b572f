// Tests errors, whole-file writes, hashes, provenance, parallel loops, halves and skinning.
#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <bit>
#include <random>
#include <thread>

#include "formats/common/errors.h"
#include "formats/common/fp16.h"
#include "formats/common/joined.h"
#include "formats/common/mesh.h"
#include "formats/common/parallel_for.h"
#include "formats/common/picture_text.h"
#include "formats/common/progress.h"
#include "formats/common/provenance.h"
#include "formats/common/sha256.h"
#include "formats/common/write_file.h"
#include "tests/formats/stage_samples.h"
#include "tests/no_simd.h"

// The names of the files and folders that fsync() was called for, while somebody listens.
static std::vector<std::filesystem::path>* flushed = nullptr;

// Stands before the C library's fsync() in this program.
extern "C" int fsync(int file) {
    if (flushed) flushed->push_back(std::filesystem::read_symlink("/proc/self/fd/" + std::to_string(file)));
    return int(::syscall(SYS_fsync, file));
}

namespace penumbra::test_common {
namespace {

// --- Lists ----------------------------------------------------------------------------------------------------------

TEST(ListedNames, QuoteNamesWithCommasAndTellHowTheyAreWritten) {
    EXPECT_EQ(listedNames({}), "none");
    EXPECT_EQ(listedNames({"walk", "run"}), "walk, run");
    EXPECT_EQ(listedNames({"walk, fast", "run"}), "'walk, fast', 'run' (a comma in a name is written \\,)");
}

// --- SHA-256 --------------------------------------------------------------------------------------------------------

std::string hashOf(std::string_view text) { return sha256Hex(std::as_bytes(std::span(text))); }

// These are FIPS 180-4 examples (one block, two blocks, a million letters) and the empty message.
TEST(Sha256, StandardVectors) {
    EXPECT_EQ(hashOf(""), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
    EXPECT_EQ(hashOf("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
    EXPECT_EQ(hashOf("abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq"),
              "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1");
    EXPECT_EQ(hashOf(std::string(1000000, 'a')), "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
}

TEST(Sha256, PiecesGiveTheSameAsTheWhole) {
    std::string text;
    for (int i = 0; i < 300; ++i) text += char('A' + i % 57);
    for (std::size_t length : {55u, 56u, 63u, 64u, 65u, 119u, 120u, 300u})
        for (std::size_t piece : {1u, 7u, 64u, 100u}) {
            Sha256 hash;
            for (std::size_t at = 0; at < length; at += piece)
                hash.update(std::as_bytes(std::span(text).subspan(at, std::min(piece, length - at))));
            EXPECT_EQ(hash.hex(), hashOf(text.substr(0, length))) << length << " in pieces of " << piece;
        }
}

TEST(Sha256, ThePlainFormGivesTheSame) {
    std::string text;
    for (int i = 0; i < 1000; ++i) text += char(i * i % 251);
    const std::string fast = hashOf(text);
    const NoSimd no_simd;
    EXPECT_EQ(hashOf(text), fast);
    EXPECT_EQ(hashOf("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
}

TEST(Sha256, OfFile) {
    const samples::Folder folder("sha");
    writeWholeFile(folder.path / "abc", "abc");
    EXPECT_EQ(sha256OfFile(folder.path / "abc"), hashOf("abc"));
    EXPECT_THROW(sha256OfFile(folder.path / "none"), IoError);
}

// --- PartialFile ----------------------------------------------------------------------------------------------------

TEST(PartialFile, ReplacesOnCommitOnly) {
    const samples::Folder folder("partial");
    const std::filesystem::path target = folder.path / "out";
    writeWholeFile(target, "old");
    try {
        PartialFile partial(target);
        std::ofstream(partial.path()) << "half";
        throw std::runtime_error("stop");
    } catch (const std::runtime_error&) {
    }
    EXPECT_EQ(samples::bytesOf(target), "old");
    EXPECT_EQ(folder.entries(), 1u);
    writeWholeFile(target, "new");
    EXPECT_EQ(samples::bytesOf(target), "new");
    EXPECT_EQ(folder.entries(), 1u);
}

// After a crash of the machine the name must stand for the whole file. So the bytes go to the disk before the name
// does, and the folder with the name goes there last.
TEST(PartialFile, FlushesTheBytesAndThenTheName) {
    const samples::Folder folder("partial_flush");
    std::vector<std::filesystem::path> names;
    flushed = &names;
    PartialFile partial(folder.path / "out");
    std::ofstream(partial.path()) << "whole";
    const std::filesystem::path written = std::filesystem::canonical(partial.path());
    partial.commit();
    flushed = nullptr;
    EXPECT_THAT(names, testing::ElementsAre(written, std::filesystem::canonical(folder.path)));
    EXPECT_EQ(samples::bytesOf(folder.path / "out"), "whole");
}

TEST(PartialFile, TwoWritersOfOneTargetDoNotMix) {
    const samples::Folder folder("partial_two");
    PartialFile first(folder.path / "out"), second(folder.path / "out");
    EXPECT_NE(first.path(), second.path());
    std::ofstream(first.path()) << "first";
    std::ofstream(second.path()) << "second";
    second.commit();
    first.commit();
    EXPECT_EQ(samples::bytesOf(folder.path / "out"), "first");
    EXPECT_EQ(folder.entries(), 1u);
}

TEST(PartialFile, RefusesWhatItCannotReplace) {
    const samples::Folder folder("partial_refuse");
    EXPECT_THROW(PartialFile(folder.path / "none" / "out"), IoError);
    EXPECT_THROW(PartialFile(folder.path.string()), IoError);
    EXPECT_THROW(PartialFile(""), IoError);
    EXPECT_THROW(PartialFile("/dev/null"), IoError);
    EXPECT_THROW(PartialFile("/proc/out"), IoError);
    writeWholeFile(folder.path / "file", "x");
    EXPECT_THROW(PartialFile(folder.path / "file" / "out"), IoError);
    EXPECT_EQ(folder.entries(), 1u);
}

TEST(PartialFile, WritesThroughALink) {
    const samples::Folder folder("partial_link");
    writeWholeFile(folder.path / "real", "old");
    std::filesystem::create_symlink("real", folder.path / "link");
    writeWholeFile(folder.path / "link", "new");
    EXPECT_TRUE(std::filesystem::is_symlink(folder.path / "link"));
    EXPECT_EQ(samples::bytesOf(folder.path / "real"), "new");
}

TEST(PartialFile, WritesThroughLinksThatLeadNowhereYet) {
    const samples::Folder folder("partial_dangling");
    std::filesystem::create_directory(folder.path / "there");
    std::filesystem::create_symlink("second", folder.path / "first");
    std::filesystem::create_symlink(folder.path / "there" / "real", folder.path / "second");
    writeWholeFile(folder.path / "first", "new");
    EXPECT_TRUE(std::filesystem::is_symlink(folder.path / "first"));
    EXPECT_TRUE(std::filesystem::is_symlink(folder.path / "second"));
    EXPECT_FALSE(std::filesystem::is_symlink(folder.path / "there" / "real"));
    EXPECT_EQ(samples::bytesOf(folder.path / "there" / "real"), "new");
    EXPECT_EQ(folder.entries(), 3u);
    std::filesystem::create_symlink("round", folder.path / "round");
    EXPECT_THROW(PartialFile(folder.path / "round"), IoError);
}

// A file system takes names of 255 bytes, and none that is longer.
TEST(PartialFile, LongNamesHaveShorterTemporaryNames) {
    const samples::Folder folder("partial_long");
    for (const std::string& unit : {std::string("n"), std::string("\xc3\xa4")})  // the letter a with two dots
        for (const std::size_t size : {230u, 250u, 253u, 254u, 255u}) {
            std::string name;
            while (name.size() + unit.size() <= size) name += unit;
            name.resize(size, 'x');
            const std::filesystem::path target = folder.path / name;
            PartialFile partial(target);
            EXPECT_EQ(partial.path().parent_path(), folder.path);
            EXPECT_LE(partial.path().filename().string().size(), 255u);
            EXPECT_EQ(targetOfPartial(partial.path()), target);
            const std::string shown = partial.path().filename().string();
            EXPECT_EQ(shown.find("\xc3-"), std::string::npos) << "half a letter";
            std::ofstream(partial.path()) << size;
            partial.commit();
            EXPECT_EQ(samples::bytesOf(target), std::to_string(size));
            EXPECT_EQ(targetOfPartial(partial.path()), partial.path());
        }
    EXPECT_THROW(PartialFile(folder.path / std::string(256, 'n')), IoError);
    EXPECT_EQ(folder.entries(), 10u);
    // Names that differ in their last byte alone have partial files of their own.
    const PartialFile one(folder.path / (std::string(254, 'n') + "1")),
        two(folder.path / (std::string(254, 'n') + "2"));
    EXPECT_NE(one.path().string().substr(0, one.path().string().rfind(".part")),
              two.path().string().substr(0, two.path().string().rfind(".part")));
}

// A new file has what the umask leaves, as any file that a program makes.
TEST(PartialFile, KeepsModeAndOwnerOfWhatItReplaces) {
    const samples::Folder folder("partial_mode");
    const std::filesystem::path target = folder.path / "out";
    const auto status = [&](const std::filesystem::path& path) {
        struct stat found {};
        EXPECT_EQ(::stat(path.c_str(), &found), 0);
        return found;
    };
    const mode_t before = ::umask(027);
    writeWholeFile(target, "new");
    EXPECT_EQ(status(target).st_mode & 07777, 0640u);
    for (const mode_t mode : {0600u, 0664u, 0751u, 0444u}) {
        ASSERT_EQ(::chmod(target.c_str(), mode), 0);
        {
            PartialFile partial(target);
            EXPECT_EQ(status(partial.path()).st_mode & 077, 0u) << "nobody else reads it while it is written";
            std::ofstream(partial.path()) << "next";
            partial.commit();
        }
        EXPECT_EQ(status(target).st_mode & 07777, mode);
        EXPECT_EQ(samples::bytesOf(target), "next");
    }
    ::umask(before);
    if (::geteuid() != 0) GTEST_SKIP() << "only root gives files away";
    ASSERT_EQ(::chown(target.c_str(), 12345, 23456), 0);
    writeWholeFile(target, "root's");
    EXPECT_EQ(status(target).st_uid, 12345u);
    EXPECT_EQ(status(target).st_gid, 23456u);
}

TEST(PartialFile, SweepsWhatAKilledWriterLeft) {
    const samples::Folder folder("partial_sweep");
    const std::filesystem::path target = folder.path / "out";
    const pid_t child = ::fork();
    ASSERT_GE(child, 0);
    if (child == 0) {
        const PartialFile partial(target);
        ::raise(SIGKILL);
    }
    int status = 0;
    ASSERT_EQ(::waitpid(child, &status, 0), child);
    ASSERT_TRUE(WIFSIGNALED(status));
    EXPECT_EQ(folder.entries(), 1u);
    // These files are not ours to sweep: another target's, a living process', and one whose name only looks like a
    // partial file.
    for (const std::string& name :
         {"other.part" + std::to_string(child), "out.part" + std::to_string(::getppid()), std::string("out.partial")})
        writeWholeFile(folder.path / name, "x");
    { const PartialFile partial(target); }
    EXPECT_EQ(folder.entries(), 3u);
    EXPECT_FALSE(std::filesystem::exists(target.string() + ".part" + std::to_string(child)));
}

// Sends SIGTERM to a child that waits in `work`. Returns its exit status; 77 if `work` came to its end.
template <class Work>
int terminate(const Work& work) {
    const pid_t child = ::fork();
    if (child == 0) {
        catchSignals("test");
        ::kill(::getpid(), SIGTERM);
        work();
        ::_exit(77);
    }
    int status = 0;
    ::waitpid(child, &status, 0);
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

TEST(Signals, LoopsSeeTheFlag) {
    testing::internal::CaptureStderr();
    const int status = terminate([] {
        try {
            for (;;) throwIfInterrupted();
        } catch (const std::exception& error) {
            ::_exit(reportFailure("test", error));
        }
    });
    EXPECT_EQ(status, kExitFailed);
    EXPECT_EQ(testing::internal::GetCapturedStderr(), "test: stopped by SIGTERM\n");
}

// Such work has 0.8 s to end by itself.
TEST(Signals, WorkThatNeverLooksIsStoppedAndLeavesNothing) {
    const samples::Folder folder("signal");
    testing::internal::CaptureStderr();
    const int status = terminate([&] {
        const PartialFile partial(folder.path / "out");
        for (int i = 0; i < 100; ++i) std::this_thread::sleep_for(std::chrono::milliseconds(100));
    });
    EXPECT_EQ(status, kExitFailed);
    EXPECT_EQ(testing::internal::GetCapturedStderr(), "test: stopped by a signal\n");
    EXPECT_EQ(folder.entries(), 0u);
}

// --- Errors ---------------------------------------------------------------------------------------------------------

// `penumbra-bake reference` and `penumbra-player render` read their sizes with this function.
TEST(PictureText, SizesAreReadAsScanfAndFromCharsReadThem) {
    for (const char* text : {"640x480", "+640x480", " 640x\t480", "00640x480", "0000640x0000480"}) {
        const auto size = parseSize(text);
        ASSERT_TRUE(size) << text;
        EXPECT_EQ(size->width, 640) << text;
        EXPECT_EQ(size->height, 480) << text;
    }
    EXPECT_EQ(parseSize("-5x3").value().width, -5);  // the range is the caller's
    for (const char* text : {"", "640", "640x", "x480", "640 x480", "640x480 ", "640x480x", "640*480", "6 40x480",
                             "99999999999x1", "99999999999999999999x1", "1.5x2"})
        EXPECT_FALSE(parseSize(text)) << text;
    EXPECT_FALSE(parseSize(std::string("1x2\0", 4)));
}

TEST(PictureText, ColoursAreReadAsScanfAndFromCharsReadThem) {
    for (const char* text : {"0.5/1/2e-1", " +.5/0x1p0/\n0.2", "5e-1/1./.2", "5e-1/1e/.2"})
        EXPECT_EQ(parseColor(text), (Vec3{0.5f, 1, 0.2f})) << text;
    EXPECT_EQ(parseColor("-0/0/1e-60"), Vec3{});
    EXPECT_EQ(parseColor("3e38/3e38/3e38"), (Vec3{3e38f, 3e38f, 3e38f}));
    for (const char* text : {"", "1/1", "1/1/1/1", "1/1/1 ", "1 /1/1", "a/b/c", "-1/0/0", "0/0/nan", "nan/0/0",
                             "inf/0/0", "1e50/0/0", "transparent"})
        EXPECT_FALSE(parseColor(text)) << text;
}

TEST(Errors, ExitCodesAndOneLine) {
    testing::internal::CaptureStderr();
    EXPECT_EQ(reportFailure("p", UsageError("a")), 1);
    EXPECT_EQ(reportFailure("p", IoError("b")), 2);
    EXPECT_EQ(reportFailure("p", InvalidInput("c")), 3);
    EXPECT_EQ(reportFailure("p", std::logic_error("d")), 4);
    EXPECT_EQ(reportFailure("p", Interrupted("e")), 4);
    EXPECT_EQ(reportFailure("p", std::bad_alloc()), 4);
    EXPECT_EQ(reportFailure("p", Unsupported("two\nlines\r\x1b[2J")), 5);
    EXPECT_EQ(testing::internal::GetCapturedStderr(),
              "p: a\np: b\np: c\np: d\np: e\np: out of memory\np: two lines  [2J\n");
}

// --- Provenance -----------------------------------------------------------------------------------------------------

TEST(Provenance, RoundTripAndNamesWithoutFolders) {
    const samples::Folder folder("provenance");
    writeWholeFile(folder.path / "in \"1\".glb", "abc");
    const Provenance made = makeProvenance("tool verb", R"({"z":1,"a":[2,3]})", {folder.path / "in \"1\".glb"});
    EXPECT_EQ(toJson(made), "{\"tool\":\"tool verb\",\"version\":\"" + std::string(penumbraVersion()) +
                                "\",\"options\":{\"z\":1,\"a\":[2,3]},\"inputs\":[{\"name\":\"in \\\"1\\\".glb\","
                                "\"sha256\":\"" +
                                hashOf("abc") + "\"}]}");
    EXPECT_EQ(toJson(provenanceFromJson(toJson(made))), toJson(made));
}

TEST(Provenance, RefusesOtherJson) {
    for (const char* text : {"", "{", "[]", "{}", R"({"tool":1,"version":"","options":{},"inputs":[]})",
                             R"({"tool":"","version":"","options":[],"inputs":[]})",
                             R"({"tool":"","version":"","options":{},"inputs":[{"name":"x"}]})"})
        EXPECT_THROW(provenanceFromJson(text), InvalidInput) << text;
    EXPECT_THROW(provenanceFromJson(std::string(100000, '[')), InvalidInput);
}

// --- parallelFor ----------------------------------------------------------------------------------------------------

TEST(ParallelFor, VisitsEachOnce) {
    for (int threads : {0, 1, 2, 8}) {
        std::vector<std::atomic<int>> visits(1000);
        parallelFor(visits.size(), threads, [&](std::size_t i) { ++visits[i]; });
        EXPECT_TRUE(std::all_of(visits.begin(), visits.end(), [](int n) { return n == 1; })) << threads;
    }
    parallelFor(0, 8, [](std::size_t) { FAIL(); });
}

// Eight bodies that wait for one another end only when eight threads run, however few cores there are.
TEST(ParallelFor, MoreThreadsThanCoresReallyRun) {
    std::atomic<int> running{0};
    const auto limit = std::chrono::steady_clock::now() + std::chrono::seconds(20);
    parallelFor(8, 8, [&](std::size_t) {
        ++running;
        while (running < 8 && std::chrono::steady_clock::now() < limit) std::this_thread::yield();
    });
    EXPECT_LT(std::chrono::steady_clock::now(), limit);
}

TEST(ParallelFor, RethrowsWithItsType) {
    for (int threads : {1, 2, 8})
        EXPECT_THROW(parallelFor(1000, threads,
                                 [](std::size_t i) {
                                     if (i == 321) throw InvalidInput("here");
                                 }),
                     InvalidInput)
            << threads;
}

TEST(ParallelFor, Nests) {
    std::atomic<int> visits{0};
    parallelFor(8, 4, [&](std::size_t) { parallelFor(8, 4, [&](std::size_t) { ++visits; }); });
    EXPECT_EQ(visits, 64);
}

// --- Progress -------------------------------------------------------------------------------------------------------

std::string printed(ProgressStyle style, bool on_stdout) {
    on_stdout ? testing::internal::CaptureStdout() : testing::internal::CaptureStderr();
    {
        Progress progress(style, "bake", "frames", 8);
        for (int i = 1; i <= 8; ++i) progress.update(i);
    }
    return on_stdout ? testing::internal::GetCapturedStdout() : testing::internal::GetCapturedStderr();
}

TEST(Progress, SpeaksTheDialectOfEachFarm) {
    EXPECT_THAT(printed(ProgressStyle::kOpenJd, true),
                testing::MatchesRegex("openjd_progress: 12.5\nopenjd_status: bake .*\nopenjd_progress: 100.0\n.*"));
    EXPECT_EQ(printed(ProgressStyle::kAlf, true), "ALF_PROGRESS 12%\nALF_PROGRESS 100%\n");
    EXPECT_EQ(printed(ProgressStyle::kNone, true), "");
    const std::string bar = printed(ProgressStyle::kBar, false);
    EXPECT_THAT(bar, testing::HasSubstr("bake 100%  8 of 8 frames"));
    EXPECT_EQ(bar.back(), '\n');
}

// --- Halves ---------------------------------------------------------------------------------------------------------

TEST(Fp16, EveryHalfSurvivesTheRoundTrip) {
    for (std::uint32_t bits = 0; bits < 65536; ++bits) {
        const std::uint16_t half = std::uint16_t(bits);
        const float value = halfToFloat(half);
        const bool nan = (bits & 0x7c00u) == 0x7c00u && (bits & 0x3ffu) != 0;
        EXPECT_EQ(std::isnan(value), nan) << bits;
        if (!nan) {
            EXPECT_EQ(floatToHalf(value), half) << bits;
        } else {
            EXPECT_TRUE(std::isnan(halfToFloat(floatToHalf(value)))) << bits;
        }
    }
}

TEST(Fp16, ValuesByDefinition) {
    EXPECT_EQ(halfToFloat(0x3c00), 1.0f);
    EXPECT_EQ(halfToFloat(0xc000), -2.0f);
    EXPECT_EQ(halfToFloat(0x7bff), 65504.0f);
    EXPECT_EQ(halfToFloat(0x0001), 0x1p-24f);
    EXPECT_EQ(halfToFloat(0x0400), 0x1p-14f);
    EXPECT_EQ(floatToHalf(65519.996f), 0x7bff);  // below the middle between 65504 and 65536
    EXPECT_EQ(floatToHalf(65520.0f), 0x7c00);
    EXPECT_EQ(floatToHalf(-INFINITY), 0xfc00);
    EXPECT_EQ(floatToHalf(0x1p-25f), 0x0000);  // a tie goes to even
    EXPECT_EQ(floatToHalf(std::nextafter(0x1p-25f, 1.0f)), 0x0001);
}

// Between any two neighbouring halves the middle goes to the even one, and its float neighbours go to either side.
TEST(Fp16, RoundsToNearestEven) {
    for (std::uint16_t bits = 0; bits < 0x7bff; ++bits) {
        const float low = halfToFloat(bits), high = halfToFloat(std::uint16_t(bits + 1)), middle = (low + high) / 2;
        EXPECT_EQ(floatToHalf(middle), bits % 2 ? bits + 1 : bits);
        EXPECT_EQ(floatToHalf(std::nextafter(middle, 0.0f)), bits);
        EXPECT_EQ(floatToHalf(-std::nextafter(middle, 1e9f)), (bits + 1) | 0x8000);
    }
}

// Every path gives the bits of the single values, whatever the array's length: 100003 values, then fewer than eight.
TEST(Fp16, ArraysAgreeWithSingleValues) {
    std::mt19937 random(1);
    for (const std::size_t count : {std::size_t(100003), std::size_t(7), std::size_t(0)}) {
        std::vector<float> values(count);
        for (float& value : values) value = std::bit_cast<float>(std::uint32_t(random()));
        std::vector<std::uint16_t> halves(values.size());
        std::vector<float> back(values.size());
        for (const HalfPath& path : halfPaths()) {
            path.to_half(values, halves);
            path.to_float(halves, back);
            for (std::size_t i = 0; i < values.size(); ++i) {
                EXPECT_EQ(halves[i], floatToHalf(values[i])) << path.name << ' ' << values[i];
                EXPECT_EQ(std::bit_cast<std::uint32_t>(back[i]), std::bit_cast<std::uint32_t>(halfToFloat(halves[i])));
            }
        }
        std::vector<std::uint16_t> by_name(values.size());
        floatToHalf(values, by_name);
        EXPECT_EQ(by_name, halves);
        halfToFloat(halves, values);
        EXPECT_TRUE(std::equal(values.begin(), values.end(), back.begin(), [](float a, float b) {
            return std::bit_cast<std::uint32_t>(a) == std::bit_cast<std::uint32_t>(b);
        }));
    }
}

TEST(Fp16, NoSimdInTheEnvironmentLeavesThePortablePath) {
    const NoSimd no_simd;
    ASSERT_EQ(halfPaths().size(), 1u);
    EXPECT_STREQ(halfPaths()[0].name, "portable");
}

// --- Mesh -----------------------------------------------------------------------------------------------------------

TEST(Mesh, BoxDiagonal) {
    EXPECT_EQ(boxDiagonal({}), 0);
    EXPECT_EQ(boxDiagonal({{5, 6, 7}}), 0);
    EXPECT_DOUBLE_EQ(boxDiagonal({{1, 0, 0}, {0, 2, 0}, {0, 0, -2}, {0.5f, 0.5f, -1}}), 3);
}

// The expected values are sum_k w_k (M_k p) in double, and for the normal n' ~ det(A) A^-T n, found from two
// tangents: A t1 x A t2.
TEST(Mesh, SkinVerticesMatchesAPlainLoop) {
    Mesh mesh = samples::strip(20);
    mesh.rest_positions = samples::vectors(mesh.vertexCount(), 0.3);
    const Skin skin = samples::twoJoints(mesh);
    std::vector<Vec3> rest_normals = samples::vectors(mesh.vertexCount(), 2), positions, normals;
    for (Vec3& n : rest_normals) n = normalized(n);
    std::vector<Affine> bones = samples::bones(2, 0.8);
    for (Affine& bone : bones)  // far from singular, scaled and sheared
        for (std::size_t i : {0, 5, 10}) bone.m[i] += 2.0f + float(i) / 10;
    skinVertices(mesh, skin, rest_normals, bones, positions, normals);
    ASSERT_EQ(positions.size(), mesh.vertexCount());
    for (std::size_t v = 0; v < mesh.vertexCount(); ++v) {
        std::array<double, 12> m{};
        for (std::size_t k = 0; k < 2; ++k)
            for (std::size_t i = 0; i < 12; ++i)
                m[i] += double(skin.weights[2 * v + k]) * bones[skin.joints[2 * v + k]].m[i];
        const auto apply = [&](Vec3d p, double w) {
            return Vec3d{m[0] * p.x + m[1] * p.y + m[2] * p.z + w * m[3],
                         m[4] * p.x + m[5] * p.y + m[6] * p.z + w * m[7],
                         m[8] * p.x + m[9] * p.y + m[10] * p.z + w * m[11]};
        };
        const Vec3d n = toDouble(rest_normals[v]);
        const Vec3d side = std::abs(n.x) < 0.5 ? Vec3d{1, 0, 0} : Vec3d{0, 1, 0};
        const Vec3d t1 = normalized(cross(side, n)), t2 = cross(n, t1);
        const Vec3d expected_normal = normalized(cross(apply(t1, 0), apply(t2, 0)));
        // Measured 5.0e-7 (coordinates up to 5) and 1.5e-7; the bounds are 3 to 4 times as wide.
        EXPECT_LT(length(toDouble(positions[v]) - apply(toDouble(mesh.rest_positions[v]), 1)), 1.5e-6) << v;
        EXPECT_LT(length(toDouble(normals[v]) - expected_normal), 6e-7) << v;
    }
}

TEST(Mesh, SkinVerticesKeepsRestUnderIdentity) {
    const Mesh mesh = samples::strip(3);
    std::vector<Vec3> positions, normals;
    skinVertices(mesh, samples::twoJoints(mesh), std::vector<Vec3>(mesh.vertexCount(), {0, 0, 1}),
                 std::vector<Affine>(2), positions, normals);
    EXPECT_EQ(positions, mesh.rest_positions);
    EXPECT_EQ(normals, std::vector<Vec3>(mesh.vertexCount(), Vec3{0, 0, 1}));
}

// At the corner of a cube three right triangles of equal area meet, and the normal is the diagonal. Any scale gives
// the same.
TEST(Mesh, VertexNormalsAreAreaWeightedAtAnyScale) {
    for (float scale : {1e-6f, 1e-3f, 1.0f, 1e6f}) {
        const std::vector<Vec3> corner{{0, 0, 0}, {scale, 0, 0}, {0, scale, 0}, {0, 0, scale}, {9 * scale, 0, 0}};
        const std::vector<Triangle> triangles{{0, 2, 1}, {0, 3, 2}, {0, 1, 3}};
        const std::vector<Vec3> normals = vertexNormals(triangles, corner);
        const float third = -1 / std::sqrt(3.0f);
        EXPECT_LT(length(normals[0] - Vec3{third, third, third}), 1e-6f) << scale;
        for (Vec3 n : normals) EXPECT_NEAR(length(n), 1, 1e-6f) << scale;
        EXPECT_GT(normals[4].x, 0.9f) << "a vertex without triangles points away from the centroid";
    }
    EXPECT_EQ(vertexNormals({}, std::vector<Vec3>{{1, 2, 3}})[0], (Vec3{0, 1, 0}));
}

}  // namespace
}  // namespace penumbra::test_common
