// A program of others runs in a folder of its own, within limits, and everything that it says comes back.
#include <gtest/gtest.h>

#include <chrono>

#include "formats/common/child_process.h"
#include "tests/formats/stage_samples.h"

namespace penumbra::test_run_program {
namespace {

struct RunProgram : testing::Test {
    samples::Folder folder{"run_program"};

    ProgramResult run(const std::string& script, double seconds = 60) const {
        return runProgram({{"/bin/sh", "-c", script}, folder.path, {std::uint64_t(1) << 30, seconds}});
    }
    std::string failure(const ProgramCall& call) const {
        try {
            runProgram(call);
        } catch (const ChildFailed& how) {
            return how.what();
        }
        return "it did not fail";
    }
    std::string failure(const std::string& script, double seconds = 60) const {
        return failure({{"/bin/sh", "-c", script}, folder.path, {std::uint64_t(1) << 30, seconds}});
    }
};

TEST_F(RunProgram, StatusAndOutputComeBack) {
    const ProgramResult result = run("echo out; echo err >&2; cat; exit 7");
    EXPECT_EQ(result.status, 7);
    EXPECT_EQ(result.output, "out\nerr\n");
    EXPECT_EQ(run("head -c 3000000 /dev/zero").output.size(), std::size_t(1) << 20);
    EXPECT_EQ(run("").output, "");
    EXPECT_EQ(run("exec 1>&- 2>&-; sleep 0.1; exit 3").status, 3);  // it goes on without its streams
}

TEST_F(RunProgram, LivesInItsFolder) {
    EXPECT_EQ(run("pwd; echo $HOME; echo $TMPDIR; echo x > here; cat here").output,
              folder.path.string() + "\n" + folder.path.string() + "\n" + folder.path.string() + "\nx\n");
    const std::filesystem::path outside = folder.path.string() + ".outside";
    const ProgramResult result = run("echo x > '" + outside.string() + "'");
    EXPECT_EQ(std::filesystem::exists(outside), !result.confinement.folders);
    std::filesystem::remove(outside);
}

TEST_F(RunProgram, CrashesAndLimitsAreNamed) {
    EXPECT_EQ(failure("kill -SEGV $$"), "signal 11 (Segmentation fault)");
    EXPECT_EQ(failure({{"/nowhere/program"}, folder.path, {1 << 30, 60}}),
              "cannot be started: No such file or directory");
    const auto start = std::chrono::steady_clock::now();
    EXPECT_EQ(failure("sleep 100 & sleep 100", 0.5), "out of time: more than 1 s");
    EXPECT_EQ(failure("exec 1>&- 2>&-; sleep 100", 0.5), "out of time: more than 1 s");
    EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(20));
}

}  // namespace
}  // namespace penumbra::test_run_program
