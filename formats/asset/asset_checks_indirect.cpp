// The checks of light that bounces.
#include <cmath>

#include "asset_generated.h"
#include "formats/asset/asset_checks.h"
#include "formats/asset/asset_field.h"

namespace penumbra {

namespace {

ColorAxes axesOf(const flatbuffers::Vector<float>* stored, const Field& at) {
    ColorAxes axes;
    const std::span<const float> rows = floatsOf(stored, at, 9);
    std::copy(rows.begin(), rows.end(), axes.m.begin());
    for (int a = 0; a < 3; ++a)
        for (int b = 0; b <= a; ++b) {
            float product = 0;
            for (int c = 0; c < 3; ++c) product += axes(a, c) * axes(b, c);
            at.require(std::abs(product - (a == b ? 1.0f : 0.0f)) < 1e-3f, "has no orthonormal rows");
        }
    return axes;
}

float shareOf(float stored, const Field& at) {
    at.require(std::isfinite(stored), "is not finite");
    return stored;
}

}  // namespace

void setIndirect(const fbs::Model& stored, const Field& model_at, const ReadCluster& read_cluster, ModelView& model) {
    if (!stored.indirect()) return;
    const fbs::Indirect& bounced = *stored.indirect();
    const Field at = model_at / "indirect";
    IndirectView indirect;
    indirect.bounces = bounced.bounces();
    (at / "bounces").require(indirect.bounces > 0, "is 0");
    indirect.axes = axesOf(bounced.color_axes(), at / "color_axes");
    indirect.clusters = sameClustersOf(bounced.clusters(), at / "clusters", model, read_cluster);
    (at / "clusters").require(!indirect.clusters.empty(), "is missing");
    indirect.train_share = shareOf(bounced.train_share(), at / "train_share");
    indirect.holdout_share = shareOf(bounced.holdout_share(), at / "holdout_share");
    indirect.packing_error = shareOf(bounced.packing_error(), at / "packing_error");
    (at / "packing_error").require(indirect.packing_error >= 0, "is below 0");
    model.indirect = std::move(indirect);
}

}  // namespace penumbra
