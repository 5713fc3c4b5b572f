// penumbra-player probe S.json --points P.csv -o OUT.csv: what a scene leaves visible at points.
#include <fstream>

#include "formats/common/errors.h"
#include "formats/common/write_file.h"
#include "player/cast_flags.h"
#include "player/player_verbs.h"
#include "player/scene/probe.h"

namespace penumbra {

namespace {

struct ProbeCommand {
    std::filesystem::path scene, points, output;
    double time = 0;
    const CLI::Option* time_option = nullptr;
    CastFlags cast;
    std::string suns = "auto";
    int sun_map = kSunMapSize;
};

std::string textOf(const std::filesystem::path& path) {
    std::ifstream file(path, std::ios::binary);
    if (!file) throw IoError(path.string() + ": cannot be opened");
    std::string text((std::istreambuf_iterator<char>(file)), {});
    if (file.bad()) throw IoError(path.string() + ": cannot be read");
    return text;
}

void runProbe(const ProbeCommand& command, const CommonOptions& common, Report& report) {
    const CastWay way = command.cast.way();
    const SunChoice choice = parseSuns(command.suns);
    report.phase("read");
    const std::vector<ProbePoint> points = parseProbePoints(textOf(command.points), command.points.string());
    SceneDescription description = readScene(command.scene);
    report.willRead(filesNamedIn(description));
    PosedScene scene(std::move(description), way);
    if (command.time_option->count() > 0) scene.pose(command.time);
    std::size_t casters = 0;
    for (const std::unique_ptr<SceneMember>& member : scene.members()) casters += member->caster != kNobody;
    report.figures = {{"points", points.size()}, {"members", scene.members().size()}, {"casters", casters}};
    if (common.dry_run) {
        std::printf("would probe %zu points among %zu casters\n", points.size(), casters);
        return;
    }
    report.phase("probe");
    const SceneSuns suns = sceneSuns(scene, choice, command.sun_map, common.threads);
    report.figures["suns"] = suns.suns.size();
    const std::vector<ProbeValue> values = probe(scene, points, common.threads, suns);
    report.phase("write");
    writeWholeFile(command.output, probeCsv(scene, points, values, suns.suns.size()));
    if (!common.quiet)
        std::printf("%s: %zu points, %zu of %zu characters and props cast\n", command.output.c_str(), points.size(),
                    casters, scene.members().size());
}

}  // namespace

Verb probeVerb() {
    const auto command = std::make_shared<ProbeCommand>();
    return {"probe",
            "Compute what the characters of a scene leave visible at points with normals.",
            [command](CLI::App& app) {
                app.add_option("scene", command->scene, "S.json, who stands where (docs/scene.md)")->required();
                app.add_option("--points", command->points, "P.csv: columns x,y,z,nx,ny,nz, metres in the scene")
                    ->required();
                app.add_option("-o,--output", command->output, "OUT.csv to write")->required();
                command->time_option =
                    app.add_option("--time", command->time, "seconds into everyone's clip (default: as the scene says)")
                        ->check(CLI::Range(0.0, 1e6))
                        ->default_str("");
                addCastFlags(app, command->cast);
                app.add_option("--suns", command->suns,
                               "whether suns of the scene's light shine past shadow maps: auto, on or off")
                    ->capture_default_str();
                app.add_option("--sun-map", command->sun_map, "texels a side of a sun's shadow map")
                    ->check(CLI::Range(kSmallestSunMap, kLargestSunMap))
                    ->capture_default_str();
            },
            [command] {
                std::vector<std::filesystem::path> inputs = {command->scene, command->points};
                return inputs;
            },
            [command] { return command->output; },
            [command](const CommonOptions& common, Report& report) { runProbe(*command, common, report); }};
}

}  // namespace penumbra
