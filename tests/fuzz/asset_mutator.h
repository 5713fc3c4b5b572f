#pragma once
// A mutator for the targets that read assets, which falls back to tiny valid ones. Include once a target.
#include <cstdint>
#include <cstring>

#include "tests/fuzz/tiny_inputs.h"

extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t max_size);

// An input too short for an asset is replaced by a tiny valid one, so that a run needs no corpus.
extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t max_size,
                                               unsigned int seed) {
    const auto& assets = penumbra::tinyAssets();
    const std::vector<std::byte>& tiny = assets[seed % assets.size()];
    if (size < 64 && max_size >= tiny.size()) {
        std::memcpy(data, tiny.data(), tiny.size());
        size = tiny.size();
    }
    return LLVMFuzzerMutate(data, size, max_size);
}
