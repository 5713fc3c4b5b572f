#pragma once
// The words that command lines and reports use for the values of a type.
#include <cstddef>
#include <string_view>

namespace penumbra {

template <class T>
struct Word {
    std::string_view word;
    T value;
};

// Returns the first word of a value, or "".
template <class T, class Value, std::size_t N>
constexpr std::string_view wordOf(const Word<T> (&words)[N], const Value& value) {
    for (const Word<T>& word : words)
        if (word.value == value) return word.word;
    return "";
}

}  // namespace penumbra
