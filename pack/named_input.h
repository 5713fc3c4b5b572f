#pragma once
// Adds the name of an input to complaints about it.
#include <filesystem>

#include "formats/common/errors.h"

namespace penumbra {

// Runs `work`, whose complaints about its input do not say which file that is, and puts the path before them.
template <class Error = InvalidInput, class Work>
auto naming(const std::filesystem::path& path, Work work) {
    try {
        return work();
    } catch (const Error& error) {
        throw Error(path.string() + ": " + error.what());
    }
}

}  // namespace penumbra
