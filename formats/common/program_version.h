#pragma once
// Tells which program made a file, by the version of Penumbra and a hash of the sources that the program was built
// from. So a program that was changed in any way is another version.
#include <string>
#include <string_view>

namespace penumbra {

// A hash of the contents of all our files that the program is built from (formats/common/source_hash.cmake). Each
// program defines it; no library does.
extern const char* const kSourceHash;

// Call this first in main().
void setSourceHash(std::string_view hash);
// Returns "0.1.0+5d41402abc4b2a76", or "0.1.0" where no hash was set.
std::string programVersion();

}  // namespace penumbra
