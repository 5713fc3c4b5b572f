// Any bytes as a BRDF table, fits or scattered measurements give a material whose values are finite, or InvalidInput.
#include <cmath>
#include <cstdint>
#include <cstdlib>

#include "formats/brdf/brdf_readers.h"
#include "formats/common/errors.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace penumbra;
    const std::string_view text(reinterpret_cast<const char*>(data), size);
    try {
        const BrdfReading reading = looksLikeFits(text)        ? decodeFits(text, "fuzz", "a")
                                    : looksLikeBrdfTable(text) ? decodeBrdfTable(text, "fuzz")
                                                               : decodeScattered(text, "fuzz", 1);
        const Vec3d f = reading.brdf.eval({0, 0.6, 0.8}, {0.28, 0, 0.96});
        if (!std::isfinite(f.x + f.y + f.z)) std::abort();
    } catch (const InvalidInput&) {
    } catch (const UsageError&) {
    }
    return 0;
}
