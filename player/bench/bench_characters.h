#pragma once
// Many characters that share an asset: what each costs in time and memory.
#include <vector>

#include "player/bench/bench.h"

namespace penumbra {

// Nothing without `counts`, else one of 1, which the others are compared with, and one of each other count, ascending.
// `shading` may be null: E is not drawn then, but black.
std::vector<CharactersCost> benchCharacters(const RenderOptions& options, const Shot& shot, ShadingSet* shading,
                                            std::vector<int> counts, int runs, int threads);

}  // namespace penumbra
