#pragma once
// Many characters that share an asset: what each costs in time and memory.
#include <span>

#include "player/bench.h"

namespace penumbra {

// In the order of `counts`. `shading` may be null: E is not drawn then, but black.
std::vector<CharactersCost> benchCharacters(const RenderOptions& options, const Shot& shot, ShadingSet* shading,
                                            std::span<const int> counts, int runs, int threads);

}  // namespace penumbra
