#include "formats/common/slot_choice.h"

#include "formats/common/errors.h"
#include "formats/common/joined.h"

namespace penumbra {

SlotChoice parseSlotChoice(const std::string& text) {
    const std::size_t equals = text.find('=');
    if (equals == 0 || equals == std::string::npos || equals + 1 == text.size())
        throw UsageError("--slot takes SLOT=MATERIAL, not \"" + text + "\"");
    return {text.substr(0, equals), text.substr(equals + 1)};
}

[[noreturn]] static void fail(const std::string& problem, std::span<const std::string_view> known) {
    const std::string list = joined(known);
    throw UsageError("--slot: " + problem + "; there are " + (list.empty() ? "none" : list));
}

std::vector<std::size_t> findSlots(std::span<const std::string_view> slots, std::string_view name) {
    const std::string node = std::string(name) + "/", material = "/" + std::string(name);
    std::vector<std::size_t> whole, beginning;
    for (std::size_t i = 0; i < slots.size(); ++i) {
        if (slots[i] == name || slots[i].starts_with(node) || slots[i].ends_with(material)) whole.push_back(i);
        if (slots[i].starts_with(name) || slots[i].find(material) != slots[i].npos) beginning.push_back(i);
    }
    if (whole.empty() && beginning.empty()) fail("no slot \"" + std::string(name) + "\"", slots);
    return whole.empty() ? beginning : whole;
}

std::size_t findMaterial(std::span<const std::string_view> materials, std::string_view name) {
    std::vector<std::size_t> beginning;
    for (std::size_t i = 0; i < materials.size(); ++i) {
        if (materials[i] == name) return i;
        if (materials[i].starts_with(name)) beginning.push_back(i);
    }
    if (beginning.size() == 1) return beginning[0];
    fail((beginning.empty() ? "no material \"" : "more than one material \"") + std::string(name) + "\"", materials);
}

}  // namespace penumbra
