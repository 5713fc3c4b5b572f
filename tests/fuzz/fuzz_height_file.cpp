// Feeds bytes to the readers of heights, as the kind that they look like: an array of NumPy, a picture, or, by their
// first byte, the header of raw numbers.
#include <algorithm>

#include "formats/common/errors.h"
#include "formats/height/height_file.h"
#include "formats/height/raw_heights.h"
#include "tests/fuzz/memory_file.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace penumbra;
    try {
        if (size > 0 && (data[0] == 'N' || data[0] == 'n')) {
            (void)parseRawHeader(std::string(reinterpret_cast<const char*>(data), size), "a.hdr");
            return 0;
        }
        const std::filesystem::path path = memoryFile("heights", data, size);
        HeightSource source;
        source.file = path.string() + (size > 0 && data[0] == 0x93  ? ".npy"
                                       : size > 0 && data[0] == 'P' ? ".npz"
                                                                    : ".png");
        source.fill = 0;
        std::filesystem::rename(path, source.file);
        const HeightSequence sequence(source);
        if (sequence.grid().size() > 1 << 20) return 0;
        std::vector<float> heights(sequence.grid().size());
        sequence.read(0, heights);
    } catch (const InvalidInput&) {
    } catch (const Unsupported&) {
    } catch (const IoError&) {
    }
    return 0;
}
