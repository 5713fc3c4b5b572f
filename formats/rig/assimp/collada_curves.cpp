// Curves of Collada 1.4 (section "Interpolation curves"), which assimp takes for lines between their keys. A BEZIER
// segment goes from key 0 with the control points OUT_TANGENT of key 0 and IN_TANGENT of key 1 to key 1. A tangent is a
// point (time, value) for each number of a value; where it has no times, these are at the thirds of the segment.
// Of angles assimp turns every key into a quaternion and goes the shorter way between two, so that a turn of 360
// degrees stands still and the angles of one joint do not change alike. Keys at every 60th of a second leave it no
// choice.
#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>

#include "formats/common/errors.h"
#include "formats/rig/assimp/collada_text.h"
#include "formats/rig/assimp/xml_tree.h"
#include "formats/rig/rig_build.h"

namespace penumbra {

namespace {

constexpr double kCurveStep = 1 / 60.0;  // seconds
constexpr double kRamp = 1e-4;           // seconds that a step takes
constexpr std::size_t kMaxSamples = 1000000;

struct ColladaCurve {
    std::string id;  // for messages
    std::vector<double> times, values, in_tangents, out_tangents;
    std::vector<std::string_view> kinds;
    std::size_t width = 1;  // numbers of a value
    bool is_angle = false;  // it animates the angle of a <rotate>

    bool bends(std::size_t k) const {  // whether the segment that begins with key k needs keys of its own
        return kinds[k] == "BEZIER" || (is_angle && kinds[k] == "LINEAR" && values[k] != values[k + 1]);
    }
};

struct ColladaSources {
    const std::filesystem::path& path;
    std::map<std::string, const XmlNode*, std::less<>> source_of_id;
    std::size_t samples = 0, made = 0;

    [[noreturn]] void fail(const std::string& animation, const std::string& problem) const {
        failAtFile(path, "animation '" + animation + "': " + problem);
    }
    const XmlNode* find(std::string_view url) const {
        if (!url.starts_with('#')) return nullptr;
        const auto found = source_of_id.find(url.substr(1));
        return found == source_of_id.end() ? nullptr : found->second;
    }
};

std::vector<std::string_view> wordsOf(std::string_view text) {
    constexpr std::string_view kBlanks = " \t\r\n";
    std::vector<std::string_view> words;
    for (std::size_t at = text.find_first_not_of(kBlanks); at < text.size();) {
        const std::size_t end = std::min(text.find_first_of(kBlanks, at), text.size());
        words.push_back(text.substr(at, end - at));
        at = text.find_first_not_of(kBlanks, end);
    }
    return words;
}

std::vector<double> floatsOf(const XmlNode* source) {
    std::vector<double> numbers;
    const XmlNode* array = source ? source->child("float_array") : nullptr;
    for (const std::string_view word : array ? wordsOf(array->content()) : std::vector<std::string_view>()) {
        double number = 0;
        const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), number);
        if (error != std::errc() || end != word.data() + word.size() || !std::isfinite(number)) return {};
        numbers.push_back(number);
    }
    return numbers;
}

ColladaCurve curveOf(const ColladaSources& sources, const XmlNode& sampler, const std::string& id) {
    ColladaCurve curve;
    curve.id = id;
    for (const XmlNode& input : sampler.children) {
        const std::string_view semantic = input.attribute("semantic");
        const XmlNode* source = sources.find(input.attribute("source"));
        if (semantic == "INPUT") curve.times = floatsOf(source);
        if (semantic == "OUTPUT") curve.values = floatsOf(source);
        if (semantic == "IN_TANGENT") curve.in_tangents = floatsOf(source);
        if (semantic == "OUT_TANGENT") curve.out_tangents = floatsOf(source);
        const XmlNode* names = source && semantic == "INTERPOLATION" ? source->child("Name_array") : nullptr;
        if (names) curve.kinds = wordsOf(names->content());
    }
    return curve;
}

void checkCurve(const ColladaSources& sources, ColladaCurve& curve) {
    const std::size_t keys = curve.times.size();
    if (keys == 0 || curve.values.empty() || curve.values.size() % keys != 0 || curve.kinds.size() < keys)
        sources.fail(curve.id, "its keys, values and interpolations are not equally many");
    curve.width = curve.values.size() / keys;
    for (std::size_t k = 0; k < keys; ++k) {
        if (k > 0 && !(curve.times[k] > curve.times[k - 1])) sources.fail(curve.id, "its key times do not ascend");
        if (k + 1 == keys || curve.kinds[k] == "LINEAR" || curve.kinds[k] == "STEP") continue;
        if (curve.kinds[k] != "BEZIER")
            throw Unsupported(sources.path.string() + ": animation '" + curve.id +
                              "': " + cleanText(std::string(curve.kinds[k])) + " curves are not read: export it baked");
        const std::size_t plain = curve.values.size();
        for (const std::vector<double>* tangents : {&curve.in_tangents, &curve.out_tangents})
            if (tangents->size() != plain && tangents->size() != 2 * plain)
                sources.fail(curve.id, "BEZIER curves need two tangents a key");
    }
}

// A control point (time, value) of number `i` of key `k`.
struct ColladaPoint {
    double time, value;
};
ColladaPoint controlPoint(const ColladaCurve& curve, const std::vector<double>& tangents, std::size_t k, std::size_t i,
                          double plain_time) {
    const std::size_t index = k * curve.width + i;
    if (tangents.size() == curve.values.size()) return {plain_time, tangents[index]};
    return {tangents[2 * index], tangents[2 * index + 1]};
}

double bezier(double a, double b, double c, double d, double u) {
    const double v = 1 - u;
    return v * v * v * a + 3 * v * v * u * b + 3 * v * u * u * c + u * u * u * d;
}

// Returns number `i` at `time` of the segment that begins with key `k`.
double valueAt(const ColladaCurve& curve, std::size_t k, std::size_t i, double time) {
    const double from = curve.times[k], to = curve.times[k + 1], third = (to - from) / 3;
    if (curve.kinds[k] == "LINEAR")
        return std::lerp(curve.values[k * curve.width + i], curve.values[(k + 1) * curve.width + i],
                         (time - from) / (to - from));
    ColladaPoint out = controlPoint(curve, curve.out_tangents, k, i, from + third),
                 in = controlPoint(curve, curve.in_tangents, k + 1, i, to - third);
    out.time = std::clamp(out.time, from, to);  // else the curve runs backwards
    in.time = std::clamp(in.time, from, to);
    double low = 0, high = 1;
    for (int step = 0; step < 50; ++step) {
        const double middle = (low + high) / 2;
        (bezier(from, out.time, in.time, to, middle) < time ? low : high) = middle;
    }
    return bezier(curve.values[k * curve.width + i], out.value, in.value, curve.values[(k + 1) * curve.width + i],
                  (low + high) / 2);
}

// Writes the numbers of a curve that is made of lines.
struct ColladaLines {
    std::string times, values;
    std::size_t keys = 0;

    static void add(std::string& text, double number) {
        char buffer[32];
        const auto end = std::to_chars(buffer, buffer + sizeof buffer, number).ptr;
        if (!text.empty()) text += ' ';
        text.append(buffer, end);
    }
    void addKey(double time) {
        add(times, time);
        ++keys;
    }
};

void addSegment(const ColladaCurve& curve, std::size_t k, ColladaLines& lines) {
    const auto value = [&](std::size_t key, std::size_t i) { return curve.values[key * curve.width + i]; };
    lines.addKey(curve.times[k]);
    for (std::size_t i = 0; i < curve.width; ++i) ColladaLines::add(lines.values, value(k, i));
    if (k + 1 == curve.times.size()) return;
    const double span = curve.times[k + 1] - curve.times[k];
    if (curve.kinds[k] == "STEP") {
        if (span <= 2 * kRamp) return;
        lines.addKey(curve.times[k + 1] - kRamp);
        for (std::size_t i = 0; i < curve.width; ++i) ColladaLines::add(lines.values, value(k, i));
    } else if (curve.bends(k)) {
        for (int n = 1; n * kCurveStep < span - kCurveStep / 2; ++n) {
            const double time = curve.times[k] + n * kCurveStep;
            lines.addKey(time);
            for (std::size_t i = 0; i < curve.width; ++i) ColladaLines::add(lines.values, valueAt(curve, k, i, time));
        }
    }
}

XmlNode sourceOf(const std::string& id, const char* array_name, const std::string& text, std::size_t keys,
                 std::size_t width) {
    XmlNode param{.name = "param", .attributes = {}, .text = {}, .new_text = {}, .children = {}};
    param.setAttribute("type", array_name[0] == 'f' ? "float" : "name");
    XmlNode accessor{.name = "accessor", .attributes = {}, .text = {}, .new_text = {}, .children = {}};
    accessor.setAttribute("source", "#" + id + "-array");
    accessor.setAttribute("count", std::to_string(keys));
    accessor.setAttribute("stride", std::to_string(width));
    accessor.children.assign(width, param);
    XmlNode technique{.name = "technique_common", .attributes = {}, .text = {}, .new_text = {}, .children = {accessor}};
    XmlNode array{.name = array_name, .attributes = {}, .text = {}, .new_text = text, .children = {}};
    array.setAttribute("id", id + "-array");
    array.setAttribute("count", std::to_string(keys * width));
    XmlNode source{.name = "source", .attributes = {}, .text = {}, .new_text = {}, .children = {array, technique}};
    source.setAttribute("id", id);
    return source;
}

// Gives a sampler sources of its own that hold lines. Their accessors keep the parameters of the old ones.
void straightenSampler(ColladaSources& sources, XmlNode& sampler, ColladaCurve curve, std::vector<XmlNode>& added) {
    const std::string& id = curve.id;
    const auto isLine = [](std::string_view kind) { return kind == "LINEAR"; };
    const bool lines_alone = std::all_of(curve.kinds.begin(), curve.kinds.end(), isLine);
    if (lines_alone && !curve.is_angle) return;
    if (curve.kinds.empty()) curve.kinds.assign(curve.times.size(), "LINEAR");
    checkCurve(sources, curve);
    bool bends = !lines_alone;
    for (std::size_t k = 0; k + 1 < curve.times.size(); ++k) bends = bends || curve.bends(k);
    if (!bends) return;
    const double span = curve.times.back() - curve.times.front();
    sources.samples += 2 * curve.times.size() + std::size_t(std::min(span / kCurveStep, 1e9));
    if (sources.samples * curve.width > 16 * kMaxSamples) sources.fail(id, "its curves are too long");
    ColladaLines lines;
    for (std::size_t k = 0; k < curve.times.size(); ++k) addSegment(curve, k, lines);
    std::string kinds;
    for (std::size_t k = 0; k < lines.keys; ++k) kinds += k == 0 ? "LINEAR" : " LINEAR";
    const std::string prefix = "penumbra-" + std::to_string(sources.made++);
    for (XmlNode& input : sampler.children) {
        const std::string_view semantic = input.attribute("semantic");
        if (semantic == "INPUT")
            added.push_back(sourceOf(prefix + "-input", "float_array", lines.times, lines.keys, 1));
        else if (semantic == "OUTPUT")
            added.push_back(sourceOf(prefix + "-output", "float_array", lines.values, lines.keys, curve.width));
        else if (semantic == "INTERPOLATION")
            added.push_back(sourceOf(prefix + "-kinds", "Name_array", kinds, lines.keys, 1));
        else
            continue;
        const XmlNode* old = sources.find(input.attribute("source"));
        const XmlNode* technique = old ? old->child("technique_common") : nullptr;
        if (const XmlNode* accessor = technique ? technique->child("accessor") : nullptr)
            added.back().children[1].children[0].children = accessor->children;
        input.setAttribute("source", "#" + std::string(added.back().attribute("id")));
    }
    std::erase_if(sampler.children,
                  [](const XmlNode& input) { return input.attribute("semantic").ends_with("_TANGENT"); });
}

// Whether a sampler of an animation turns a node. By convention the target of such a channel ends so.
bool turns(const XmlNode& animation, std::string_view sampler_id) {
    return std::any_of(animation.children.begin(), animation.children.end(), [&](const XmlNode& child) {
        const std::string_view source = child.attribute("source");
        return child.name == "channel" && source.starts_with('#') && source.substr(1) == sampler_id &&
               child.attribute("target").ends_with(".ANGLE");
    });
}

void straightenAnimation(ColladaSources& sources, XmlNode& animation, const std::string& parent_id) {
    const std::string_view own_id = animation.attribute("id");
    const std::string id = own_id.empty() ? parent_id : cleanText(std::string(own_id));
    std::vector<XmlNode> added;
    for (XmlNode& child : animation.children) {
        if (child.name == "animation") straightenAnimation(sources, child, id);
        if (child.name != "sampler") continue;
        ColladaCurve curve = curveOf(sources, child, id);
        curve.is_angle = turns(animation, child.attribute("id"));
        straightenSampler(sources, child, std::move(curve), added);
    }
    animation.children.insert(animation.children.begin(), added.begin(), added.end());
}

void collectSources(const XmlNode& node, ColladaSources& sources) {
    if (node.name == "source") sources.source_of_id.emplace(node.attribute("id"), &node);
    for (const XmlNode& child : node.children) collectSources(child, sources);
}

}  // namespace

void straightenCurves(XmlNode& root, const std::filesystem::path& path) {
    for (XmlNode& library : root.children) {
        if (library.name != "library_animations") continue;
        const XmlNode before = library;  // sources are looked up here while the library changes
        ColladaSources sources{path, {}};
        collectSources(before, sources);
        for (XmlNode& animation : library.children)
            if (animation.name == "animation") straightenAnimation(sources, animation, "");
    }
}

}  // namespace penumbra
