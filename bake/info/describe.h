#pragma once
// Describes what stands in several kinds of files, as JSON. It goes into --report and is also printed line by line.
#include <algorithm>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

#include "formats/common/mesh.h"
#include "formats/common/model_kind.h"
#include "formats/common/provenance.h"
#include "formats/stage/model_file.h"
#include "sh/angles.h"
#include "sh/far/part_field.h"

namespace penumbra {

using Json = nlohmann::ordered_json;

Json describe(const Provenance& provenance);
Json describe(const Mesh& mesh);
Json describe(const FrameList& frames);  // describes the clips
Json describe(const std::vector<ClipError>& errors);
// Adds the corners of the box around the rest positions. Who places a mesh in a scene asks where its feet are.
void addRestBox(Json& json, std::span<const Vec3> positions);
// Names a model, or that of an asset, by the words that the fit took.
template <class Model>
Json describeKind(const Model& model) {
    if (!model.composition) return {{"model", nameOf(model.kind)}};
    return {{"model", "composed"}, {"local_model", nameOf(model.kind)}};
}

// Tells what a composed model multiplies and adds. `residual` has the clusters of the residual, or none.
template <class Clusters, class Number>
Json describeComposition(int local_steps, std::size_t parts, std::size_t field_bytes, const Clusters& residual,
                         Number components) {
    Json json{
        {"parts", parts}, {"local_steps", local_steps}, {"field_bytes", field_bytes}, {"residual", !residual.empty()}};
    std::size_t sum = 0;
    for (const auto& cluster : residual) sum += components(cluster);
    if (!residual.empty()) json["residual_components"] = double(sum) / double(residual.size());
    return json;
}

// Adds what there is of near parts: how many a vertex has at most, and the bytes of their gains.
template <class Composed>
void addNearParts(const Composed& composed, Json& json) {
    if (composed.near_count > 0)
        json.update({{"near_parts", composed.near_count}, {"near_gain_bytes", composed.near_gains.size()}});
}

// Returns the name of a part's joint, "(still)" for an occluder that stands still.
template <class Names>
std::string partName(const PartField& part, const Names& joint_names) {
    return part.joint == kStillJoint ? "(still)" : std::string(joint_names[part.joint]);
}

// Tells what light that bounces has, of an asset and of a model. A share below 0 was not measured.
template <class Indirect, class Number>
Json describeBounced(const Indirect& indirect, std::size_t bytes, std::size_t vertices, Number components) {
    std::size_t sum = 0;
    for (const auto& cluster : indirect.clusters) sum += components(cluster);
    Json json{{"bounces", indirect.bounces},
              {"sh_order", kIndirectOrder},
              {"clusters", indirect.clusters.size()},
              {"components", double(sum) / double(indirect.clusters.size())},
              {"bytes", bytes},
              {"bytes_per_vertex", double(bytes) / double(vertices)},
              {"share_of_direct", {{"train", indirect.train_share}}}};
    if (indirect.holdout_share >= 0) json["share_of_direct"]["held_out"] = indirect.holdout_share;
    return json;
}

Json describeSuns(const auto& suns) {
    Json json = Json::array();
    for (const auto& sun : suns)
        json.push_back({{"direction", {sun.direction.x, sun.direction.y, sun.direction.z}},
                        {"irradiance", {sun.irradiance.x, sun.irradiance.y, sun.irradiance.z}},
                        {"radius_degrees", degrees(sun.radius)}});
    return json;
}

// Lists each sphere with its joint. Of an asset and of a blockers file.
template <class Spheres, class Joints, class Names>
Json describeSpheres(const Spheres& spheres, const Joints& joints, const Names& joint_names) {
    Json json = Json::array();
    for (std::size_t s = 0; s < spheres.size(); ++s) {
        const Vec3 center = spheres[s].center;
        json.push_back({{"joint", joint_names[joints[s]]},
                        {"center", {center.x, center.y, center.z}},
                        {"radius", spheres[s].radius}});
    }
    return json;
}

}  // namespace penumbra
