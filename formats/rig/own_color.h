#pragma once
// How an exported .glb says that the COLOR_0 of a primitive is darkened by an occlusion. The primitive has
// extras.penumbra_color = "occlusion", and the attribute _OWN_COLOR where it had colours of its own before. Readers of
// rigs take these, or none, because the occlusion is no colour of the surface.

namespace penumbra {

constexpr const char* kColorMark = "penumbra_color";
constexpr const char* kMarkOfOcclusion = "occlusion";
constexpr const char* kOwnColor = "_OWN_COLOR";

}  // namespace penumbra
