// Poses, and what casts: fields of parts, and spheres.
#include "bake/info/info_files.h"
#include "formats/stage/blocker_file.h"
#include "formats/stage/field_file.h"
#include "formats/stage/pose_file.h"

namespace penumbra {

namespace {

Json describePart(const FieldFile& file, std::size_t p) {
    const PartField& part = file.fields.parts[p];
    Json json = Json::object();
    if (!file.joint_names.empty()) json["joint"] = file.partName(p);
    json["radius"] = part.radius;
    const auto size = [](const FieldBox& box) {
        return std::to_string(box.size[0]) + "x" + std::to_string(box.size[1]) + "x" + std::to_string(box.size[2]);
    };
    json["fine_box"] = size(part.boxes[0]);
    json["coarse_box"] = size(part.boxes[1]);
    json["points"] = part.pointCount();
    json["bytes"] = file.fields.values[p].size() + file.fields.distances[p].size();
    return json;
}

// Tells how the mesh of a fields file moves that has no joints.
std::string motionText(const OccluderMotion& motion) {
    if (!motion.follows.empty()) return "follows " + motion.follows;
    return motion.moves ? "moves" : "stands still";
}

}  // namespace

Json describePoses(const std::filesystem::path& path) {
    const PoseFile poses = readPoseFile(path);
    const std::size_t frames = poses.frames.frameCount();
    Json json{{"joints", poses.joint_names.size()}, {"frames", frames}, {"sampled", poses.sampledCount()}};
    // The distance of the frame that was chosen last: all candidates are at most this far from a chosen one.
    if (poses.mixedCount() > 0) json["mixed"] = poses.mixedCount();
    const std::size_t chosen = frames - poses.sampledCount() - poses.mixedCount();
    if (chosen > 0)
        for (std::size_t f = 0; f < frames; ++f)
            if (poses.rank[f] + 1 == chosen) json["last_distance"] = poses.distance[f];
    json["clips"] = describe(poses.frames);
    json["provenance"] = describe(poses.provenance);
    return json;
}

Json describeFields(const std::filesystem::path& path) {
    const FieldFile file = readFieldShard(path);
    const std::size_t count = file.partCount(), first = file.shard ? file.shard->first_part : 0;
    Json json{{"sh_order", kFieldOrder}, {"joints", file.joint_names.size()}, {"vertices", file.vertex_count},
              {"rays", file.rays},       {"fade", file.fields.fade},          {"field_bytes", file.fields.byteCount()},
              {"part_count", count}};
    if (file.joint_names.empty()) json["occluder"] = motionText(file.motion);
    if (file.shard) json["shard"] = std::to_string(first) + ":" + std::to_string(first + file.fields.parts.size());
    json["parts"] = Json::array();
    for (std::size_t p = 0; p < file.fields.parts.size(); ++p) json["parts"].push_back(describePart(file, p));
    // A row a part: its distances in the skeleton from all parts.
    json["steps"] = Json::array();
    for (std::size_t p = 0; p < count; ++p) {
        const auto row = file.steps.begin() + std::ptrdiff_t(p * count);
        json["steps"].push_back(std::vector<int>(row, row + std::ptrdiff_t(count)));
    }
    json["provenance"] = describe(file.provenance);
    return json;
}

Json describeBlockers(const std::filesystem::path& path) {
    const BlockerFile file = readBlockers(path);
    return {{"method", file.method},
            {"joints", file.joint_names.size()},
            {"scale", file.scale},
            {"mesh_area", file.mesh_area},
            {"area", file.area},
            {"blockers", describeSpheres(file.blockers.spheres, file.blockers.joints, file.joint_names)},
            {"provenance", describe(file.provenance)}};
}

}  // namespace penumbra
