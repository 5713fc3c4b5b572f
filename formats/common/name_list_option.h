#pragma once
// Adds an option that takes names: "--clips a,b --clips c". It takes one word each time, so that a positional may
// follow it.
#include <CLI/CLI.hpp>
#include <string>
#include <vector>

namespace penumbra {

// Gives each name of a list to `take`. We split at commas ourselves: CLI11's own delimiter drops empty elements, so
// that
// "--clips ," would mean all clips.
template <class Take>
CLI::Option* addListOption(CLI::App& app, const std::string& option, const Take& take, const std::string& help) {
    const auto store = [option, take](const std::vector<std::string>& words) {
        for (const std::string& word : words)
            for (std::size_t begin = 0, end = 0; end != std::string::npos; begin = end + 1) {
                end = word.find(',', begin);
                const std::string name = word.substr(begin, end == std::string::npos ? end : end - begin);
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
