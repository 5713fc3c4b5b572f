#include "player/view/view_settings.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "formats/common/write_file.h"
#include "formats/image/exposure.h"

namespace penumbra {

using Json = nlohmann::ordered_json;

std::filesystem::path settingsPath() {
    const char* config = std::getenv("XDG_CONFIG_HOME");
    if (config && *config) return std::filesystem::path(config) / "penumbra" / "view.json";
    const char* home = std::getenv("HOME");
    if (home && *home) return std::filesystem::path(home) / ".config" / "penumbra" / "view.json";
    return {};
}

ViewState firstState() {
    ViewState state;
    state.display.tone_map = ToneMap::kFilmic;
    state.window.hint = true;
    return state;
}

namespace {

// Reads fields. One that is absent leaves its value as it was; so does one that cannot be used, and `problem` tells
// so.
class FieldReader {
public:
    explicit FieldReader(std::string& problem) : problem_(&problem) {}

    template <class T>
    void number(const Json& json, const char* name, double low, double high, T& value) {
        const Json* field = find(json, name);
        if (!field) return;
        if (!field->is_number()) return refuse(name, "is not a number");
        const double read = field->get<double>();
        if (!(read >= low && read <= high)) return refuse(name, "is out of range");
        value = T(read);
    }
    void flag(const Json& json, const char* name, bool& value) {
        const Json* field = find(json, name);
        if (field && !field->is_boolean()) return refuse(name, "is neither true nor false");
        if (field) value = field->get<bool>();
    }
    void paths(const Json& json, const char* name, std::vector<std::filesystem::path>& value) {
        const Json* field = find(json, name);
        if (!field) return;
        const auto is_text = [](const Json& one) { return one.is_string(); };
        if (!field->is_array() || !std::ranges::all_of(*field, is_text)) return refuse(name, "is not a list of files");
        for (const Json& one : *field) value.emplace_back(one.get<std::string>());
    }
    const Json* object(const Json& json, const char* name) {
        const Json* field = find(json, name);
        if (!field || field->is_object()) return field;
        refuse(name, "is not an object");
        return nullptr;
    }

private:
    std::string* problem_;

    static const Json* find(const Json& json, const char* name) {
        const auto found = json.find(name);
        return found == json.end() ? nullptr : &*found;
    }
    void refuse(const char* name, const char* reason) {
        *problem_ += (problem_->empty() ? "" : ", ") + std::string(name) + " " + reason;
    }
};

ViewSettings parseSettings(const Json& json, std::string& problem) {
    if (!json.is_object()) throw std::runtime_error("not a JSON object");
    ViewSettings settings;
    ViewState& state = settings.state;
    FieldReader read(problem);
    if (const Json* window = read.object(json, "window")) {
        read.number(*window, "width", kMinWidth, kMaxWidth, settings.window.width);
        read.number(*window, "height", kMinHeight, kMaxHeight, settings.window.height);
        read.number(*window, "x", -32768, 32767, settings.window.x);  // range of X11
        read.number(*window, "y", -32768, 32767, settings.window.y);
    }
    std::optional<float> exposure;
    read.number(json, "exposure", double(kMinExposure), double(kMaxExposure), exposure);
    state.automatic_exposure = !exposure;
    if (exposure) state.display.exposure = *exposure;
    read.number(json, "tone_map", 0, 2, state.display.tone_map);
    read.number(json, "speed", 0.125, 8, state.playhead.speed);
    read.number(json, "error_max", 1e-3, 1, state.show.error_max);
    read.flag(json, "background", state.show.background);
    read.flag(json, "ground", state.show.ground);
    read.flag(json, "panels", state.window.panels);
    read.paths(json, "recent", state.window.recent);
    state.window.hint = false;
    return settings;
}

}  // namespace

ViewSettings readSettings(const std::filesystem::path& path, std::string& problem) {
    if (path.empty() || !std::filesystem::exists(path)) return {};
    try {
        std::ifstream file(path);
        std::string fields;
        const ViewSettings settings = parseSettings(Json::parse(file), fields);
        if (!fields.empty()) problem = path.string() + ": " + fields + "; everything else is used";
        return settings;
    } catch (const std::exception& error) {
        problem = path.string() + " is not used: " + error.what();
        return {};
    }
}

void writeSettings(const std::filesystem::path& path, const ViewSettings& settings) {
    const ViewState& state = settings.state;
    Json json;
    json["schema"] = "penumbra.view";
    json["schema_version"] = 1;
    json["window"] = {{"width", settings.window.width}, {"height", settings.window.height}};
    if (settings.window.x) json["window"]["x"] = *settings.window.x;
    if (settings.window.y) json["window"]["y"] = *settings.window.y;
    if (!state.automatic_exposure) json["exposure"] = state.display.exposure;
    json["tone_map"] = int(state.display.tone_map);
    json["speed"] = state.playhead.speed;
    json["error_max"] = state.show.error_max;
    json["background"] = state.show.background;
    json["ground"] = state.show.ground;
    json["panels"] = state.window.panels;
    json["recent"] = Json::array();
    for (const std::filesystem::path& file : state.window.recent) json["recent"].push_back(file.string());
    std::error_code failed;  // writeWholeFile() says what cannot be written
    std::filesystem::create_directories(path.parent_path(), failed);
    writeWholeFile(path, json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n");
}

}  // namespace penumbra
