// Materials and lights.
#include <cmath>
#include <numbers>

#include "bake/info/info_files.h"
#include "formats/stage/brdf_file.h"
#include "formats/stage/light_file.h"

namespace penumbra {

namespace {

Json describeLobes(const LightFile& light) {
    const LightLobesFit& lobes = light.lobes;
    Json json{{"fit", lobes.mode},
              {"count", lobes.directions.size()},
              {"residual", lobes.residual},
              {"irradiance_error", lobes.irradiance_error},
              {"directions", Json::array()}};
    for (Vec3d d : lobes.directions) json["directions"].push_back({d.x, d.y, d.z});
    return json;
}

}  // namespace

Json describeBrdf(const std::filesystem::path& path) {
    const BrdfFile brdf = readBrdf(path);
    Json json{{"name", brdf.name},
              {"slice_order", brdf.slice_order},
              {"view_order", brdf.view_order},
              {"view_functions", brdf.even_index.size()}};
    if (const BrdfOperators& operators = brdf.operators; operators.count > 0)
        json["operators"] = {{"count", operators.count},
                             {"source", operators.source},
                             {"order", operators.order},
                             {"view_functions", operators.view_index.size()}};
    if (brdf.isLive()) json["live"] = nameOf(brdf.lobes[0].model);
    if (brdf.steps) json["steps"] = {{"values", brdf.steps->values}, {"error", brdf.steps->error}};
    if (brdf.membrane) json["membrane"] = toString(*brdf.membrane);
    if (const Vec3 e = brdf.emission; e != Vec3{}) json["emission"] = {e.x, e.y, e.z};
    json["errors"] = brdf.errors;
    json["provenance"] = describe(brdf.provenance);
    return json;
}

Json describeLight(const std::filesystem::path& path) {
    const LightFile light = readLight(path);
    Json json{{"name", light.name}, {"sh_order", light.order}, {"residual", light.residual}};
    // The mean radiance over the sphere is coefficient 0 over y_0 4 pi, y_0 = 1 / sqrt(4 pi).
    json["mean_radiance"] = Json::array();
    for (std::size_t c = 0; c < 3; ++c) json["mean_radiance"].push_back(light.sh[c] / std::sqrt(4 * std::numbers::pi));
    if (!light.window.empty()) json["window"] = light.window;
    if (!light.lobes.directions.empty()) json["lobes"] = describeLobes(light);
    if (!light.factor.empty()) {
        json["factor"] = light.factor;
        json["suns"] = describeSuns(light.suns);
        json["picture"] = {light.picture.width, light.picture.height};
    }
    json["provenance"] = describe(light.provenance);
    return json;
}

}  // namespace penumbra
