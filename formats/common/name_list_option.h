#pragma once
// Adds an option that takes names: "--clips a,b --clips c". It takes one word each time, so that a positional may
// follow it.
#include <CLI/CLI.hpp>
#include <string>
#include <vector>

namespace penumbra {

// Splits "a,b" at its commas. A backslash makes a comma, or another backslash, part of a name: "walk\, slow". CLI11's
// own delimiter drops empty elements, so that "--clips ," would mean all clips.
inline std::vector<std::string> splitNames(const std::string& text) {
    std::vector<std::string> names(1);
    for (std::size_t i = 0; i < text.size(); ++i) {
        const bool escapes = text[i] == '\\' && i + 1 < text.size() && (text[i + 1] == ',' || text[i + 1] == '\\');
        if (escapes)
            names.back() += text[++i];
        else if (text[i] == ',')
            names.emplace_back();
        else
            names.back() += text[i];
    }
    return names;
}

// Gives each name of a list to `take`.
template <class Take>
CLI::Option* addListOption(CLI::App& app, const std::string& option, const Take& take, const std::string& help) {
    const auto store = [option, take](const std::vector<std::string>& words) {
        for (const std::string& word : words)
            for (const std::string& name : splitNames(word)) {
                if (name.empty()) throw CLI::ValidationError(option, "an empty name in '" + word + "'");
                take(name);
            }
    };
    return app.add_option_function<std::vector<std::string>>(option, store, help + "; several with commas between")
        ->allow_extra_args(false);
}

inline CLI::Option* addNameListOption(CLI::App& app, const std::string& option, std::vector<std::string>& names,
                                      const std::string& help) {
    return addListOption(
        app, option, [&names](const std::string& name) { names.push_back(name); }, help);
}

}  // namespace penumbra
