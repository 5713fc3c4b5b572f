#include "pack/compress/quantize.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstring>

#include "formats/common/errors.h"
#include "formats/common/fp16.h"

namespace penumbra {

namespace {

constexpr float kLargestHalf = 65504;

void toBytes(std::span<const float> values, StoredNumbers& stored) {
    auto* bytes = reinterpret_cast<std::int8_t*>(stored.data.data());
    for (std::size_t first = 0; first < values.size(); first += stored.row_length) {
        const std::span<const float> row = values.subspan(first, stored.row_length);
        float largest = 0;
        for (float v : row) largest = std::max(largest, std::abs(v));
        const float scale = largest / 127;
        stored.scale.push_back(scale);
        // In a row so small that its scale is zero or has lost its digits, zeros are as near.
        const bool usable = scale >= 1e-37f;
        for (std::size_t i = 0; i < row.size(); ++i)
            bytes[first + i] =
                usable ? std::int8_t(std::clamp(std::lround(row[i] / scale), -127L, 127L)) : std::int8_t(0);
    }
}

}  // namespace

StoredNumbers quantize(std::span<const float> values, std::size_t row_length, AssetPrecision precision,
                       const std::string& what) {
    assert(row_length > 0 ? values.size() % row_length == 0 : values.empty());
    StoredNumbers stored{precision, values.size(), row_length, {}, {}};
    stored.data.resize(values.size() * bytesPerNumber(precision));
    const float limit = precision == AssetPrecision::kF16 ? kLargestHalf : std::numeric_limits<float>::max();
    for (float v : values)
        if (!(std::abs(v) <= limit))
            throw InvalidInput(what + ": " + std::to_string(v) + " is not finite or too large for the precision");
    switch (precision) {
        case AssetPrecision::kF32:
            if (!values.empty()) std::memcpy(stored.data.data(), values.data(), values.size_bytes());
            break;
        case AssetPrecision::kF16:
            floatToHalf(values, {reinterpret_cast<std::uint16_t*>(stored.data.data()), values.size()});
            break;
        case AssetPrecision::kI8:
            toBytes(values, stored);
            break;
    }
    return stored;
}

}  // namespace penumbra
