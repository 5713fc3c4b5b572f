#include "pack/export/uv_sets.h"

#include <algorithm>
#include <charconv>
#include <optional>

namespace penumbra {

namespace {

// Returns the number of a set of texture coordinates, or nothing for other attributes.
std::optional<std::size_t> uvSetOf(const std::string& attribute) {
    const std::string beginning = "TEXCOORD_";
    if (!attribute.starts_with(beginning)) return std::nullopt;
    std::size_t set = 0;
    const char *first = attribute.data() + beginning.size(), *last = attribute.data() + attribute.size();
    const auto [end, error] = std::from_chars(first, last, set);
    return error == std::errc() && end == last && set < 1000 ? std::optional(set) : std::nullopt;
}

}  // namespace

std::size_t freeUvSet(GrowingGlb& glb, std::span<const GlbTarget> targets, std::size_t least) {
    std::size_t free = least;
    for (const GlbTarget& target : targets)
        for (const auto& [name, accessor] : primitiveOf(glb, target).at("attributes").items())
            if (const auto set = uvSetOf(name)) free = std::max(free, *set + 1);
    return free;
}

void addUvSet(GrowingGlb& glb, const GlbTarget& target, std::size_t set, std::span<const float> uv) {
    for (std::size_t i = 0; i < set; ++i) {
        const std::string name = "TEXCOORD_" + std::to_string(i);
        if (primitiveOf(glb, target).at("attributes").contains(name)) continue;
        const nlohmann::ordered_json& attributes = primitiveOf(glb, target).at("attributes");
        const std::size_t filled = attributes.contains("TEXCOORD_0") ? attributes["TEXCOORD_0"].get<std::size_t>()
                                                                     : addZeros(glb, uv.size() / 2, 2);
        primitiveOf(glb, target).at("attributes")[name] = filled;
    }
    primitiveOf(glb, target).at("attributes")["TEXCOORD_" + std::to_string(set)] =
        addAccessor(glb, uv, 2, AccessorUse::kVertices);
}

}  // namespace penumbra
