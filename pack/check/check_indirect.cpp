#include "pack/check/check_indirect.h"

#include <array>
#include <cmath>
#include <vector>

#include "formats/common/errors.h"
#include "formats/common/parallel_for.h"
#include "formats/common/write_file.h"
#include "runtime/evaluate/evaluator.h"
#include "runtime/shade/shading.h"
#include "sh/sh_rotation.h"

namespace penumbra {

namespace {

// Returns the clip and the frame of the asset that a frame of the bake is.
std::pair<const ClipView*, std::size_t> frameOf(const AnimationView& animation, const FrameList& bake, std::size_t f,
                                                const std::string& file) {
    constexpr double kSame = 1e-6;  // seconds
    const std::string& name = bake.clip_names[bake.clip[f]];
    for (const ClipView& clip : animation.clips)
        for (std::size_t i = clip.first_frame; clip.name == name && i < clip.first_frame + clip.frame_count; ++i)
            if (std::abs(animation.times[i] - bake.time[f]) < kSame) return {&clip, i};
    throw InvalidInput(file + ": /frames: clip '" + name + "', " + std::to_string(bake.time[f]) +
                       " s is no frame of the asset");
}

struct Sums {
    double direct = 0, indirect = 0, error = 0;
};

// Adds up one vertex. The local frame keeps the energy of a band, so what the numbers leave out is the rest.
void addVertex(const ColorAxes& axes, std::span<const float> direct, std::span<const float> transfer,
               const ShRotation& to_local, std::span<const float> found, Sums& sums) {
    const std::size_t n2 = transfer.size() / 3;
    std::array<float, 3 * kIndirectCoefficients> local;
    std::array<float, kIndirectSize> coefficients;
    for (std::size_t c = 0; c < 3; ++c)
        apply(to_local, transfer.subspan(c * n2, kIndirectCoefficients),
              std::span(local).subspan(c * kIndirectCoefficients, kIndirectCoefficients));
    toIndirectCoefficients(axes, local, coefficients);
    double all = 0;
    for (const float t : direct) sums.direct += 3.0 * double(t) * t;
    for (const float t : transfer) all += double(t) * t;
    sums.indirect += all;
    for (std::size_t i = 0; i < coefficients.size(); ++i) {
        const double d = double(found[i]) - coefficients[i];
        all += d * d - double(coefficients[i]) * coefficients[i];
    }
    sums.error += std::max(all, 0.0);
}

IndirectCheck figuresOf(const Sums& sums, std::size_t frames) {
    if (!(sums.direct > 0)) return {};
    return {frames, std::sqrt(sums.indirect / sums.direct), std::sqrt(sums.error / sums.direct)};
}

}  // namespace

void checkIndirectFits(const AssetView& asset, const VisibilityHeader& header, const std::string& file) {
    if (!asset.model.indirect)
        throw InvalidInput(asset.name + ": has no light that bounces to check (penumbra-fit indirect)");
    if (!header.hasBounces() || header.order < kIndirectOrder)
        throw InvalidInput(file + ": is no bake of transfer with bounces, of order 3 at least");
    if (header.mesh.vertexCount() != asset.mesh.positions.size())
        throw InvalidInput(file + ": /mesh/rest_positions: " + std::to_string(header.mesh.vertexCount()) +
                           " vertices, the asset has " + std::to_string(asset.mesh.positions.size()));
    for (std::size_t v = 0; v < asset.mesh.positions.size(); ++v)
        if (header.mesh.rest_positions[asset.mesh.shading_point[v]] != asset.mesh.positions[v])
            throw InvalidInput(file + ": /mesh/rest_positions: not those of the asset: another mesh");
    if (asset.model.deforming && asset.animation.playback.positions.empty())
        throw Unsupported(asset.name + ": its frames were left out, so that nothing can be checked");
    for (std::size_t f = 0; f < header.frames.frameCount(); ++f) frameOf(asset.animation, header.frames, f, file);
}

IndirectChecks checkIndirect(const AssetView& asset, const VisibilityReader& bake, const std::string& file,
                             int threads) {
    const VisibilityHeader& header = bake.header();
    checkIndirectFits(asset, header, file);
    Evaluator evaluator(asset);
    const std::size_t vertices = evaluator.vertexCount(), n2 = header.coefficientCount();
    std::vector<Vec3> positions(vertices), normals(vertices), tangents(vertices);
    std::vector<float> found(vertices * kIndirectStride);
    Sums sums[2];
    std::size_t frames[2] = {};
    for (std::size_t f = 0; f < header.frames.frameCount(); ++f) {
        throwIfInterrupted();
        const auto [clip, at] = frameOf(asset.animation, header.frames, f, file);
        evaluator.setFrame(at);
        evaluator.skin(0, vertices, positions, normals, tangents);
        parallelFor(evaluator.clusterCount(), threads, [&](std::size_t c) { evaluator.evaluateIndirect(c, found); });
        const VisibilityFrame truth = bake.readFrame(f);
        for (std::size_t v = 0; v < vertices; ++v) {
            const std::size_t point = asset.mesh.shading_point[v];
            addVertex(asset.model.indirect->axes, std::span(truth.coefficients).subspan(point * n2, n2),
                      std::span(truth.indirect).subspan(3 * point * n2, 3 * n2),
                      makeShRotation(kIndirectOrder, toLocalFrame(normals[v], tangents[v])),
                      std::span(found).subspan(v * kIndirectStride, kIndirectSize), sums[clip->held_out]);
        }
        ++frames[clip->held_out];
    }
    return {figuresOf(sums[0], frames[0]), figuresOf(sums[1], frames[1])};
}

}  // namespace penumbra
