#include "player/view/material_label.h"

#include <algorithm>
#include <array>
#include <optional>
#include <utility>

namespace penumbra {

namespace {

using LabelOf = std::pair<std::string_view, std::string_view>;
constexpr std::array<LabelOf, 13> kLabels = {{{"lambert", "Lambert"},
                                              {"oren-nayar", "Oren-Nayar"},
                                              {"phong", "Phong"},
                                              {"phong-live", "Phong, live"},
                                              {"blinn-phong", "Blinn-Phong"},
                                              {"ward", "Ward"},
                                              {"ward-gmd", "Ward (GMD)"},
                                              {"ashikhmin-shirley", "Ashikhmin-Shirley"},
                                              {"ggx", "GGX"},
                                              {"ggx-live", "GGX, live"},
                                              {"cook-torrance", "Cook-Torrance"},
                                              {"mirror", "mirror"},
                                              {"principled", "principled"}}};

// A model and its parameters; nothing for other words.
std::optional<std::string> labelOfTerm(std::string_view term) {
    const std::size_t colon = term.find(':');
    const auto model = std::ranges::find(kLabels, term.substr(0, colon), &LabelOf::first);
    if (model == kLabels.end()) return std::nullopt;
    std::string label(model->second);
    if (colon == std::string_view::npos) return label;
    std::string parameters(term.substr(colon + 1));
    std::ranges::replace(parameters, '=', ' ');
    for (std::size_t at = 0; at != std::string::npos;) {
        const std::size_t comma = parameters.find(',', at);
        label += ", " + parameters.substr(at, comma - at);
        at = comma == std::string::npos ? comma : comma + 1;
    }
    return label;
}

}  // namespace

std::string materialLabel(std::string_view name) {
    std::string whole;
    for (std::string_view rest = name; !rest.empty();) {
        const std::size_t plus = rest.find('+');
        const std::optional<std::string> term = labelOfTerm(rest.substr(0, plus));
        if (!term) return std::string(name);
        whole += (whole.empty() ? "" : " + ") + *term;
        rest = plus == std::string_view::npos ? std::string_view() : rest.substr(plus + 1);
    }
    return whole;
}

}  // namespace penumbra
