// penumbra.model files; see fuzz_visibility_file.cpp. Run with -max_len=200000: the models that it starts from are as
// large.
#include <cstdint>
#include <cstring>

#include "formats/common/errors.h"
#include "formats/stage/model_file.h"
#include "tests/fuzz/memory_file.h"
#include "tests/fuzz/tiny_inputs.h"

extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t max_size);

using namespace penumbra;

// An input too short for a model is replaced by a valid one, so that a run needs no corpus.
extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t max_size,
                                               unsigned int seed) {
    const std::string& valid = tinyModels()[seed % tinyModels().size()];
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
