// Feeds bytes to the readers of heights, as the kind that they look like: an array of NumPy, a picture, or, by their
// first byte, the header of raw numbers, which an empty line parts from the numbers themselves.
#include <algorithm>
#include <string_view>

#include "formats/common/errors.h"
#include "formats/height/height_file.h"
#include "tests/fuzz/memory_file.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace penumbra;
    try {
        const std::string_view text(reinterpret_cast<const char*>(data), size);
        const bool raw = text.starts_with('N') || text.starts_with('n');
        const std::size_t header = raw ? std::min(text.find("\n\n"), size) : 0,
                          body = raw ? std::min(header + 2, size) : 0;
        const std::filesystem::path path = memoryFile("heights", data + body, size - body);
        HeightSource source;
        source.file = path.string() + (raw                        ? ".bil"
                                       : text.starts_with('\x93') ? ".npy"
                                       : text.starts_with('P')    ? ".npz"
                                       : text.starts_with('v')    ? ".exr"
                                                                  : ".png");
        if (raw) std::filesystem::rename(memoryFile("header", data, header), path.string() + ".hdr");
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
