// Feeds penumbra.model files; see fuzz_visibility_file.cpp. Run it with -max_len=200000, because the models that it
// starts from are as large.
#include <cstring>

#include "formats/common/errors.h"
#include "formats/stage/model_file.h"
#include "tests/fuzz/memory_file.h"
#include "tests/synthetic_cloth.h"

extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t max_size);

namespace {
using namespace penumbra;

std::string bytesOf(const Model& model) {
    const std::filesystem::path path = memoryFile("seed", nullptr, 0);
    writeModel(path, model);
    std::ifstream in(path, std::ios::binary);
    const std::string bytes{std::istreambuf_iterator<char>(in), {}};
    std::filesystem::remove(path);
    return bytes;
}

// A rig, and cloth of both kinds of features with two sides and inputs.
const std::vector<std::string>& seeds() {
    static const std::vector<std::string> all = {
        bytesOf(synthetic::tubeModel({.rings = 2, .segments = 3, .frames = 2})),
        bytesOf(synthetic::clothModel({.rows = 2, .columns = 3, .frames = 2})),
        bytesOf(synthetic::clothModel({.rows = 2, .columns = 3, .frames = 2, .features = FeatureKind::kDihedrals}))};
    return all;
}
}  // namespace

// Replaces an input that is too short for a model by a valid one, so that a run needs no corpus.
extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t max_size,
                                               unsigned int seed) {
    const std::string& valid = seeds()[seed % seeds().size()];
    if (size < 64 && max_size >= valid.size()) {
        std::memcpy(data, valid.data(), valid.size());
        size = valid.size();
    }
    return LLVMFuzzerMutate(data, size, max_size);
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const std::filesystem::path path = memoryFile("model", data, size);
    try {
        (void)readModel(path);
    } catch (const InvalidInput&) {
    } catch (const Unsupported&) {
    } catch (const IoError&) {
    }
    return 0;
}
