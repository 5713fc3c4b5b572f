// penumbra-player probe S.json --points P.csv -o OUT.csv: what a scene leaves visible at points.
#include <algorithm>
#include <fstream>
#include <memory>
#include <optional>

#include "formats/common/errors.h"
#include "formats/common/write_file.h"
#include "formats/scene/scene_camera.h"
#include "player/cast_flags.h"
#include "player/look_flags.h"
#include "player/player_verbs.h"
#include "player/render/scene_frames.h"
#include "player/scene/probe.h"

namespace penumbra {

namespace {

struct ProbeCommand {
    std::filesystem::path scene, points, output;
    std::optional<double> time;
    CastWay cast;
    SunChoice suns = SunChoice::kAuto;
    int sun_map = kSunMapSize;

    std::vector<std::filesystem::path> inputs() const { return {scene, points}; }
};

std::string textOf(const std::filesystem::path& path) {
    std::ifstream file(path, std::ios::binary);
    if (!file) throw IoError(path.string() + ": cannot be opened");
    std::string text((std::istreambuf_iterator<char>(file)), {});
    if (file.bad()) throw IoError(path.string() + ": cannot be read");
    return text;
}

// Tells whether it is known what members send to others, and light is sent at all.
bool canBeShaded(const PosedScene& scene) {
    return scene.castWay().mode == CastMode::kProduct && scene.light() &&
           std::ranges::none_of(scene.members(), [](const std::unique_ptr<SceneMember>& member) {
               return !member->file->real && member->asset->view.materials.empty();
           });
}

void runProbe(const ProbeCommand& command, const CommonOptions& common, Report& report) {
    report.phase("read");
    const std::vector<ProbePoint> points = parseProbePoints(textOf(command.points), command.points.string());
    SceneDescription description = readScene(command.scene);
    report.willRead(filesNamedIn(description));
    PosedScene scene(std::move(description), command.cast);
    if (command.time) scene.pose(*command.time);
    std::size_t casters = 0;
    for (const std::unique_ptr<SceneMember>& member : scene.members()) casters += member->caster != kNobody;
    report.figures = {{"points", points.size()}, {"members", scene.members().size()}, {"casters", casters}};
    if (common.dry_run) {
        std::printf("would probe %zu points among %zu casters\n", points.size(), casters);
        return;
    }
    report.phase("probe");
    const SceneSuns suns = sceneSuns(scene, command.suns, command.sun_map, common.threads);
    report.figures["suns"] = suns.suns.size();
    std::optional<SceneFrames> frames;
    if (canBeShaded(scene)) {
        RenderOptions options;
        options.suns = command.suns;
        // Any eye serves where the first photograph has no pose: it is for what shines alone.
        if (scene.file().photograph && !SceneCameras(scene.file()).hasPose(0)) options.camera = "yaw=0";
        frames.emplace(scene, options, common.threads);
        frames->evaluateMembers();
        frames->frameCamera();
        frames->shadeMembers();
    }
    const std::vector<ProbeValue> values =
        probe(scene, points, common.threads, suns, frames ? frames->sentLight() : SentLight());
    report.phase("write");
    writeWholeFile(command.output, probeCsv(scene, points, values, suns.suns.size()));
    if (!common.quiet)
        std::printf("%s: %zu points, %zu of %zu characters and props cast\n", command.output.c_str(), points.size(),
                    casters, scene.members().size());
}

void defineProbe(CLI::App& app, ProbeCommand& command) {
    app.add_option("scene", command.scene, "S.json, who stands where (docs/scene.md)")->required();
    app.add_option("--points", command.points, "P.csv: columns x,y,z,nx,ny,nz, metres in the scene")->required();
    app.add_option("-o,--output", command.output, "OUT.csv to write")->required();
    addTimeFlag(app, command.time);
    addCastFlags(app, command.cast);
    addSunFlags(app, command.suns, command.sun_map);
}

}  // namespace

Verb probeVerb() {
    return verbOf<ProbeCommand, const ProbeCommand>(
        "probe", "Compute what the characters of a scene leave visible at points with normals.", defineProbe, runProbe);
}

}  // namespace penumbra
