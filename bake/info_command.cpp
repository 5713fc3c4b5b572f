// penumbra-bake info FILE: what is in a Penumbra file of any kind, who made it and from what; or what a rig holds.
#include <array>
#include <fstream>
#include <memory>

#include "bake/bake_verbs.h"
#include "bake/common/print_json.h"
#include "bake/info/info_files.h"
#include "formats/asset/asset_file.h"
#include "formats/common/errors.h"
#include "formats/source/source_readers.h"
#include "formats/stage/stage_file_kind.h"

namespace penumbra {
namespace {

namespace fs = std::filesystem;

Json describeFile(const fs::path& path, VertexSample sample) {
    std::array<char, 8> head{};
    std::ifstream(path, std::ios::binary).read(head.data(), head.size());
    Json json{{"file", path.string()}, {"bytes", fs::file_size(path)}};
    if (findReader(path)) {
        json.update(describeSource(path));
        return json;
    }
    std::string format = "penumbra.asset";
    Json content;
    if (std::string_view(head.data() + 4, 4) == kAssetIdentifier) {
        content = describeAsset(path);
    } else {
        format = stageFileKind(path);
        if (format == "penumbra.visibility") content = describeVisibility(path, sample);
        if (format == "penumbra.model") content = describeModel(path);
        if (format == "penumbra.brdf") content = describeBrdf(path);
        if (format == "penumbra.poses") content = describePoses(path);
        if (format == "penumbra.fields") content = describeFields(path);
        if (format == "penumbra.light") content = describeLight(path);
        if (format == "penumbra.transfer") content = describeTransfer(path);
        if (format == "penumbra.lobes") content = describeLobeModel(path);
        if (format == "penumbra.blockers") content = describeBlockers(path);
        if (content.is_null()) throw Unsupported(path.string() + ": attribute format: \"" + format + "\" is unknown");
    }
    json["format"] = format;
    json.update(content);
    return json;
}

struct InfoCommand {
    std::string file;
    bool all = false;

    std::vector<fs::path> inputs() const { return {file}; }
};

void defineInfo(CLI::App& app, InfoCommand& command) {
    app.add_option("file", command.file,
                   ".vis.h5, .poses.h5, .fields.h5, .model.h5, .lobes.h5, .transfer.h5, .brdf.h5, .light.h5, "
                   ".blockers.h5 or .pnb; or the rig or the point cache of a character, before it is baked")
        ->required();
    app.add_flag("--all", command.all, "read the visibility of all vertices, not of some, for its range");
}

void runInfo(const InfoCommand& command, const CommonOptions&, Report& report) {
    report.phase("read");
    report.figures = describeFile(command.file, command.all ? VertexSample::kAll : VertexSample::kSome);
    printJson(report.figures);
}

}  // namespace

Verb infoVerb() {
    return verbOf<InfoCommand, const InfoCommand>(
        "info", "Tells what is in a Penumbra file of any kind, who made it and from what.", defineInfo, runInfo);
}

}  // namespace penumbra
