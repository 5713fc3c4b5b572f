#pragma once
// The kinds of failure that a user can cause, and the exit codes that every program shares.
#include <exception>
#include <stdexcept>
#include <string>

namespace penumbra {

enum ExitCode : int {
    kExitOk = 0,
    kExitUsage = 1,
    kExitIo = 2,  // cannot read or write
    kExitInvalidInput = 3,
    kExitFailed = 4,  // failed while running, or stopped by a signal
    kExitUnsupported = 5,
};

struct UsageError : std::runtime_error {
    using std::runtime_error::runtime_error;
};
// A value that cannot be had of an option. Libraries call the option by the field of its struct, as in
// "light_rotation", and the command line makes "--light-rotation" of it.
struct BadOption : UsageError {
    BadOption(const std::string& name, const std::string& what_is_wrong)
        : UsageError(name + ": " + what_is_wrong), option(name), problem(what_is_wrong) {}
    std::string option, problem;
};
struct IoError : std::runtime_error {
    using std::runtime_error::runtime_error;
};
// The input can be read but is wrong. The message starts with the file's name and names the field or node.
struct InvalidInput : std::runtime_error {
    using std::runtime_error::runtime_error;
};
struct Unsupported : std::runtime_error {
    using std::runtime_error::runtime_error;
};
// A signal asked the program to stop (write_file.h).
struct Interrupted : std::runtime_error {
    using std::runtime_error::runtime_error;
};

// Prints one line on stderr, "program: message", and returns the exit code of the error's type (std::bad_alloc
// included).
int reportFailure(const char* program, const std::exception& error) noexcept;

}  // namespace penumbra
