#include "bake/info/describe.h"

namespace penumbra {

Json describe(const Provenance& provenance) { return Json::parse(toJson(provenance)); }

void addRestBox(Json& json, std::span<const Vec3> positions) {
    if (positions.empty()) return;
    Vec3 low = positions[0], high = low;
    for (const Vec3 p : positions)
        for (int c = 0; c < 3; ++c) low[c] = std::min(low[c], p[c]), high[c] = std::max(high[c], p[c]);
    json["rest_low"] = {low.x, low.y, low.z};
    json["rest_high"] = {high.x, high.y, high.z};
}

Json describe(const Mesh& mesh) {
    Json json{{"vertices", mesh.vertexCount()},
              {"source_vertices", mesh.source_vertex.size()},
              {"triangles", mesh.triangles.size()},
              {"slots", mesh.slots},
              {"rest_diagonal", characterDiagonal(mesh)}};
    addRestBox(json, mesh.rest_positions);
    if (mesh.two_sided) json["two_sided"] = true;
    return json;
}

Json describe(const FrameList& frames) {
    Json clips = Json::array();
    for (std::size_t c = 0; c < frames.clip_names.size(); ++c) {
        const auto [begin, end] = std::equal_range(frames.clip.begin(), frames.clip.end(), std::uint16_t(c));
        Json clip{{"name", frames.clip_names[c]}, {"frames", end - begin}};
        if (begin != end) {
            clip["from_seconds"] = frames.time[std::size_t(begin - frames.clip.begin())];
            clip["to_seconds"] = frames.time[std::size_t(end - frames.clip.begin()) - 1];
        }
        clips.push_back(clip);
    }
    return clips;
}

Json describe(const std::vector<ClipError>& errors) {
    Json list = Json::array();
    for (const ClipError& error : errors)
        list.push_back({{"clip", error.clip},
                        {"held_out", error.held_out},
                        {"relative_error", error.relative_error},
                        {"rms_v", error.rms_v},
                        {"ambient_error", error.ambient_error}});
    return list;
}

}  // namespace penumbra
