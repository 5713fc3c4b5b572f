// Any bytes are an asset that every function of the C interface can use, or give PENUMBRA_INVALID_ASSET with a
// sentence. The content hash is put right first, as it would stop nearly every input before the checks under test.
#include <cstdlib>

#include "tests/capi/use_c_api.h"
#include "tests/fuzz/asset_mutator.h"

using namespace penumbra;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    std::vector<std::byte> bytes(reinterpret_cast<const std::byte*>(data),
                                 reinterpret_cast<const std::byte*>(data) + size);
    bytes.reserve(1);  // never NULL
    sealAsset(bytes);
    penumbra_error error;
    const penumbra_status status = capi_test::useBytes(bytes.data(), bytes.size(), &error);
    if (status != PENUMBRA_OK && (status != PENUMBRA_INVALID_ASSET || error.message[0] == 0)) std::abort();
    return 0;
}
