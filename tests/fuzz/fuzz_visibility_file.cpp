// Feeds penumbra.visibility files. HDF5 reads files instead of memory, so the bytes go through one in /dev/shm.
#include "formats/common/errors.h"
#include "formats/stage/visibility_file.h"
#include "tests/fuzz/memory_file.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const std::filesystem::path path = penumbra::memoryFile("visibility", data, size);
    try {
        const penumbra::VisibilityReader reader(path);
        for (std::size_t f = 0; f < std::min<std::size_t>(reader.header().frames.frameCount(), 3); ++f)
            (void)reader.readFrame(f);
        if (const auto& local = reader.header().local) {
            std::vector<float> first(reader.header().frames.frameCount() * local->coefficientCount());
            reader.readLocalVertices(0, 1, first);
        }
    } catch (const penumbra::InvalidInput&) {
    } catch (const penumbra::Unsupported&) {
    } catch (const penumbra::IoError&) {
    }
    return 0;
}
