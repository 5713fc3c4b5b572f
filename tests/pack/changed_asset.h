#pragma once
// These helpers tell what a reader says of an asset whose bytes were changed or cut short.
#include <gtest/gtest.h>

#include <span>
#include <string>
#include <vector>

#include "asset_generated.h"
#include "formats/asset/asset_file.h"
#include "tests/refusal.h"
#include "tests/use_asset.h"

namespace penumbra {

// Opens and uses an asset. Returns why it was refused, or "accepted".
inline std::string refusalOf(std::span<const std::byte> bytes) {
    return refusalBy([&] { useAsset(openAsset(bytes, "x.pnb")); });
}

// Does so after a change through the generated accessors, with the hash put right.
template <class Change>
std::string refusalOf(std::vector<std::byte> bytes, const Change& change) {
    change(*fbs::GetMutableAsset(bytes.data()));
    EXPECT_TRUE(sealAsset(bytes));
    return refusalOf(bytes);
}

// Expects that the whole is opened, and that no beginning of it is, in steps of `step` bytes.
inline void expectTruncationsRefused(std::span<const std::byte> whole, std::size_t step = 1) {
    ASSERT_NO_THROW(openAsset(whole));
    for (std::size_t n = 0; n < whole.size(); n += step) {
        const std::vector<std::byte> cut(whole.data(), whole.data() + n);  // a copy: ASan sees any overread
        EXPECT_THROW(openAsset(cut), InvalidInput) << "first " << n << " bytes";
    }
}

}  // namespace penumbra
