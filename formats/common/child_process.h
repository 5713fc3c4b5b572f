#pragma once
// Runs work that may crash in a process of its own.
#include <cstddef>
#include <cstdint>
#include <functional>
#include <stdexcept>
#include <vector>

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

}  // namespace penumbra
