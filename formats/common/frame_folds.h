#pragma once
// Deals frames out to the folds of a cross-validation.
#include <cstddef>
#include <span>
#include <vector>

#include "formats/common/mesh.h"

namespace penumbra {

constexpr std::size_t kMinFolds = 4, kMaxFolds = 8;

// Deals things of these sizes out to `groups` groups: starting with the largest, each goes to the group that has the
// least so far. Returns the group of each.
std::vector<int> dealOut(std::span<const std::size_t> sizes, std::size_t groups);

// Returns the fold of each training frame, [frames.size()]. Neighbouring frames are nearly equal, so folds are made of
// blocks. Each clip is a block; while there are fewer than 4 blocks, the longest is cut in half. When there are more
// than `most`, they are dealt out to as many folds. `frames` are the training frames in ascending order.
std::vector<int> makeFolds(const FrameList& list, std::span<const std::size_t> frames, std::size_t most = kMaxFolds);

}  // namespace penumbra
