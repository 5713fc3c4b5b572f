#pragma once
#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "formats/asset/asset_file.h"

namespace penumbra {

// Numbers as an asset stores them (formats/asset.fbs).
struct StoredNumbers {
    AssetPrecision precision = AssetPrecision::kF32;
    std::size_t count = 0, row_length = 0;
    std::vector<std::byte> data;
    std::vector<float> scale;  // I8: one for each row, largest |value| / 127

    NumbersView view() const { return {precision, count, row_length, data.data(), scale}; }
};

// Rounds to the nearest number that `precision` has. F16: the relative error is <= 2^-11 (the absolute one <= 2^-25
// below 2^-14). I8: the absolute error is <= scale / 2 of the row. values.size() is a multiple of row_length. Throws
// InvalidInput, which starts with `what`, when a value is not finite or too large for half precision.
StoredNumbers quantize(std::span<const float> values, std::size_t row_length, AssetPrecision precision,
                       const std::string& what);

}  // namespace penumbra
