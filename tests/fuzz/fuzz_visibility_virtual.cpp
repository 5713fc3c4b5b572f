// Feeds virtual penumbra.visibility files. The lists of files, hashes and frames are the case's. The rest is good,
// since HDF5's checksums would refuse nearly every other change.
#include "formats/common/errors.h"
#include "formats/common/sha256.h"
#include "formats/stage/visibility_check.h"
#include "formats/stage/visibility_header.h"
#include "tests/formats/stage_samples.h"

namespace {
using namespace penumbra;
namespace fs = std::filesystem;

struct Place {
    fs::path folder = "/dev/shm/penumbra_fuzz_virtual" + std::to_string(::getpid());
    std::vector<std::string> names, sums;  // good shards, one with other vertices, one that is virtual, strange ones
    Place() {
        fs::create_directories(folder);
        for (std::uint32_t quads : {3u, 3u, 5u}) {
            names.push_back("s" + std::to_string(names.size()) + ".vis.h5");
            samples::writeVisibility(folder / names.back(), samples::visibilityHeader(quads, 4), Precision::kFloat32);
            sums.push_back(sha256OfFile(folder / names.back()));
        }
        const VirtualSources sources{{names[0]}, {sums[0]}, {4}, {{0, 0}, {0, 1}, {0, 2}, {0, 3}}};
        names.push_back("virtual.vis.h5");
        writeVirtualVisibility(folder / names[3], samples::visibilityHeader(3, 4), Precision::kFloat32, sources);
        sums.push_back(sha256OfFile(folder / names[3]));
        for (const char* name : {"", ".", "../..", "/dev/null", "none", "s0.vis.h5/x"}) names.push_back(name);
        sums.resize(names.size(), sums[0]);
    }
};

// The bytes of the case, then zeros.
struct Bytes {
    const std::uint8_t *at, *end;
    std::uint8_t next() { return at < end ? *at++ : 0; }
};

void writeIndex(const Place& place, const fs::path& path, Bytes bytes) {
    const VisibilityHeader header = samples::visibilityHeader(3, 1 + bytes.next() % 8);
    Hdf5Handle file = createHdf5(path);
    writeVisibilityHeader(file, header);
    std::vector<std::string> files, sums;
    for (int count = bytes.next() % 5; count > 0; --count) {
        const std::uint8_t which = bytes.next();
        files.push_back(place.names[which % place.names.size()]);
        sums.push_back(which < 250 ? place.sums[which % place.names.size()] : std::string(which - 250, 'a'));
    }
    if (bytes.next() % 16 == 0 && !sums.empty()) sums.pop_back();
    writeStrings(file, "/virtual/files", files);
    writeStrings(file, "/virtual/sha256", sums);
    for (const char* list : {"/virtual/file_of_frame", "/virtual/frame_in_file"}) {
        std::vector<std::int64_t> values;
        for (std::size_t f = header.frames.frameCount() + (bytes.next() % 16 == 0); f > 0; --f) {
            const std::uint8_t value = bytes.next();
            values.push_back(value < 240 ? value % 5 : (std::int64_t(1) << (value - 208)) - 1);
        }
        writeIntegers(file, list, values, {values.size()}, bytes.next() % 16 == 0 ? H5T_STD_I64LE : H5T_STD_U32LE);
    }
    closeHdf5(file);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    static const Place place;
    const fs::path path = place.folder / "index.vis.h5";
    writeIndex(place, path, {data, data + size});
    try {
        const VisibilityReader reader(path);
        checkFrames(reader);
        const std::size_t frames = reader.header().frames.frameCount(), vertices = reader.header().mesh.vertexCount();
        for (std::size_t f = 0; f < frames; ++f) (void)reader.readFrame(f);
        std::vector<float> all(frames * vertices * reader.header().coefficientCount());
        reader.readVertices(0, vertices, all);
    } catch (const InvalidInput&) {
    } catch (const Unsupported&) {
    } catch (const IoError&) {
    }
    return 0;
}
