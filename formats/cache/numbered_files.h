#pragma once
// Files that are numbered one after another: the frames of a sequence.
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace penumbra {

struct NumberedFiles {
    std::string name;  // what stands before the number, without the _, - or . at its end; or the folder's name
    std::vector<std::filesystem::path> files;  // by ascending number, none missing
    std::uint64_t step = 1;                    // between the numbers of two files
};

// May the path name a sequence of files rather than one: a folder, or a name with one "%d", "%04d", "*" or "####"?
bool namesSequence(const std::filesystem::path& path);

// The files that `path` names, one of: a pattern, in whose place any digits stand; a folder with one sequence of files
// of these extensions (lower case, ".obj"); one of the files, which is the first (a name without a number is alone).
// Three files and more may be every second, fifth, ... number, where all steps are the same.
// IoError: the folder cannot be read or holds no such file. InvalidInput: no file of a pattern, a number that is
// missing or there twice (by name).
NumberedFiles findNumberedFiles(const std::filesystem::path& path, const std::vector<std::string>& extensions);

}  // namespace penumbra
