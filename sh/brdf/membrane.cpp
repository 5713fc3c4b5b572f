#include "sh/brdf/membrane.h"

#include <array>
#include <charconv>
#include <stdexcept>

#include "sh/key_values.h"

namespace penumbra {

namespace {

constexpr float kRounding = 1e-6f;  // rounding of the sum of two shares in single precision

// Returns as few digits as are needed to read back the same numbers.
std::string triple(Vec3 v) {
    std::string text;
    for (int c = 0; c < 3; ++c) {
        std::array<char, 32> digits;
        const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), v[c]).ptr;
        text += (c > 0 ? "/" : "") + std::string(digits.data(), end);
    }
    return text;
}

}  // namespace

std::string findProblem(const Membrane& membrane) {
    for (int c = 0; c < 3; ++c) {
        const float rho = membrane.rho[c], tau = membrane.tau[c];
        if (!(rho >= 0 && rho <= 1)) return "membrane rho must be a number from 0 to 1, not " + triple(membrane.rho);
        if (!(tau >= 0 && tau <= 1)) return "membrane tau must be a number from 0 to 1, not " + triple(membrane.tau);
        if (rho + tau > 1 + kRounding)
            return "membrane rho + tau must be from 0 to 1 in every channel, not " +
                   triple(membrane.rho + membrane.tau);
    }
    return "";
}

std::optional<Membrane> parseMembrane(std::string_view text) {
    const std::size_t colon = text.find(':');
    if (text.substr(0, colon) != kMembraneName) return std::nullopt;
    Membrane membrane;
    const std::string_view list = colon == std::string_view::npos ? "" : text.substr(colon + 1);
    for (const KeyValue& item : splitKeyValues(list)) {
        if (item.key == "rho") {
            membrane.rho = toFloat(parseTriple("membrane rho", item.value, 0, 1));
        } else if (item.key == "tau") {
            membrane.tau = toFloat(parseTriple("membrane tau", item.value, 0, 1));
        } else if (item.key == "back") {
            if (item.value != "own" && item.value != "open")
                throw std::invalid_argument("membrane back must be own or open, not '" + std::string(item.value) + "'");
            membrane.open_back = item.value == "open";
        } else {
            throw std::invalid_argument("membrane has no '" + std::string(item.key) + "': use rho, tau, back");
        }
    }
    if (const std::string problem = findProblem(membrane); !problem.empty()) throw std::invalid_argument(problem);
    return membrane;
}

std::string toString(const Membrane& membrane) {
    return "membrane:rho=" + triple(membrane.rho) + ",tau=" + triple(membrane.tau) +
           (membrane.open_back ? ",back=open" : "");
}

}  // namespace penumbra
