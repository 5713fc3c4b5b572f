#pragma once
// Reads arrays as NumPy's save() writes them (.npy, versions 1 to 3): row-major numbers of either byte order.
#include <string>
#include <vector>

#include "formats/common/random_bytes.h"

namespace penumbra {

struct NumpyArray {
    std::string what;  // for messages: "FILE: 'verts'"
    char kind = 'f';   // f, i (signed), u (unsigned)
    int item_size = 4;
    bool swapped = false;              // the file's byte order is not this machine's
    std::vector<std::uint64_t> shape;  // empty: a single number
    RandomBytes data;                  // the numbers and nothing else

    std::uint64_t count() const {
        std::uint64_t n = 1;
        for (const std::uint64_t size : shape) n *= size;
        return n;
    }
};

// Opens an array. Throws InvalidInput where the header is wrong or the data are not as many bytes as it says. Throws
// Unsupported for column-major order and for types other than f4, f8 and integers of 1 to 8 bytes.
NumpyArray openNumpy(const RandomBytes& bytes, const std::string& what);

// Returns numbers first ... first + count - 1, and rounds integers beyond 2^53. Any number of threads may call it.
std::vector<double> readNumbers(const NumpyArray& array, std::uint64_t first, std::size_t count);

// Describes the array for messages: "f4 [600,5041,3]".
std::string describe(const NumpyArray& array);

}  // namespace penumbra
