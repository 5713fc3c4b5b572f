#pragma once
// Numbers of a glTF file by their accessors, however they are stored.
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

namespace penumbra {

struct GltfArray {
    std::size_t components = 0;  // numbers of one element
    std::vector<double> values;  // [count, components]; normalised integers are in [-1, 1] already
    std::size_t count() const { return components == 0 ? 0 : values.size() / components; }
};

class GltfNumbers {
public:
    explicit GltfNumbers(const std::filesystem::path& path);  // throws what openGltf() throws
    ~GltfNumbers();
    // `what` names the accessor in messages. Throws InvalidInput for an accessor that does not exist, reaches out of
    // its buffer or has a number that is not finite.
    GltfArray read(std::size_t accessor, const std::string& what) const;

private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace penumbra
