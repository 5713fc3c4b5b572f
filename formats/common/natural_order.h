#pragma once
// The order of names with numbers: p.2 stands before p.10.
#include <string_view>

namespace penumbra {

// Tells whether `a` stands before `b`: digits that follow one another count as one number of any length, all else by
// its bytes. Names that differ by leading zeros alone are ordered as texts.
bool naturallyBefore(std::string_view a, std::string_view b);

}  // namespace penumbra
