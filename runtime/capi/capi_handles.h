#pragma once
// Defines what is behind the handles of penumbra.h, and the border that no exception crosses.
#include <array>
#include <cstdlib>
#include <memory>
#include <mutex>
#include <new>
#include <optional>
#include <string>
#include <vector>

#include "formats/asset/asset_file.h"
#include "formats/asset/mapped_file.h"
#include "formats/common/errors.h"
#include "runtime/cast/cast_product.h"
#include "runtime/cast/cast_shadow.h"
#include "runtime/cast/field_shadow.h"
#include "runtime/evaluate/evaluator.h"
#include "runtime/evaluate/joint_chain.h"
#include "runtime/papers/refuse_transfer.h"
#include "runtime/penumbra.h"
#include "runtime/shade/shading.h"
#include "runtime/shade/shading_layout.h"
#include "runtime/shade/shading_set.h"
#include "runtime/shade/visibility_transfer.h"
#include "runtime/sun/sun_map.h"
#include "sh/mutex.h"

namespace penumbra {

struct Free {
    void operator()(std::byte* bytes) const { std::free(bytes); }
};

// The handle and all that is made of it share this data, so that handles can be given back in any order.
struct AssetData {
    std::optional<MappedFile> file;           // set by ..._open_file
    std::unique_ptr<std::byte[], Free> copy;  // set by PENUMBRA_COPY
    AssetView view;
    std::string convention;
    // Only for a deforming mesh: for each shading point its vertex, and the first source vertex that it stands for
    // (kNoSource if there is none).
    std::vector<std::uint32_t> vertex_of_point, source_of_point;
    static constexpr std::uint32_t kNoSource = 0xffffffff;

    // Returns a character in the rest pose. The first caller makes it; copies share what was decoded.
    Evaluator restPose() const;
    const VisibilityTransfer& transfer() const { return *transfer_; }  // once there is a rest pose

private:
    mutable Mutex mutex_;
    mutable std::optional<Evaluator> rest_;
    mutable std::optional<VisibilityTransfer> transfer_;
};

// Fills in `error`, unless it is null, and returns `status`.
penumbra_status report(penumbra_error* error, penumbra_status status, const char* message) noexcept;

// Runs `body` and returns the status of what it throws. A UsageError means that the call is wrong.
template <class Body>
penumbra_status guarded(penumbra_error* error, const Body& body) noexcept {
    try {
        body();
        return report(error, PENUMBRA_OK, "");
    } catch (const UsageError& e) {
        return report(error, PENUMBRA_INVALID_ARGUMENT, e.what());
    } catch (const IoError& e) {
        return report(error, PENUMBRA_IO_ERROR, e.what());
    } catch (const InvalidInput& e) {
        return report(error, PENUMBRA_INVALID_ASSET, e.what());
    } catch (const Unsupported& e) {
        return report(error, PENUMBRA_UNSUPPORTED, e.what());
    } catch (const std::bad_alloc&) {
        return report(error, PENUMBRA_OUT_OF_MEMORY, "out of memory");
    } catch (const std::length_error&) {
        return report(error, PENUMBRA_OUT_OF_MEMORY, "more memory is needed than there can be");
    } catch (const std::exception& e) {
        return report(error, PENUMBRA_FAILED, e.what());
    } catch (...) {
        return report(error, PENUMBRA_FAILED, "unknown exception");
    }
}

// Throws UsageError "`name` is NULL", for the first of several.
void requirePointer(const void* pointer, const char* name);
template <class... More>
void requirePointer(const void* pointer, const char* name, More... more) {
    requirePointer(pointer, name);
    requirePointer(more...);
}
// Throw UsageError unless index < limit, or unless [first, first + count) lies in [0, limit).
void requireIndex(const char* what, std::size_t index, std::size_t limit);
void requireRange(const char* what, std::size_t first, std::size_t count, std::size_t limit);
// Throws UsageError where no memory holds `count` elements of `size` bytes. A loop over the caller's array would leave
// it.
void requireCount(const char* name, std::size_t count, std::size_t size);
// Throws UsageError "`name`[i] is not finite".
void requireFinite(const char* name, std::span<const float> numbers);
// Returns a place [3] of the caller. Throws UsageError where it is NULL or not finite.
Vec3 pointFrom(const char* name, const float* place);

// Returns `to_scene` [3,4] of the caller; the identity for NULL. Throws UsageError where it is no rotation and
// translation.
Affine rigidOf(const float* to_scene);

// Throws UsageError where there are no coefficients.
void requireCoefficients(const penumbra_vertices* vertices);
// Returns the vertices, which are some of `all`, with `stride` floats of coefficients each. Throws UsageError where the
// range does not fit, or where there are no positions, normals and tangents.
VertexFrames framesOf(const penumbra_vertices* vertices, std::size_t all, std::size_t stride);

// Returns how many numbers transfer of an order has. Throws UsageError unless it is in
// 1..VisibilityTransfer::kMaxTransferOrder.
std::size_t requireTransferOrder(int order);

// Throws Unsupported where the asset has no light that bounces.
void requireBounces(const AssetView& view);
// Throws UsageError where there is no character or no coefficients, and Unsupported where `bounced` is given and the
// asset has no light that bounces.
void requireCharacter(const penumbra_character* character, const penumbra_vertices* vertices);
// Does the same, and throws for a range that does not fit and for transfer, which others cannot multiply.
void requireReceiver(const penumbra_character* character, const penumbra_vertices* vertices);
// Multiplies what vertices from `first` on see by what others leave visible there, `mirrored` [vertices,
// kFarCoefficients].
void castOn(const penumbra_character& character, const penumbra_vertices& vertices, std::size_t first,
            std::span<const float> mirrored);

// Returns a row-major rotation [3,3] of the caller. Throws UsageError where it is none.
Mat3 rotationFrom(const float* rotation);

// Returns the path that `simd` names among those that this processor has, which stand slowest first: AVX2 follows the
// portable one. Throws Unsupported and UsageError.
template <class Path>
const Path& pathOf(penumbra_simd simd, const std::vector<Path>& paths) {
    if (int(simd) < 0 || int(simd) > PENUMBRA_SIMD_AVX2) throw UsageError("simd is no penumbra_simd");
    if (simd == PENUMBRA_SIMD_AVX2 && paths.size() < 2)
        throw Unsupported("this processor has no AVX2, FMA and F16C, or PENUMBRA_NO_SIMD is set");
    return simd == PENUMBRA_SIMD_BEST ? paths.back() : paths[simd == PENUMBRA_SIMD_AVX2];
}

// Vec3 and Affine are plain floats, so the library can use the caller's arrays as they are.
static_assert(sizeof(Vec3) == 3 * sizeof(float) && sizeof(Affine) == 12 * sizeof(float));
inline std::span<const Vec3> vectors(const float* p, std::size_t n) { return {reinterpret_cast<const Vec3*>(p), n}; }
inline std::span<Vec3> vectors(float* p, std::size_t n) { return {reinterpret_cast<Vec3*>(p), n}; }

}  // namespace penumbra

struct penumbra_asset {
    std::shared_ptr<const penumbra::AssetData> data;
};

struct penumbra_character {
    std::shared_ptr<const penumbra::AssetData> asset;
    penumbra::Evaluator evaluator;
    std::vector<penumbra::Affine> bones;  // [J] of a pose that the caller did not give as rows of 3x4
    std::vector<penumbra::Vec3> points;   // [Vs] of a deforming mesh
    penumbra::JointChain chain;
    penumbra::CastProduct product;
};

struct penumbra_scene {
    std::vector<std::shared_ptr<const penumbra::AssetData>> assets;  // of the casters
    std::vector<penumbra::Evaluator> evaluators;                     // of each caster; only their tables are used
    std::optional<penumbra::CastShadow> cast;
    std::vector<penumbra_caster> casters;  // what the caller may ask for
    penumbra::VisibilityTransfer transfer{{penumbra::BelowHorizon::kMirrored, penumbra::kFieldOrder}};
};

struct penumbra_shading {
    std::vector<std::shared_ptr<const penumbra::AssetData>> assets;  // the assets whose arrays `view` looks at
    std::vector<float> caller_light;  // [order^2, 3] zeros; empty: there is no light of the caller
    penumbra::AssetView view;         // the first asset's model with the materials and lights of all
    std::optional<penumbra::ShadingSet> set;
    penumbra::ShadingLayout layout;  // layout of what a GPU reads
};

struct penumbra_heights {
    penumbra::HeightField field;
    penumbra::HeightVisibility visibility;
    penumbra::HeightTables above;  // of points above the field
    penumbra::Vec3 corner;
    penumbra::CastProduct product;
    std::shared_ptr<const penumbra::AssetData> asset;  // of the look
    std::optional<penumbra::VertexShader> look;
};

struct penumbra_sun_map {
    int size = 0;  // texels a side
    penumbra::SunMaps maps;
    penumbra::SunCasters casters;
};
