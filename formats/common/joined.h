#pragma once
#include <functional>
#include <string>
#include <string_view>

namespace penumbra {

// Returns "a, b, c" for any range of strings, or of things that have one: joined(clips, ", ", &Clip::name).
template <class Words, class TextOf = std::identity>
std::string joined(const Words& words, std::string_view separator = ", ", TextOf text_of = {}) {
    std::string text;
    for (const auto& word : words) {
        if (!text.empty()) text += separator;
        text += std::invoke(text_of, word);
    }
    return text;
}

}  // namespace penumbra
