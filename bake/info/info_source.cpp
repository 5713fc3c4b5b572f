// Tells what the file of a character or of a cloth holds before it is baked.
#include "bake/info/info_files.h"
#include "formats/common/rest_in_scene.h"
#include "formats/source/source_readers.h"
#include "sh/character_box.h"

namespace penumbra {

namespace {

void describeMesh(const Mesh& mesh, Json& json) {
    json["vertices"] = mesh.vertexCount();
    json["triangles"] = mesh.triangles.size();
    json["source_vertices"] = mesh.source_vertex.size();
    if (!mesh.slots.empty()) json["slots"] = mesh.slots;
}

Json describeRig(const std::filesystem::path& path) {
    const Rig rig = readRig({path});
    Json json{{"format", "rig"}};
    describeMesh(rig.mesh, json);
    const std::vector<Vec3> rest =
        restInScene(rig.mesh.rest_positions, {rig.skin.influences, rig.skin.joints, rig.skin.weights},
                    evaluatePose(rig, -1, 0).bones);
    const BoundingBox box = characterBox(rig.mesh.triangles, rest);
    json["size"] = {box.high.x - box.low.x, box.high.y - box.low.y, box.high.z - box.low.z};
    json["joints"] = rig.skin.joint_names;
    if (!rig.mesh.morphs.names.empty()) json["morph_targets"] = rig.mesh.morphs.names;
    json["clips"] = Json::array();
    for (const Clip& clip : rig.clips) json["clips"].push_back({{"name", clip.name}, {"seconds", clip.duration}});
    json["notes"] = Json::array();
    for (const RigNote& note : rig.notes) json["notes"].push_back(textOf(note));
    for (const RigNote& note : lookNotes(rig)) json["notes"].push_back(textOf(note));
    return json;
}

Json describeCache(const std::filesystem::path& path) {
    const PointCache cache = readPointCache({path}, {});
    Json json{{"format", "point cache"}};
    describeMesh(cache.mesh, json);
    json["clips"] = Json::array();
    for (const PointCacheClip& clip : cache.clips)
        json["clips"].push_back({{"name", clip.name}, {"keys", clip.times.size()}});
    json["notes"] = cache.notes;
    return json;
}

}  // namespace

Json describeSource(const std::filesystem::path& path) {
    return isPointCache(path) ? describeCache(path) : describeRig(path);
}

}  // namespace penumbra
