#pragma once
#include <string>
#include <string_view>
#include <vector>

#include "formats/common/errors.h"

namespace penumbra {

// Returns the place in `list` of what is called `name`, or of the only one whose name begins so ("ggx" for
// "ggx:alpha=0.3"), or the first for "". Throws BadOption, which names
// `asker` (the option, or the place in a file) and lists what there is.
template <class List>
std::size_t findByName(const List& list, std::string_view name, const std::string& asker) {
    if (name.empty()) return 0;
    std::size_t beginning = 0, beginnings = 0;
    std::string known;
    for (std::size_t i = 0; i < list.size(); ++i) {
        const std::string_view element = list[i].name;
        if (element == name) return i;
        known += (known.empty() ? "" : ", ") + std::string(element);
        if (!element.starts_with(name)) continue;
        beginning = i;
        ++beginnings;
    }
    if (beginnings == 1) return beginning;
    throw BadOption(asker, std::string("the asset has ") + (beginnings == 0 ? "no" : "more than one") + " \"" +
                               std::string(name) + "\"; it has " + known);
}

}  // namespace penumbra
