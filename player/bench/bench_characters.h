#pragma once
// Measures many characters that share an asset: what each costs in time and memory.
#include <vector>

#include "player/bench/bench.h"

namespace penumbra {

// Returns nothing without `counts`. Otherwise it measures one character first, with which the others are compared,
// and then each other count in ascending order. `shading` may be null; the picture is then black instead of showing
// E.
std::vector<CharactersCost> benchCharacters(const RenderOptions& options, const Shot& shot, ShadingSet* shading,
                                            std::vector<int> counts, int runs, int threads);

}  // namespace penumbra
