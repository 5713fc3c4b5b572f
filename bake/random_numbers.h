#pragma once
// The project's own pseudo-random numbers: the same on every platform and library, unlike std::shuffle.
#include <cstdint>
#include <span>
#include <utility>

namespace penumbra {

// SplitMix64 (Steele, Lea, Flood 2014): the next of a sequence of uniform 64-bit numbers.
inline std::uint64_t nextRandom(std::uint64_t& state) {
    std::uint64_t z = (state += 0x9e3779b97f4a7c15u);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
}

// Uniform in [0, 1).
inline double nextUniform(std::uint64_t& state) { return double(nextRandom(state) >> 11) * 0x1p-53; }

// Uniform over permutations, but for the 2^-53 of nextUniform().
template <class T>
void shuffle(std::span<T> items, std::uint64_t& state) {
    for (std::size_t i = items.size(); i > 1; --i)
        std::swap(items[i - 1], items[std::size_t(nextUniform(state) * double(i))]);
}

}  // namespace penumbra
