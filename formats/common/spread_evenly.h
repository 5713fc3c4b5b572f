#pragma once
// Takes some of many things where looking at all of them would take too long.
#include <algorithm>
#include <cstddef>
#include <ranges>
#include <vector>

namespace penumbra {

// Returns `most` numbers below `count` that are spread evenly, or all of them, ascending.
inline std::vector<std::size_t> spreadEvenly(std::size_t count, std::size_t most) {
    std::vector<std::size_t> chosen(std::min(count, most));
    for (std::size_t i = 0; i < chosen.size(); ++i) chosen[i] = i * count / chosen.size();
    return chosen;
}

// Returns the things at such places, in their order.
template <class Range>
std::vector<std::ranges::range_value_t<Range>> evenSample(const Range& all, std::size_t most) {
    std::vector<std::ranges::range_value_t<Range>> sample;
    for (const std::size_t i : spreadEvenly(all.size(), most)) sample.push_back(all[i]);
    return sample;
}

}  // namespace penumbra
