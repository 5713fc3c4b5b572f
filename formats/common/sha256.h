#pragma once
#include <array>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>

namespace penumbra {

// Computes SHA-256 (FIPS 180-4) step by step, with the processor's own instructions where it has them;
// PENUMBRA_NO_SIMD leaves the plain form.
class Sha256 {
public:
    Sha256();
    void update(std::span<const std::byte> bytes);
    std::string hex();  // 64 lower-case digits; call once

private:
    std::array<std::uint32_t, 8> state_;
    std::array<std::uint8_t, 64> block_;
    std::uint64_t length_ = 0;
    bool has_instructions_;
    void compress(const std::uint8_t* block);
};

std::string sha256Hex(std::span<const std::byte> bytes);
std::string sha256OfFile(const std::filesystem::path& path);  // throws IoError

}  // namespace penumbra
