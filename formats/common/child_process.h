#pragma once
// Runs work that may crash in a process of its own.
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <stdexcept>
#include <string>
#include <vector>

#include "formats/common/confine.h"

namespace penumbra {

struct ChildLimits {
    std::uint64_t bytes;  // memory that the child may take beside what this process has, and the longest result
    double seconds;       // time on the clock, and of a processor
};

// The child ended without a result. The message says how: "signal 11 (Segmentation fault)", "out of time: ...".
struct ChildFailed : std::runtime_error {
    using std::runtime_error::runtime_error;
};

// Runs `work` in a child process and returns the bytes that it returns. UsageError, IoError, InvalidInput and
// Unsupported that leave `work` are thrown again here with their text; any other exception becomes a
// std::runtime_error. Throws ChildFailed where the child crashes or passes a limit, and Interrupted where a signal
// stops this process (write_file.h). Nothing that the child prints is seen, and nothing that it changes in memory. The
// bytes come from a process that may have overwritten its own memory: treat them as a hostile file.
std::vector<std::byte> runInChild(const std::function<std::vector<std::byte>()>& work, const ChildLimits& limits);

struct ProgramCall {
    std::vector<std::string> command;  // the program's absolute path, then its arguments
    std::filesystem::path folder;      // absolute: its home and place of temporary files
    ChildLimits limits;
    std::filesystem::path working_folder = {};  // "": `folder`
};
struct ProgramResult {
    int status = 0;      // exit status
    std::string output;  // the first MiB of its stdout and stderr
    Confinement confinement;
};
// Runs another program, confined to its folder (confine.h), with nothing on stdin and an environment of PATH,
// LD_LIBRARY_PATH, HOME and TMPDIR alone. It and what it starts end with this call. Throws ChildFailed where a signal
// ends it, where it cannot be started or where it passes a limit, and Interrupted as above.
ProgramResult runProgram(const ProgramCall& call);

}  // namespace penumbra
