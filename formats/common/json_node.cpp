#include "formats/common/json_node.h"

#include <algorithm>
#include <fstream>
#include <set>
#include <sstream>

#include "formats/common/errors.h"
#include "formats/common/json_depth.h"

namespace penumbra {

namespace {

using Json = nlohmann::json;
constexpr std::uintmax_t kMaxBytes = 64 << 20;

// Keys of a file go to the terminal.
std::string printableKey(std::string key) {
    for (char& c : key)
        if (static_cast<unsigned char>(c) < 0x20) c = '?';
    return key;
}

// Refuses a key that stands twice in one object. This is a pass of its own over the text, because a parser with a
// callback takes quadratic time over an array of objects: 100 s for a million of them, and 1 s in two passes.
class TwiceWatch : public nlohmann::json_sax<Json> {
public:
    explicit TwiceWatch(const std::string& name) : name_(name) {}

    bool null() override { return value(); }
    bool boolean(bool) override { return value(); }
    bool number_integer(number_integer_t) override { return value(); }
    bool number_unsigned(number_unsigned_t) override { return value(); }
    bool number_float(number_float_t, const string_t&) override { return value(); }
    bool string(string_t&) override { return value(); }
    bool binary(binary_t&) override { return value(); }
    bool start_object(std::size_t) override { return open(true); }
    bool start_array(std::size_t) override { return open(false); }
    bool end_object() override { return close(); }
    bool end_array() override { return close(); }
    bool parse_error(std::size_t, const std::string&, const Json::exception&) override { return false; }

    bool key(string_t& word) override {
        Level& level = levels_.back();
        level.key = word;
        if (level.keys.insert(word).second) return true;
        std::string place;
        for (const Level& one : levels_)
            place += "/" + (one.object ? printableKey(one.key) : std::to_string(one.values - 1));
        throw InvalidInput(name_ + ": " + place + ": occurs twice in one object");
    }

private:
    struct Level {
        bool object = false;
        std::set<std::string> keys;
        std::string key;         // the latest key of an object
        std::size_t values = 0;  // values that have begun
    };
    bool value() {
        if (!levels_.empty()) ++levels_.back().values;
        return true;
    }
    bool open(bool object) {
        value();
        levels_.push_back({object, {}, {}, 0});
        return true;
    }
    bool close() {
        levels_.pop_back();
        return true;
    }
    const std::string& name_;
    std::vector<Level> levels_;
};

}  // namespace

void JsonNode::fail(const std::string& what) const {
    throw InvalidInput(file_ + ": " + (at_.empty() ? "/" : at_) + ": " + what);
}

void JsonNode::requireKeys(std::initializer_list<const char*> known, std::initializer_list<const char*> more) const {
    if (!json_->is_object()) fail("must be an object");
    for (const auto& [key, value] : json_->items())
        if (std::ranges::find(known, key) == known.end() && std::ranges::find(more, key) == more.end())
            at(printableKey(key)).fail("unknown key");
}

void JsonNode::requireVersion(const FileFormat& format) const {
    if (!json_->is_object()) fail("must be an object");
    const std::string problem = findVersionProblem(format, required("version").whole(0, 1 << 30));
    if (!problem.empty()) at("version").fail(problem);
}

JsonNode JsonNode::at(const std::string& key) const {
    return {json_->contains(key) ? json_->at(key) : *json_, file_, at_ + "/" + key};
}

JsonNode JsonNode::required(const char* key) const {
    if (!has(key)) fail("has no \"" + std::string(key) + "\"");
    return at(key);
}

std::vector<JsonNode> JsonNode::items(std::size_t most) const {
    if (!json_->is_array()) fail("must be an array");
    if (json_->size() > most)
        fail("has " + std::to_string(json_->size()) + " elements; at most " + std::to_string(most));
    std::vector<JsonNode> nodes;
    for (std::size_t i = 0; i < json_->size(); ++i)
        nodes.emplace_back((*json_)[i], file_, at_ + "/" + std::to_string(i));
    return nodes;
}

std::vector<std::pair<std::string, JsonNode>> JsonNode::members() const {
    if (!json_->is_object()) fail("must be an object");
    std::vector<std::pair<std::string, JsonNode>> nodes;
    for (const auto& [key, value] : json_->items()) nodes.emplace_back(key, JsonNode(value, file_, at_ + "/" + key));
    return nodes;
}

std::string JsonNode::text() const {
    if (!json_->is_string()) fail("must be a string");
    const auto text = json_->get<std::string>();
    if (std::ranges::any_of(text, [](unsigned char c) { return c < 0x20; })) fail("has a control character");
    return text;
}

double JsonNode::number(double low, double high) const {
    if (!json_->is_number()) fail("must be a number");
    const auto x = json_->get<double>();
    if (!(x >= low && x <= high)) {
        std::ostringstream range;
        range << "is " << x << ", not in [" << low << ", " << high << "]";
        fail(range.str());
    }
    return x;
}

std::vector<float> JsonNode::numbers(std::size_t count, double low, double high) const {
    const std::vector<JsonNode> all = items(count);
    if (all.size() != count) fail("must have " + std::to_string(count) + " numbers");
    std::vector<float> out;
    for (const JsonNode& one : all) out.push_back(float(one.number(low, high)));
    return out;
}

bool JsonNode::flag() const {
    if (!json_->is_boolean()) fail("must be true or false");
    return json_->get<bool>();
}

int JsonNode::whole(int low, int high) const {
    if (!json_->is_number_integer()) fail("must be a whole number");
    return int(number(low, high));
}

Vec3 JsonNode::vector(double low, double high) const {
    const std::vector<float> three = numbers(3, low, high);
    return {three[0], three[1], three[2]};
}

nlohmann::json parseJson(const std::string& text, const std::string& name) {
    if (nestedTooDeep(text)) throw InvalidInput(name + ": nested too deep");
    TwiceWatch watch(name);
    Json::sax_parse(text, &watch);
    try {
        return Json::parse(text);
    } catch (const Json::exception& error) {
        throw InvalidInput(name + ": not JSON: " + error.what());
    }
}

std::string readJsonText(const std::filesystem::path& path) {
    std::error_code problem;
    const std::uintmax_t size = std::filesystem::file_size(path, problem);
    if (problem) throw IoError(path.string() + ": " + problem.message());
    if (size > kMaxBytes)
        throw InvalidInput(path.string() + ": has " + std::to_string(size) + " bytes; at most " +
                           std::to_string(kMaxBytes));
    std::ifstream file(path, std::ios::binary);
    std::string text((std::istreambuf_iterator<char>(file)), {});
    if (!file) throw IoError(path.string() + ": cannot be read");
    return text;
}

}  // namespace penumbra
