#include "formats/common/slot_choice.h"

#include "formats/common/errors.h"
#include "formats/common/joined.h"

namespace penumbra {

SlotChoice parseSlotChoice(const std::string& text) {
    std::string slot;
    std::size_t at = 0;
    for (; at < text.size() && text[at] != '='; ++at) {
        if (text[at] == '\\' && at + 1 < text.size() && text[at + 1] == '=') ++at;
        slot += text[at];
    }
    if (slot.empty() || at + 1 >= text.size()) throw BadOption("slot", "must be SLOT=MATERIAL, not \"" + text + "\"");
    return {slot, text.substr(at + 1)};
}

std::vector<std::size_t> findSlots(std::span<const std::string_view> slots, std::string_view name) {
    const std::string node = std::string(name) + "/", material = "/" + std::string(name);
    std::vector<std::size_t> whole, beginning;
    for (std::size_t i = 0; i < slots.size(); ++i) {
        if (slots[i] == name || slots[i].starts_with(node) || slots[i].ends_with(material)) whole.push_back(i);
        if (slots[i].starts_with(name) || slots[i].find(material) != slots[i].npos) beginning.push_back(i);
    }
    if (whole.empty() && beginning.empty())
        throw BadOption("slot",
                        "no slot \"" + std::string(name) + "\"; there are " + (slots.empty() ? "none" : joined(slots)));
    return whole.empty() ? beginning : whole;
}

}  // namespace penumbra
