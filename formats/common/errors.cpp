#include "formats/common/errors.h"

#include <cstdio>
#include <new>

namespace penumbra {

namespace {

int exitCodeOf(const std::exception& error) noexcept {
    if (dynamic_cast<const UsageError*>(&error)) return kExitUsage;
    if (dynamic_cast<const IoError*>(&error)) return kExitIo;
    if (dynamic_cast<const InvalidInput*>(&error)) return kExitInvalidInput;
    if (dynamic_cast<const Unsupported*>(&error)) return kExitUnsupported;
    return kExitFailed;
}

}  // namespace

int reportFailure(const char* program, const std::exception& error) noexcept {
    const bool out_of_memory = dynamic_cast<const std::bad_alloc*>(&error) != nullptr;
    std::fprintf(stderr, "%s: ", program);
    // The output stays on one line whatever the message holds: names in hostile files and libraries' messages have
    // line breaks.
    for (const char* c = out_of_memory ? "out of memory" : error.what(); *c; ++c)
        std::fputc(static_cast<unsigned char>(*c) < ' ' || *c == 127 ? ' ' : *c, stderr);
    std::fputc('\n', stderr);
    return exitCodeOf(error);
}

}  // namespace penumbra
