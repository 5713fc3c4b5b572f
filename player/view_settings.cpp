#include "player/view_settings.h"

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "formats/write_file.h"

namespace penumbra {

using Json = nlohmann::ordered_json;

std::filesystem::path settingsPath() {
    const char* config = std::getenv("XDG_CONFIG_HOME");
    if (config && *config) return std::filesystem::path(config) / "penumbra" / "view.json";
    const char* home = std::getenv("HOME");
    if (home && *home) return std::filesystem::path(home) / ".config" / "penumbra" / "view.json";
    return {};
}

static double numberWithin(const Json& json, const char* name, double low, double high) {
    const double value = json.at(name).get<double>();
    if (!(value >= low && value <= high)) throw std::runtime_error(std::string(name) + " is out of range");
    return value;
}

static int integerWithin(const Json& json, const char* name, int low, int high) {
    return int(numberWithin(json, name, low, high));
}

static ViewSettings parseSettings(const Json& json) {
    ViewSettings settings;
    const Json& window = json.at("window");
    settings.window = {integerWithin(window, "width", 100, 16384), integerWithin(window, "height", 100, 16384),
                       integerWithin(window, "x", -1, 32767), integerWithin(window, "y", -1, 32767)};
    settings.display = {float(numberWithin(json, "exposure", 1 / 64.0, 64)),
                        ToneMap(integerWithin(json, "tone_map", 0, 2))};
    settings.speed = numberWithin(json, "speed", 0.125, 8);
    settings.error_max = float(numberWithin(json, "error_max", 1e-3, 1));
    settings.background = json.at("background").get<bool>();
    settings.ground = json.at("ground").get<bool>();
    settings.panels = json.at("panels").get<bool>();
    return settings;
}

ViewSettings readSettings(const std::filesystem::path& path, std::string& problem) {
    if (path.empty() || !std::filesystem::exists(path)) return {};
    try {
        std::ifstream file(path);
        return parseSettings(Json::parse(file));
    } catch (const std::exception& error) {
        problem = path.string() + " is not used: " + error.what();
        return {};
    }
}

void writeSettings(const std::filesystem::path& path, const ViewSettings& settings) {
    Json json;
    json["schema"] = "penumbra.view";
    json["schema_version"] = 1;
    json["window"] = {{"width", settings.window.width},
                      {"height", settings.window.height},
                      {"x", settings.window.x},
                      {"y", settings.window.y}};
    json["exposure"] = settings.display.exposure;
    json["tone_map"] = int(settings.display.tone_map);
    json["speed"] = settings.speed;
    json["error_max"] = settings.error_max;
    json["background"] = settings.background;
    json["ground"] = settings.ground;
    json["panels"] = settings.panels;
    std::error_code failed;  // writeWholeFile says what cannot be written
    std::filesystem::create_directories(path.parent_path(), failed);
    writeWholeFile(path, json.dump(2) + "\n");
}

void applySettings(const ViewSettings& settings, ViewState& state) {
    state.display = settings.display;
    state.playhead.speed = settings.speed;
    state.error_max = settings.error_max;
    state.background = settings.background;
    state.ground = settings.ground;
    state.panels = settings.panels;
}

ViewSettings settingsOf(const ViewState& state, const WindowPlace& window) {
    return {window, state.display, state.playhead.speed, state.error_max, state.background, state.ground, state.panels};
}

}  // namespace penumbra
