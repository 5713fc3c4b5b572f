// Describes an FBX file by its scan.
#include <algorithm>

#include "formats/rig/fbx/fbx_faults.h"

namespace penumbra {

std::vector<FbxCutWeights> cutWeights(const FbxScan& scan) {
    std::vector<FbxCutWeights> cuts;
    for (const FbxGeometry& geometry : scan.geometries) {
        std::vector<std::pair<double, double>> weights;  // vertex, -weight
        for (const FbxSkin& skin : geometry.skins)
            for (const FbxCluster& cluster : skin.clusters)
                for (std::size_t i = 0; i < cluster.vertices.size(); ++i)
                    if (cluster.weights[i] > 0 && cluster.vertices[i] >= 0)
                        weights.push_back({cluster.vertices[i], -cluster.weights[i]});
        std::sort(weights.begin(), weights.end());
        FbxCutWeights cut{geometry.name, 0, 0};
        for (std::size_t first = 0, end = 0; first < weights.size(); first = end) {
            double sum = 0, kept = 0;
            for (; end < weights.size() && weights[end].first == weights[first].first; ++end) {
                sum -= weights[end].second;
                if (end - first < 4) kept -= weights[end].second;
            }
            if (end - first <= 4) continue;
            ++cut.vertices;
            cut.most = std::max(cut.most, 1 - kept / sum);
        }
        if (cut.vertices > 0) cuts.push_back(cut);
    }
    return cuts;
}

namespace {

bool isVisible(const FbxScan& scan, const FbxGeometry& geometry) {
    const auto shown = [&](int model) { return !scan.models[std::size_t(model)].hidden; };
    return geometry.vertices > 0 && std::any_of(geometry.models.begin(), geometry.models.end(), shown);
}

bool hasBones(const FbxGeometry& geometry) {
    for (const FbxSkin& skin : geometry.skins)
        for (const FbxCluster& cluster : skin.clusters)
            if (cluster.model >= 0 && !cluster.vertices.empty()) return true;
    return false;
}

}  // namespace

bool hasVisibleMesh(const FbxScan& scan) {
    return std::any_of(scan.geometries.begin(), scan.geometries.end(),
                       [&](const FbxGeometry& geometry) { return isVisible(scan, geometry); });
}

bool hasVisibleSkin(const FbxScan& scan) {
    return std::any_of(scan.geometries.begin(), scan.geometries.end(),
                       [&](const FbxGeometry& geometry) { return isVisible(scan, geometry) && hasBones(geometry); });
}

bool hasKeys(const FbxScan& scan, int take) {
    for (const FbxTrack& track : scan.tracks)
        if (track.take == take && ((track.model >= 0 && track.property.starts_with("Lcl ")) || track.shapes >= 0) &&
            std::any_of(track.curves.begin(), track.curves.end(),
                        [](const auto& curve) { return curve && curve->varies(); }))
            return true;
    return false;
}

}  // namespace penumbra
