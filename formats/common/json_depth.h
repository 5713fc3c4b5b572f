#pragma once
#include <string_view>

namespace penumbra {

// Tells whether more than 64 arrays or objects lie within each other. nlohmann's functions recurse with the depth,
// and hostile text must not exhaust the stack.
bool nestedTooDeep(std::string_view json);

}  // namespace penumbra
