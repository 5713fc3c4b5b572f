#pragma once
// What is behind the handles of penumbra.h, and the border that no exception crosses.
#include <cstdlib>
#include <memory>
#include <mutex>
#include <new>
#include <optional>
#include <string>
#include <vector>

#include "formats/asset/asset_file.h"
#include "formats/common/errors.h"
#include "player/runtime/evaluator.h"
#include "player/runtime/joint_chain.h"
#include "player/runtime/penumbra.h"
#include "player/runtime/shading_layout.h"
#include "player/runtime/shading_set.h"

namespace penumbra {

struct Free {
    void operator()(std::byte* bytes) const { std::free(bytes); }
};

// Shared by the handle and by all that is made of it, so that handles can be given back in any order.
struct AssetData {
    std::optional<MappedFile> file;           // of ..._open_file
    std::unique_ptr<std::byte[], Free> copy;  // of PENUMBRA_COPY
    AssetView view;
    std::string convention;
    // Of a deforming mesh, for each shading point: its vertex, and the first source vertex that is it (kNoSource:
    // none).
    std::vector<std::uint32_t> vertex_of_point, source_of_point;
    static constexpr std::uint32_t kNoSource = 0xffffffff;

    // A character in the rest pose, made by the first caller; copies share what was decoded.
    Evaluator restPose() const;

private:
    mutable std::mutex mutex_;
    mutable std::optional<Evaluator> rest_;
};

penumbra_status report(penumbra_error* error, penumbra_status status, const char* message) noexcept;

// The status of what `body` throws: a wrong call is a UsageError.
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

// UsageError "`name` is NULL".
void requirePointer(const void* pointer, const char* name);
// UsageError unless index < count, or [first, first + count) lies in [0, limit).
void requireIndex(const char* what, std::size_t index, std::size_t limit);
void requireRange(const char* what, std::size_t first, std::size_t count, std::size_t limit);
// UsageError "`name`[i] is not finite".
void requireFinite(const char* name, std::span<const float> numbers);

// The path that `simd` names among those that this processor has, slowest first: AVX2 follows the portable one.
// Unsupported, UsageError.
template <class Path>
const Path& pathOf(penumbra_simd simd, const std::vector<Path>& paths) {
    if (int(simd) < 0 || int(simd) > PENUMBRA_SIMD_AVX2) throw UsageError("simd is no penumbra_simd");
    if (simd == PENUMBRA_SIMD_AVX2 && paths.size() < 2)
        throw Unsupported("this processor has no AVX2, FMA and F16C, or PENUMBRA_NO_SIMD is set");
    return simd == PENUMBRA_SIMD_BEST ? paths.back() : paths[simd == PENUMBRA_SIMD_AVX2];
}

// Vec3 and Affine are plain floats, so that arrays of the caller are used as they are.
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
    std::vector<penumbra::Affine> bones;  // [J] of a pose that did not come as rows of 3x4
    std::vector<penumbra::Vec3> points;   // [Vs] of a deforming mesh
    penumbra::JointChain chain;
};

struct penumbra_shading {
    std::vector<std::shared_ptr<const penumbra::AssetData>> assets;  // whose arrays `view` looks at
    std::vector<float> caller_light;                                 // [order^2, 3] zeros; empty: there is none
    penumbra::AssetView view;                                        // the model with the materials and lights of all
    std::optional<penumbra::ShadingSet> set;
    penumbra::ShadingLayout layout;  // of what a GPU reads
};
