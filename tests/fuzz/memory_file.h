#pragma once
// The bytes of one fuzz case as a file in memory, overwritten by the next case.
#include <unistd.h>

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>

namespace penumbra {

inline std::filesystem::path memoryFile(const std::string& name, const std::uint8_t* data, std::size_t size) {
    const std::filesystem::path path = "/dev/shm/penumbra_fuzz_" + name + std::to_string(::getpid());
    std::ofstream(path, std::ios::binary | std::ios::trunc).write(reinterpret_cast<const char*>(data), long(size));
    return path;
}

}  // namespace penumbra
