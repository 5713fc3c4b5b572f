#include "formats/asset/asset_file.h"

#include <bit>
#include <cassert>
#include <cstring>

#include "asset_generated.h"
#include "formats/asset/asset_checks.h"
#include "formats/common/errors.h"
#include "formats/common/fp16.h"

namespace penumbra {

static_assert(std::endian::native == std::endian::little, "assets are read in place and are little endian");

std::size_t bytesPerNumber(AssetPrecision precision) {
    switch (precision) {
        case AssetPrecision::kF32:
            return 4;
        case AssetPrecision::kF16:
            return 2;
        case AssetPrecision::kI8:
            return 1;
    }
    return 0;
}

const char* nameOf(AssetPrecision precision) {
    switch (precision) {
        case AssetPrecision::kF32:
            return "f32";
        case AssetPrecision::kF16:
            return "f16";
        case AssetPrecision::kI8:
            return "i8";
    }
    return "";
}

void decode(const NumbersView& numbers, std::span<float> out) {
    assert(out.size() == numbers.count);
    if (numbers.count == 0) return;
    switch (numbers.precision) {
        case AssetPrecision::kF32:
            std::memcpy(out.data(), numbers.data, out.size_bytes());
            break;
        case AssetPrecision::kF16:
            halfToFloat({reinterpret_cast<const std::uint16_t*>(numbers.data), numbers.count}, out);
            break;
        case AssetPrecision::kI8: {
            const auto* bytes = reinterpret_cast<const std::int8_t*>(numbers.data);
            for (std::size_t row = 0; row < numbers.scale.size(); ++row)
                for (std::size_t i = row * numbers.row_length; i < (row + 1) * numbers.row_length; ++i)
                    out[i] = numbers.scale[row] * float(bytes[i]);
            break;
        }
    }
}

std::size_t CompositionView::byteCount() const {
    std::size_t bytes = 0;
    for (const PartFieldView& part : parts) bytes += part.bytes.values.size() + part.bytes.distances.size();
    return bytes;
}

std::uint64_t assetHash(std::span<const std::byte> bytes, std::size_t hash_offset) {
    assert(hash_offset % 8 == 0);
    constexpr std::uint64_t kPrime = 0x100000001b3;
    std::uint64_t hash = 0xcbf29ce484222325;
    std::size_t at = 0;
    for (; at + 8 <= bytes.size(); at += 8) {
        std::uint64_t word;
        std::memcpy(&word, bytes.data() + at, 8);
        hash = (hash ^ (at == hash_offset ? 0 : word)) * kPrime;
    }
    std::uint64_t last = 0;
    std::memcpy(&last, bytes.data() + at, bytes.size() - at);
    if (at < bytes.size()) hash = (hash ^ last) * kPrime;
    return (hash ^ bytes.size()) * kPrime;
}

namespace {

// Tells whether the verifier may look at the bytes: it asserts on sizes that offsets cannot reach.
bool hasSizeOfABuffer(std::span<const std::byte> bytes) {
    return bytes.size() >= 16 && bytes.size() < FLATBUFFERS_MAX_BUFFER_SIZE;
}

// Returns the root table of bytes that the verifier accepts, else null.
const fbs::Asset* verifiedRoot(std::span<const std::byte> bytes) {
    if (!hasSizeOfABuffer(bytes)) return nullptr;
    flatbuffers::Verifier verifier(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size());
    return fbs::VerifyAssetBuffer(verifier) ? fbs::GetAsset(bytes.data()) : nullptr;
}

// Returns what speaks against the version, or "" where the bytes tell none. The verifier knows the fields of our
// version alone, so this looks at nothing but the start of the root table.
std::string versionProblemOf(std::span<const std::byte> bytes) {
    if (!hasSizeOfABuffer(bytes) || !fbs::AssetBufferHasIdentifier(bytes.data())) return "";
    const auto* data = reinterpret_cast<const std::uint8_t*>(bytes.data());
    flatbuffers::Verifier verifier(data, bytes.size());
    const std::size_t root = verifier.VerifyOffset(0);
    const auto* table = reinterpret_cast<const flatbuffers::Table*>(data + root);
    constexpr flatbuffers::voffset_t kVersion = fbs::Asset::VT_FORMAT_VERSION;
    if (root == 0 || !table->VerifyTableStart(verifier) || !table->VerifyField<std::uint16_t>(verifier, kVersion, 2))
        return "";
    return findVersionProblem(kAssetFormat, table->GetField<std::uint16_t>(kVersion, 0));
}

// Returns where content_hash lies in the file; 0 when it is absent.
std::size_t hashOffset(std::span<const std::byte> bytes, const fbs::Asset& asset) {
    const auto* table = reinterpret_cast<const flatbuffers::Table*>(&asset);
    const std::uint8_t* address = table->GetAddressOf(fbs::Asset::VT_CONTENT_HASH);
    return address ? std::size_t(address - reinterpret_cast<const std::uint8_t*>(bytes.data())) : 0;
}

}  // namespace

bool sealAsset(std::span<std::byte> bytes) {
    const fbs::Asset* asset = verifiedRoot(bytes);
    const std::size_t offset = asset ? hashOffset(bytes, *asset) : 0;
    if (offset == 0 || offset % 8 != 0) return false;
    const std::uint64_t hash = assetHash(bytes, offset);
    std::memcpy(bytes.data() + offset, &hash, 8);
    return true;
}

AssetView openAsset(std::span<const std::byte> bytes, std::string_view name) {
    const std::string file(name);
    if (reinterpret_cast<std::uintptr_t>(bytes.data()) % 16 != 0)
        throw InvalidInput(file + ": the bytes of an asset must start at a multiple of 16");
    if (const std::string problem = versionProblemOf(bytes); !problem.empty())
        throw InvalidInput(file + ": " + problem);
    const fbs::Asset* asset = verifiedRoot(bytes);
    if (!asset) throw InvalidInput(file + ": not a Penumbra asset (PNB1), or cut short");
    const std::size_t offset = hashOffset(bytes, *asset);
    if (offset == 0 || offset % 8 != 0 || assetHash(bytes, offset) != asset->content_hash())
        throw InvalidInput(file + ": content_hash does not match: the file is damaged");
    AssetView view = viewOfAsset(*asset, file);
    view.name = file;
    return view;
}

void readTruth(const AssetView& asset, std::size_t frame, std::size_t shading_point, std::span<float> out) {
    const std::size_t n = std::size_t(asset.truth.order) * asset.truth.order;
    assert(asset.has_truth && out.size() == n && shading_point < asset.mesh.positions.size());
    const std::size_t first = (frame * asset.mesh.positions.size() + shading_point) * n;
    if (asset.truth.precision == AssetPrecision::kF32)
        std::memcpy(out.data(), asset.truth.data.data() + 4 * first, 4 * n);
    else
        halfToFloat({reinterpret_cast<const std::uint16_t*>(asset.truth.data.data()) + first, n}, out);
}

void readPositions(const AssetView& asset, std::size_t frame, std::span<Vec3> out) {
    const PlaybackView& playback = asset.animation.playback;
    assert(!playback.positions.empty() && out.size() == asset.mesh.pointCount());
    const std::uint16_t* number = playback.positions.data() + 3 * frame * out.size();
    for (Vec3& p : out)
        for (int i = 0; i < 3; ++i) p[i] = playback.origin[i] + playback.step * float(*number++);
}

}  // namespace penumbra
