// An importer that crashes, hangs or takes all memory ends as a refusal of its file, and what it hands back is checked.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cmath>
#include <fstream>
#include <functional>
#include <limits>
#include <random>
#include <thread>

#include "formats/common/child_process.h"
#include "formats/common/errors.h"
#include "formats/common/parallel_for.h"
#include "formats/common/write_file.h"
#include "formats/rig/assimp/rig_named_nodes.h"
#include "formats/rig/rig_bytes.h"
#include "formats/rig/rig_import.h"
#include "formats/source/source_readers.h"
#include "tests/formats/rig_samples.h"
#include "tests/formats/stage_samples.h"

namespace penumbra::test_rig_import {
namespace {

using testing::HasSubstr;
using Bytes = std::vector<std::byte>;

// --- A child process ------------------------------------------------------------------------------------------------

constexpr ChildLimits kLimits{std::uint64_t(1) << 30, 60};

// Returns how the child failed.
std::string failure(const std::function<Bytes()>& work, const ChildLimits& limits = kLimits) {
    try {
        runInChild(work, limits);
    } catch (const ChildFailed& how) {
        return how.what();
    } catch (const std::exception& other) {
        return std::string("another kind of error: ") + other.what();
    }
    return "it did not fail";
}

template <class Error>
std::string errorFromChild() {
    try {
        runInChild([]() -> Bytes { throw Error("rig.x: wrong\nin \xc3\xa4"); }, kLimits);
    } catch (const Error& error) {
        return error.what();
    } catch (const std::exception& other) {
        return std::string("another kind of error: ") + other.what();
    }
    return "no error";
}

TEST(ChildProcess, ResultsAndErrorsComeBackAsTheyAre) {
    EXPECT_TRUE(runInChild([] { return Bytes(); }, kLimits).empty());
    Bytes many(5'000'001);  // more than a pipe holds
    for (std::size_t i = 0; i < many.size(); ++i) many[i] = std::byte(i * i);
    EXPECT_TRUE(runInChild([&] { return many; }, kLimits) == many);
    const std::string text = "rig.x: wrong\nin \xc3\xa4";
    EXPECT_EQ(errorFromChild<UsageError>(), text);
    EXPECT_EQ(errorFromChild<IoError>(), text);
    EXPECT_EQ(errorFromChild<InvalidInput>(), text);
    EXPECT_EQ(errorFromChild<Unsupported>(), text);
    EXPECT_EQ(errorFromChild<std::runtime_error>(), text);
}

TEST(ChildProcess, CrashesAreNamed) {
    EXPECT_EQ(failure([]() -> Bytes { std::abort(); }), "signal 6 (Aborted)");
    EXPECT_EQ(failure([]() -> Bytes {
                  ::signal(SIGSEGV, SIG_DFL);
                  ::raise(SIGSEGV);
                  return {};
              }),
              "signal 11 (Segmentation fault)");
    EXPECT_EQ(failure([]() -> Bytes { ::_exit(0); }), "it ended without a result");
    // An exception of another type ends the child, by SIGABRT with g++ 12 and by SIGSEGV with g++ 14.
    EXPECT_THAT(failure([]() -> Bytes { throw 1; }), testing::StartsWith("signal "));
}

TEST(ChildProcess, HangsEndInTime) {
    const auto start = std::chrono::steady_clock::now();
    EXPECT_EQ(failure(
                  []() -> Bytes {
                      for (;;) ::pause();
                  },
                  {1 << 30, 0.6}),
              "out of time: more than 1 s");
    std::atomic<int> turns{0};
    EXPECT_EQ(failure(
                  [&]() -> Bytes {
                      for (;;) ++turns;
                  },
                  {1 << 30, 0.6}),
              "out of time: more than 1 s");
    EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(20));
}

// AddressSanitizer ends a process that gets no memory, and does not ask the new-handler first.
TEST(ChildProcess, MemoryHasALimit) {
    const ChildLimits small{64 << 20, 60};
    const auto take = [](std::size_t bytes) {
        return [=] { return Bytes(bytes / 2, std::byte(1)).empty() ? Bytes() : Bytes(bytes / 2); };
    };
    EXPECT_EQ(runInChild(take(16 << 20), small).size(), std::size_t(8 << 20));
    EXPECT_THAT(failure(take(std::size_t(512) << 20), small),
                testing::AnyOf("out of memory: more than 64 MiB", "it ended without a result"));
    EXPECT_EQ(failure([]() -> Bytes { throw std::bad_alloc(); }, small), "out of memory: more than 64 MiB");
}

TEST(ChildProcess, PrintsNothingAndChangesNothing) {
    testing::internal::CaptureStderr();
    int here = 1;
    EXPECT_EQ(failure([&]() -> Bytes {
                  here = 2;
                  std::fputs("terminate called\n", stderr);
                  std::fflush(stderr);
                  std::abort();
              }),
              "signal 6 (Aborted)");
    EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
    EXPECT_EQ(here, 1);
}

// The ends of the pipe get the numbers of the streams that are closed.
TEST(ChildProcess, WorksWithoutStandardStreams) {
    for (unsigned closed = 1; closed < 8; ++closed) {
        const pid_t program = ::fork();
        if (program == 0) {
            for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO})
                if (closed >> stream & 1) ::close(stream);
            ::_exit(failure([] { return Bytes(100'000); }) == "it did not fail" ? 0 : 1);
        }
        int status = -1;
        ::waitpid(program, &status, 0);
        EXPECT_EQ(status, 0) << "closed " << closed;
    }
}

// Threads of an earlier loop wait for work while the child is made.
TEST(ChildProcess, StartsBesideThreads) {
    parallelFor(8, 4, [](std::size_t) { std::this_thread::sleep_for(std::chrono::milliseconds(5)); });
    for (int i = 0; i < 20; ++i) EXPECT_EQ(runInChild([] { return Bytes(100'000); }, kLimits).size(), 100'000u);
}

// A process that has ended stays as a zombie until whoever inherited it asks for its status.
bool hasEnded(pid_t process) {
    std::ifstream file("/proc/" + std::to_string(process) + "/stat");
    const std::string line{std::istreambuf_iterator<char>(file), {}};
    const std::size_t name_end = line.rfind(')');
    return name_end == std::string::npos || line[name_end + 2] == 'Z' || line[name_end + 2] == 'X';
}

// A program that is stopped while it waits for a child ends at once, with the exit code of a stop, and so does the
// child.
TEST(ChildProcess, EndsWithItsProgram) {
    const samples::Folder folder("child_stop");
    const auto stop = [&](int signal_number) {
        std::filesystem::remove(folder.path / "pid");
        const pid_t program = ::fork();
        if (program == 0) {
            catchSignals("test");
            try {
                runInChild(
                    [&]() -> Bytes {
                        writeWholeFile(folder.path / "pid", std::to_string(::getpid()));
                        for (;;) ::pause();
                    },
                    kLimits);
            } catch (const std::exception& error) {
                ::_exit(reportFailure("test", error));
            }
            ::_exit(77);
        }
        while (!std::filesystem::exists(folder.path / "pid")) std::this_thread::sleep_for(std::chrono::milliseconds(5));
        const pid_t child = pid_t(std::stol(samples::bytesOf(folder.path / "pid")));
        ::kill(program, signal_number);
        int status = 0;
        ::waitpid(program, &status, 0);
        bool gone = false;
        for (int i = 0; i < 2000 && !gone; ++i) {
            gone = hasEnded(child);
            std::this_thread::sleep_for(std::chrono::milliseconds(5));
        }
        EXPECT_TRUE(gone) << "after signal " << signal_number;
        return status;
    };
    testing::internal::CaptureStderr();
    const int stopped = stop(SIGTERM), killed = stop(SIGKILL);
    EXPECT_EQ(testing::internal::GetCapturedStderr(), "test: stopped by SIGTERM\n");
    EXPECT_TRUE(WIFEXITED(stopped) && WEXITSTATUS(stopped) == kExitFailed) << stopped;
    EXPECT_TRUE(WIFSIGNALED(killed));
}

// --- Importers ------------------------------------------------------------------------------------------------------

std::filesystem::path sample(const std::string& name) { return samples::samplePath("swing").replace_filename(name); }

// Returns what `read` says when it refuses, with the kind of the error in front.
std::string refusal(const std::function<void()>& read) {
    try {
        read();
    } catch (const InvalidInput& error) {
        return std::string("invalid: ") + error.what();
    } catch (const Unsupported& error) {
        return std::string("unsupported: ") + error.what();
    } catch (const std::exception& error) {
        return std::string("another kind of error: ") + error.what();
    }
    return "it was read";
}

TEST(RigImport, AChildHandsBackWhatTheImporterMade) {
    for (const char* name : {"swing.x", "swing.dae", "swing.fbx", "swing_pivot.fbx"}) {
        const RigSource here = importWithAssimp(sample(name)),
                        there = importInChild(sample(name), importWithAssimp, kLimits);
        EXPECT_GT(here.parts.size(), 0u) << name;
        EXPECT_GT(here.clips.size(), 0u) << name;
        EXPECT_TRUE(bytesOf(here) == bytesOf(there)) << name;
        EXPECT_EQ(there.file, sample(name));
        EXPECT_THAT(there.files_read, testing::ElementsAre(sample(name)));
    }
}

TEST(RigImport, CrashesAndErrorsNameTheFile) {
    const auto said = [](const RigImporter& importer, const ChildLimits& limits = kLimits) {
        return refusal([&] { importInChild("a.dae", importer, limits); });
    };
    using Path = std::filesystem::path;
    EXPECT_EQ(said([](const Path&) -> RigSource { std::abort(); }),
              "invalid: a.dae: cannot be read (importer crashed): signal 6 (Aborted)");
    EXPECT_EQ(said(
                  [](const Path&) -> RigSource {
                      for (;;) ::pause();
                  },
                  {1 << 30, 0.1}),
              "invalid: a.dae: cannot be read (importer crashed): out of time: more than 0 s");
    EXPECT_EQ(said([](const Path&) -> RigSource { throw std::bad_alloc(); }),
              "invalid: a.dae: cannot be read (importer crashed): out of memory: more than 1024 MiB");
    EXPECT_EQ(said([](const Path& path) -> RigSource { failAtFile(path, "has no keys"); }),
              "invalid: a.dae: has no keys");
    EXPECT_EQ(said([](const Path& path) -> RigSource { throw Unsupported(path.string() + ": too many"); }),
              "unsupported: a.dae: too many");
}

// assimp 5.2 reads past an array in both, the first of which is valid. What comes of it depends on the memory behind: a
// crash, other weights or, in a later assimp, the right rig. The program lives on and names the file.
TEST(RigImport, FilesThatCrashAssimpAreRefused) {
    const std::filesystem::path folder = testing::TempDir(), dae = folder / "crash.dae", x = folder / "crash.x";
    std::string text = samples::readText(sample("swing.dae"));
    text.insert(text.find("<v>") + 3, "\n");
    samples::writeText(dae, text);
    EXPECT_THAT(refusal([&] { readRig({dae}); }),
                testing::AnyOf(testing::StartsWith("invalid: " + dae.string() + ": "), "it was read"));
    samples::writeText(x, R"(xof 0303txt 0032
Frame Root {
 Mesh M {
  3; 0.0;0.0;0.0;, 1.0;0.0;0.0;, 0.0;1.0;0.0;;
  1; 3;0,1,2;;
  XSkinMeshHeader { 1; 1; 1; }
  SkinWeights { "Root"; 1; 4000000000; 1.0; 1.0,0.0,0.0,0.0,0.0,1.0,0.0,0.0,0.0,0.0,1.0,0.0,0.0,0.0,0.0,1.0;; }
 }
}
)");
    EXPECT_THAT(refusal([&] { readRig({x}); }), testing::StartsWith("invalid: " + x.string() + ": "));
}

// A bone without vertices, on which assimp's reader of text fails.
TEST(RigImport, BonesOfNoVertexAreRead) {
    const std::filesystem::path x = std::filesystem::path(testing::TempDir()) / "zero.x";
    const std::string matrix = "1.0,0.0,0.0,0.0,0.0,1.0,0.0,0.0,0.0,0.0,1.0,0.0,0.0,0.0,0.0,1.0;; }";
    samples::writeText(x, "xof 0303txt 0032\nFrame Root {\n Frame Tip { FrameTransformMatrix { " + matrix +
                              " }\n Mesh M {\n 3; 0.0;0.0;0.0;, 1.0;0.0;0.0;, 0.0;1.0;0.0;;\n 1; 3;0,1,2;;\n" +
                              " XSkinMeshHeader { 1; 1; 2; }\n SkinWeights { \"Tip\"; 0; ; ; " + matrix +
                              "\n SkinWeights { \"Root\"; 3; 0, 1, 2; 1.0, 1.0, 1.0; " + matrix + "\n }\n}\n");
    EXPECT_THAT(readRig({x}).skin.joint_names, testing::ElementsAre("Root"));
}

// Two nodes have the name of a bone. The bone is the one at which the mesh was bound.
TEST(RigImport, BonesAreFoundByTheirPlaceWhereNamesAreEqual) {
    RigSource source;
    source.file = "two.fbx";
    NamedNodes named;
    for (const double x : {0.0, 1.0, 2.0}) {
        Node& node = source.nodes.emplace_back();
        node.name = x == 2 ? "body" : "head";
        node.translation = {x, 0, 0};
        named.emplace(node.name, int(x));
    }
    Matrix inverse_bind = kIdentityMatrix;
    inverse_bind[3] = 1;  // at bind the mesh stands at 2, and the bone at 1
    EXPECT_EQ(nodeOfBone(source, named, {"head", inverse_bind, 2}), 1);
    EXPECT_EQ(nodeOfBone(source, named, {"tail", inverse_bind, 2}), -1);
    inverse_bind[3] = 5;
    EXPECT_THROW(nodeOfBone(source, named, {"head", inverse_bind, 2}), Unsupported);
    EXPECT_THROW(nodeOfChannel(source, named, "head"), Unsupported);
    source.skins.push_back({{1}, {kIdentityMatrix}});
    EXPECT_EQ(nodeOfChannel(source, named, "head"), 1);
    EXPECT_EQ(source.notes.size(), 1u);
    EXPECT_EQ(nodeOfChannel(source, named, "body"), 2);
}

TEST(RigImport, WordsOfAssimpStayAsTheyAre) {
    for (const char* name : {"nonsense.x", "nonsense.dae"}) {
        const std::filesystem::path path = std::filesystem::path(testing::TempDir()) / name;
        samples::writeText(path, "nonsense");
        const std::string here = refusal([&] { importWithAssimp(path); });
        EXPECT_THAT(here, testing::StartsWith("invalid: " + path.string() + ": cannot be read: "));
        EXPECT_EQ(refusal([&] { readRig({path}); }), here);
    }
}

// --- What a child hands back ----------------------------------------------------------------------------------------

TEST(RigBytes, EveryTruncationIsNoticed) {
    const Bytes whole = bytesOf(importWithAssimp(sample("swing.dae")));
    ASSERT_NO_THROW(rigFromBytes(whole));
    for (std::size_t n = 0; n < whole.size(); n += n < 300 ? 1 : 37)
        EXPECT_THROW(rigFromBytes(Bytes(whole.begin(), whole.begin() + std::ptrdiff_t(n))), std::out_of_range) << n;
    Bytes longer = whole;
    longer.push_back({});
    EXPECT_THROW(rigFromBytes(longer), std::out_of_range);
}

TEST(RigBytes, PartsShareTheirTextures) {
    RigSource source;
    source.parts.resize(4);
    const auto textureOf = [](const char* name) {
        return std::make_shared<const Texture>(Texture{name, {}, Bytes(100'000, std::byte(7))});
    };
    source.parts[0].color.material.texture = source.parts[2].color.material.texture = textureOf("atlas");
    source.parts[3].color.material.texture = textureOf("paint");
    const Bytes bytes = bytesOf(source);
    EXPECT_LT(bytes.size(), 202'000u);
    const RigSource read = rigFromBytes(bytes);
    const auto texture = [&](std::size_t part) { return read.parts.at(part).color.material.texture; };
    ASSERT_TRUE(texture(0) && texture(3));
    EXPECT_EQ(texture(0), texture(2));
    EXPECT_EQ(texture(1), nullptr);
    EXPECT_EQ(texture(0)->name, "atlas");
    EXPECT_EQ(texture(3)->name, "paint");
    EXPECT_EQ(texture(3)->bytes, source.parts[3].color.material.texture->bytes);
}

// A child that has overwritten its memory may hand back anything.
TEST(RigBytes, DamagedOnesAreRefusedOrSound) {
    RigSource source = importWithAssimp(sample("swing_pivot.fbx"));
    source.parts[0].triangles.resize(4);  // few triangles, so that damage reaches more than positions
    const Bytes whole = bytesOf(source);
    std::mt19937 random(7);
    int refused = 0;
    for (int i = 0; i < 3000; ++i) {
        Bytes bytes = whole;
        for (unsigned k = 0; k < 1 + random() % 4; ++k)
            bytes[random() % bytes.size()] = std::byte(random() >> (random() % 24));
        try {
            RigSource read = rigFromBytes(bytes);
            checkSource(read);
            collapseFbxPivots(read);
        } catch (const std::out_of_range&) {
            ++refused;
        } catch (const InvalidInput&) {
            ++refused;
        }
    }
    EXPECT_GT(refused, 300);
}

TEST(RigBytes, EachWrongNumberIsNamed) {
    const float nan = std::numeric_limits<float>::quiet_NaN();
    const std::string crashed = "cannot be read (importer crashed): an index or a count is wrong";
    const std::vector<std::pair<std::string, std::function<void(RigSource&)>>> cases = {
        {crashed, [](RigSource& s) { s.nodes[1].parent = 1; }},
        {crashed, [](RigSource& s) { s.nodes[0].parent = -2; }},
        {"its transform is not finite", [&](RigSource& s) { s.nodes[1].rotation[2] = double(nan); }},
        {crashed, [](RigSource& s) { s.skins[0].nodes[0] = 1000; }},
        {crashed, [](RigSource& s) { s.skins[0].nodes.pop_back(); }},
        {"its bind matrix is not finite", [&](RigSource& s) { s.skins[0].inverse_bind[1][3] = double(nan); }},
        {crashed, [](RigSource& s) { s.parts[0].node = -1; }},
        {crashed, [](RigSource& s) { s.parts[0].skin = 1; }},
        {crashed, [](RigSource& s) { s.parts[0].joints[2] = 2; }},
        {crashed, [](RigSource& s) { s.parts[0].weights.pop_back(); }},
        {crashed, [](RigSource& s) { s.parts[0].influences = -1; }},
        {crashed, [](RigSource& s) { s.parts[0].color.uv.resize(3); }},
        {crashed, [](RigSource& s) { s.parts[0].color.material.wrap_v = TextureWrap(3); }},
        {"names a vertex that does not exist",
         [](RigSource& s) { s.parts[0].triangles[5][2] = std::uint32_t(s.parts[0].positions.size()); }},
        {"vertex 7 is not finite", [&](RigSource& s) { s.parts[0].positions[7].y = nan; }},
        {crashed, [](RigSource& s) { s.clips[0].channels[0].node = 1000; }},
        {crashed, [](RigSource& s) { s.clips[0].channels[0].values.pop_back(); }},
        {crashed, [](RigSource& s) { s.clips[0].channels[0].path = Channel::Path(3); }},
        {crashed, [](RigSource& s) { s.clips[0].channels[0].interpolation = Interpolation::kCubicSpline; }},
        {crashed, [](RigSource& s) { s.nodes[std::size_t(s.clips[0].channels[0].node)].matrix.emplace(); }},
        {crashed, [](RigSource& s) { s.clips[0].channels[0].times.clear(); }},
        {crashed, [&](RigSource& s) { s.clips[0].duration = double(nan); }},
        {"key times do not ascend",
         [](RigSource& s) { s.clips[0].channels[0].times[1] = s.clips[0].channels[0].times[0]; }},
        {"key times do not ascend", [&](RigSource& s) { s.clips[0].channels[0].times.back() = double(nan); }},
        {"a key is not finite", [&](RigSource& s) { s.clips[0].channels[0].values[1] = nan; }},
        {"a key is a quaternion of length 0",
         [](RigSource& s) {
             for (Channel& channel : s.clips[0].channels)
                 if (channel.path == Channel::Path::kRotation) std::fill_n(channel.values.begin() + 4, 4, 0.0f);
         }},
    };
    RigSource whole = importWithAssimp(sample("swing.dae"));
    ASSERT_NO_THROW(checkSource(whole));
    for (std::size_t i = 0; i < cases.size(); ++i) {
        RigSource source = whole;
        cases[i].second(source);
        const std::string said = refusal([&] { checkSource(source); });
        EXPECT_THAT(said, testing::StartsWith("invalid: " + whole.file.string() + ": ")) << "case " << i;
        EXPECT_THAT(said, testing::EndsWith(cases[i].first)) << "case " << i;
    }
}

}  // namespace
}  // namespace penumbra::test_rig_import
