#pragma once
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace penumbra {

// Tells whether this is a file that may be run.
bool isProgram(const std::filesystem::path& path);

// Returns the folders of PATH, without empty ones.
std::vector<std::filesystem::path> foldersOfPath();

// Returns the absolute path of the program `name` in the first of these folders that has it.
std::optional<std::filesystem::path> findProgram(const std::string& name,
                                                 const std::vector<std::filesystem::path>& folders);

// Returns where another program of ours is: beside this one, else in PATH.
std::optional<std::filesystem::path> findOwnProgram(const std::string& name);

}  // namespace penumbra
