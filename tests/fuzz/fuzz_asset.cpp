// Any bytes are an asset that the run time can use, or give InvalidInput. The content hash is put right first, as it
// would stop nearly every input before the checks under test.
#include "formats/common/errors.h"
#include "tests/fuzz/asset_mutator.h"
#include "tests/use_asset.h"

using namespace penumbra;

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
