// rig_positions RIG... FPS writes every frame's skinned source vertices, for a comparison with an independent
// evaluation. Its stdout is a line of JSON {"clips":[..],"frames":[[clip, seconds],..],"vertices":R}, then F x R x 3
// little-endian floats.
#include <cstdio>
#include <nlohmann/json.hpp>

#include "formats/common/errors.h"
#include "formats/source/source_readers.h"

namespace {

using namespace penumbra;

void writeFrames(const Rig& rig, const FrameList& frames) {
    nlohmann::json header{{"clips", frames.clip_names},
                          {"frames", nlohmann::json::array()},
                          {"vertices", rig.mesh.source_vertex.size()},
                          {"points", rig.mesh.vertexCount()},
                          {"triangles", rig.mesh.triangles.size()},
                          {"influences", rig.skin.influences},
                          {"joints", rig.skin.joint_names}};
    for (std::size_t f = 0; f < frames.frameCount(); ++f) header["frames"].push_back({frames.clip[f], frames.time[f]});
    std::puts(header.dump().c_str());
    RestShape shape;
    for (std::size_t f = 0; f < frames.frameCount(); ++f) {
        const int clip = rig.clips.empty() ? -1 : int(frames.clip[f]);
        const RigPose pose = evaluatePose(rig, clip, frames.time[f]);
        skinMorphed(rig.mesh, rig.skin, rig.rest_normals, {pose.bones, pose.weights}, shape);
        for (const std::uint32_t point : rig.mesh.source_vertex)
            std::fwrite(&shape.positions[point], sizeof(Vec3), 1, stdout);
    }
}

}  // namespace

int main(int argc, char** argv) try {
    if (argc < 3) throw UsageError("usage: rig_positions RIG... FPS");
    const Rig rig = readRig({argv + 1, argv + argc - 1});
    writeFrames(rig, sampleFrames(rig, {}, std::stod(argv[argc - 1])));
    return kExitOk;
} catch (const std::exception& error) {
    return reportFailure("rig_positions", error);
}
