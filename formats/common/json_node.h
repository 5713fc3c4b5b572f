#pragma once
// Reads JSON that others wrote, and says where in the file what is wrong stands.
#include <filesystem>
#include <initializer_list>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "formats/common/file_format.h"
#include "sh/vec3.h"

namespace penumbra {

// A value and where it stands: messages have the file and the JSON pointer. The JSON outlives it.
class JsonNode {
public:
    JsonNode(const nlohmann::json& json, std::string file, std::string at)
        : json_(&json), file_(std::move(file)), at_(std::move(at)) {}

    // Throws InvalidInput. So do all others where a value is not what they return.
    [[noreturn]] void fail(const std::string& what) const;
    // Fails for a key that is not among these.
    void requireKeys(std::initializer_list<const char*> known, std::initializer_list<const char*> more = {}) const;
    std::string place() const { return file_ + ": " + at_; }
    bool has(const char* key) const { return json_->contains(key); }
    JsonNode at(const std::string& key) const;
    // Returns a member, and fails without it.
    JsonNode required(const char* key) const;
    // Fails unless this is an object whose member "version" is that of the format.
    void requireVersion(const FileFormat& format) const;
    std::vector<JsonNode> items(std::size_t most) const;
    std::vector<std::pair<std::string, JsonNode>> members() const;
    std::string text() const;  // without control characters
    double number(double low, double high) const;
    // Returns the numbers of an array of this length.
    std::vector<float> numbers(std::size_t count, double low, double high) const;
    int whole(int low, int high) const;
    bool flag() const;
    bool isFlag() const { return json_->is_boolean(); }
    bool isArray() const { return json_->is_array(); }
    bool isObject() const { return json_->is_object(); }
    Vec3 vector(double low, double high) const;

private:
    const nlohmann::json* json_;
    std::string file_, at_;
};

// Parses without recursion of ours, and refuses a key that stands twice in one object, which would hide the first.
nlohmann::json parseJson(const std::string& text, const std::string& name);

// Reads a whole file of at most 64 MiB. Throws IoError and InvalidInput.
std::string readJsonText(const std::filesystem::path& path);

}  // namespace penumbra
