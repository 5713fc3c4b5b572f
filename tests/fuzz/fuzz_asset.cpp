// Any bytes are an asset that the run time can use, or InvalidInput. The content hash is put right first: it would stop
// nearly every input before the checks that are to be tested. An input too short for an asset is replaced by a tiny
// valid one, so that a run needs no corpus.
#include <cstdint>
#include <cstring>

#include "formats/errors.h"
#include "pack/pack_asset.h"
#include "tests/synthetic_model.h"
#include "tests/use_asset.h"

using namespace penumbra;

extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t max_size);

static const std::vector<std::byte>& tinyAsset() {
    static const std::vector<std::byte> bytes = [] {
        const Model model = synthetic::tubeModel(
            {.rings = 2, .segments = 3, .joints = 2, .clusters = 1, .components = 1, .inputs = 1, .frames = 2});
        return packAsset(model, {}, {}, {}, "{}", 1).bytes;
    }();
    return bytes;
}

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t max_size,
                                               unsigned int) {
    const std::vector<std::byte>& tiny = tinyAsset();
    if (size < 64 && max_size >= tiny.size()) {
        std::memcpy(data, tiny.data(), tiny.size());
        size = tiny.size();
    }
    return LLVMFuzzerMutate(data, size, max_size);
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    std::vector<std::byte> bytes(reinterpret_cast<const std::byte*>(data),
                                 reinterpret_cast<const std::byte*>(data) + size);
    sealAsset(bytes);
    try {
        useAsset(openAsset(bytes));
    } catch (const InvalidInput&) {
    }
    return 0;
}
