#pragma once
// Tells why something was refused.
#include <string>

#include "formats/common/errors.h"

namespace penumbra {

// Calls `act`. Returns what its Error says, or "accepted".
template <class Error = InvalidInput, class Act>
std::string refusalBy(const Act& act) {
    try {
        act();
    } catch (const Error& error) {
        return error.what();
    }
    return "accepted";
}

}  // namespace penumbra
