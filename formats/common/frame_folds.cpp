#include "formats/common/frame_folds.h"

#include <algorithm>
#include <numeric>

namespace penumbra {

namespace {

struct FrameBlock {
    std::size_t begin, end;  // positions in the list of training frames
    std::size_t size() const { return end - begin; }
};

// Cuts the training frames into blocks of consecutive frames.
std::vector<FrameBlock> makeFrameBlocks(const FrameList& list, std::span<const std::size_t> frames) {
    std::vector<FrameBlock> blocks;
    // 1. Each clip is a block.
    for (std::size_t i = 0; i < frames.size(); ++i) {
        if (i == 0 || list.clip[frames[i]] != list.clip[frames[i - 1]]) blocks.push_back({i, i});
        blocks.back().end = i + 1;
    }
    // 2. Cut the longest block in half until there are enough.
    while (blocks.size() < std::min(kMinFolds, frames.size())) {
        const auto longest = std::max_element(blocks.begin(), blocks.end(),
                                              [](FrameBlock a, FrameBlock b) { return a.size() < b.size(); });
        const FrameBlock whole = *longest;
        const std::size_t middle = whole.begin + whole.size() / 2;
        *longest = {whole.begin, middle};
        blocks.insert(longest + 1, {middle, whole.end});
    }
    return blocks;
}

}  // namespace

std::vector<int> dealOut(std::span<const std::size_t> sizes, std::size_t groups) {
    std::vector<std::size_t> order(sizes.size()), filled(groups);
    std::iota(order.begin(), order.end(), std::size_t(0));
    std::stable_sort(order.begin(), order.end(), [&](auto a, auto b) { return sizes[a] > sizes[b]; });
    std::vector<int> group(sizes.size());
    for (const std::size_t i : order) {
        group[i] = int(std::ranges::min_element(filled) - filled.begin());
        filled[std::size_t(group[i])] += sizes[i];
    }
    return group;
}

std::vector<int> makeFolds(const FrameList& list, std::span<const std::size_t> frames, std::size_t most) {
    const std::vector<FrameBlock> blocks = makeFrameBlocks(list, frames);
    std::vector<std::size_t> sizes;
    for (const FrameBlock& block : blocks) sizes.push_back(block.size());
    const std::vector<int> fold_of_block = dealOut(sizes, std::min(blocks.size(), most));
    std::vector<int> folds;
    for (std::size_t b = 0; b < blocks.size(); ++b) folds.insert(folds.end(), sizes[b], fold_of_block[b]);
    return folds;
}

}  // namespace penumbra
