#pragma once
// Adds the option --name, which tells what an asset calls a material or a light.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <string>

namespace penumbra {

inline CLI::Option* addNameOption(CLI::App& app, std::string& name) {
    const auto problem = [](const std::string& text) {
        const bool control = std::any_of(text.begin(), text.end(),
                                         [](char c) { return static_cast<unsigned char>(c) < ' ' || c == 127; });
        return std::string(text.empty() ? "the name is empty" : control ? "a name has no control characters" : "");
    };
    return app.add_option("--name", name, "what assets call it (default: the model with its parameters, or the file)")
        ->check(CLI::Validator(problem, ""));
}

}  // namespace penumbra
