#pragma once
// Warns of flags that were given and change nothing.
#include <functional>
#include <string>

#include "formats/common/options.h"
#include "formats/common/warning.h"

namespace penumbra {

// `where` gets each option that was given, and says where it changes nothing: "without a picture", or "".
inline void warnOfUnused(const CLI::App& app, const std::function<std::string(const CLI::Option&)>& where) {
    for (const CLI::Option* option : app.get_options()) {
        if (option->count() == 0) continue;
        if (const std::string place = where(*option); !place.empty())
            reportWarning("penumbra-player", option->get_name() + " changes nothing " + place);
    }
}

}  // namespace penumbra
