#pragma once
// Light that bounces for synthetic models: made-up clusters with the sizes of fitted ones.
#include "tests/synthetic_model.h"

namespace penumbra::synthetic {

// Adds light that bounces. Its mean is about a tenth of what an open vertex gets from the sky.
inline void addIndirect(Model& model) {
    Noise noise(23);
    IndirectModel indirect;
    indirect.bounces = 3;
    const float a = 0.48f, b = 0.6f, c = 0.64f;  // a^2 + b^2 + c^2 = 1
    const Vec3 first{a, b, c}, second = normalized(cross(first, Vec3{0, 0, 1}));
    indirect.axes = fromRows(first, second, cross(first, second));
    indirect.train_share = 0.02;
    indirect.holdout_share = 0.03;
    for (const ClusterModel& own : model.clusters) {
        ClusterModel cluster = own;
        const std::size_t rows = own.vertices.size() * kIndirectSize;
        fillNoise(cluster.mean, rows, 0.1f, noise);
        for (std::size_t v = 0; v < rows; v += kIndirectSize) cluster.mean[v] += 0.5f;
        fillNoise(cluster.basis, own.components() * rows, 0.1f, noise);
        indirect.clusters.push_back(std::move(cluster));
    }
    model.indirect = std::move(indirect);
}

inline Model litTube(const TubeOptions& options = {}) {
    Model model = tubeModel(options);
    addIndirect(model);
    return model;
}

}  // namespace penumbra::synthetic
