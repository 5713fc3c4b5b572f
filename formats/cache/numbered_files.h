#pragma once
// Finds files that are numbered one after another: the frames of a sequence.
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace penumbra {

struct NumberedFiles {
    std::string name;  // the text before the number, without a _, - or . at its end; or the folder's name
    std::vector<std::filesystem::path> files;  // by ascending number, none missing
    std::uint64_t step = 1;                    // between the numbers of two neighbouring files
};

// Tells whether the path may name a sequence of files: it is a folder, or a name with one "%d", "%04d", "*" or
// "####".
bool namesSequence(const std::filesystem::path& path);

// Returns the files that `path` names. It may be a pattern, in whose place any digits stand; a folder with one
// sequence of files of these extensions (lower case, ".obj"); or the first file of a sequence (a name without a
// number stands alone). Three or more files may be every second, fifth, ... number, as long as all steps are the
// same. Throws IoError when the folder cannot be read or holds no such file. Throws InvalidInput when no file fits a
// pattern, and when a number is missing or there twice; it names that file.
NumberedFiles findNumberedFiles(const std::filesystem::path& path, const std::vector<std::string>& extensions);

}  // namespace penumbra
