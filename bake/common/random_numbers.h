#pragma once
// The project's own pseudo-random numbers. Unlike std::shuffle they are the same on every platform and library.
#include <cstdint>
#include <span>
#include <utility>

namespace penumbra {

// Returns the next number of a sequence of uniform 64-bit numbers by SplitMix64 (Steele, Lea, Flood 2014).
inline std::uint64_t nextRandom(std::uint64_t& state) {
    std::uint64_t z = (state += 0x9e3779b97f4a7c15u);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
}

// Returns the next number, uniform in [0, 1).
inline double nextUniform(std::uint64_t& state) { return double(nextRandom(state) >> 11) * 0x1p-53; }

// Shuffles uniformly over all permutations, up to the 2^-53 that nextUniform() resolves.
template <class T>
void shuffle(std::span<T> items, std::uint64_t& state) {
    for (std::size_t i = items.size(); i > 1; --i)
        std::swap(items[i - 1], items[std::size_t(nextUniform(state) * double(i))]);
}

}  // namespace penumbra
