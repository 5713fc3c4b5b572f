#pragma once
// Which program made a file: the version of Penumbra and a hash of the sources that the program was built from, so that
// a program that was changed in any way is another version.
#include <string>
#include <string_view>

namespace penumbra {

// Of the contents of all files of ours that the program is built from (formats/common/source_hash.cmake). Defined in
// each program, in no library.
extern const char* const kSourceHash;

// First thing in main().
void setSourceHash(std::string_view hash);
// "0.1.0+5d41402abc4b2a76", "0.1.0" where no hash was set.
std::string programVersion();

}  // namespace penumbra
