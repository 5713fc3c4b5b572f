#pragma once
// A thin membrane (cloth, a leaf, a wing): it reflects rho and lets tau through, both diffusely. Each side has
//   L = rho/pi E_this + tau/pi E_other
// with the irradiance E of either side in its own frame and under its own visibility (docs/formulas.md, "Membranes").
#include <optional>
#include <string>
#include <string_view>

#include "sh/vec3.h"

namespace penumbra {

constexpr const char* kMembraneName = "membrane";

struct Membrane {
    Vec3 rho{0.5f, 0.5f, 0.5f}, tau{0.3f, 0.3f, 0.3f};  // linear Rec.709, each >= 0, rho + tau <= 1 in every channel
    bool open_back = false;                             // light from the other side is unshadowed (Nowrouzezahrai 2008)

    bool operator==(const Membrane&) const = default;
};

// Returns "" for a membrane that can be, else one sentence that names the value and its range.
std::string findProblem(const Membrane& membrane);

// Parses "membrane:rho=R/G/B,tau=R/G/B[,back=own|open]". Returns nothing for the text of another material. Throws
// std::invalid_argument with one sentence that names the key, its range and the value.
std::optional<Membrane> parseMembrane(std::string_view text);
std::string toString(const Membrane& membrane);  // canonical: parseMembrane(toString(m)) == m

}  // namespace penumbra
