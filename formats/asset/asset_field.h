#pragma once
// Checks one field of a verified FlatBuffer. Only asset_checks*.cpp include this. Sizes are compared in 64 bits
// before anything is read through them.
#include <flatbuffers/flatbuffers.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "formats/common/errors.h"
#include "sh/vec3.h"

namespace penumbra {

// A place in the file, which every failure names.
struct Field {
    std::string path;  // "FILE: model.clusters[3]"

    Field operator/(const std::string& name) const { return {path + (path.ends_with(": ") ? "" : ".") + name}; }
    Field operator[](std::size_t i) const { return {path + "[" + std::to_string(i) + "]"}; }
    [[noreturn]] void fail(const std::string& what) const { throw InvalidInput(path + " " + what); }
    void require(bool ok, const char* what) const {
        if (!ok) fail(what);
    }
};

// Returns a vector's elements as T (whose size is a multiple of the stored element's), 16-byte aligned. An absent
// vector is empty.
template <class T, class Stored>
std::span<const T> spanOf(const flatbuffers::Vector<Stored>* vector, const Field& at) {
    static_assert(sizeof(T) % sizeof(Stored) == 0);
    if (!vector || vector->size() == 0) return {};
    const std::size_t bytes = std::size_t(vector->size()) * sizeof(Stored);
    at.require(bytes % sizeof(T) == 0, "has a broken last element");
    at.require(reinterpret_cast<std::uintptr_t>(vector->data()) % 16 == 0, "is not 16-byte aligned");
    return {reinterpret_cast<const T*>(vector->data()), bytes / sizeof(T)};
}

// Returns what spanOf() returns, but fails where the vector is absent. It may be empty.
template <class T, class Stored>
std::span<const T> requiredSpanOf(const flatbuffers::Vector<Stored>* vector, const Field& at) {
    if (!vector) at.fail("is missing");
    return spanOf<T>(vector, at);
}

// These throw InvalidInput unless the count, the range or the indices are as expected.
template <class T>
void checkCount(const Field& at, std::span<const T> values, std::uint64_t expected) {
    if (values.size() != expected)
        at.fail("has " + std::to_string(values.size()) + " elements, expected " + std::to_string(expected));
}

inline void checkRange(const Field& at, std::int64_t value, std::int64_t low, std::int64_t high) {
    if (value < low || value > high)
        at.fail("is " + std::to_string(value) + ", allowed are " + std::to_string(low) + ".." + std::to_string(high));
}

template <class T>
void checkIndices(const Field& at, std::span<const T> indices, std::size_t limit) {
    for (std::size_t i = 0; i < indices.size(); ++i)
        if (std::size_t(indices[i]) >= limit)
            at[i].fail("is " + std::to_string(indices[i]) + ", beyond the last of " + std::to_string(limit));
}

// All exponent bits are 1 in NaN and infinity. The test works on integers, so that the loop is fast without
// -ffast-math.
template <class Word>
bool allFinite(const std::byte* data, std::size_t count, Word exponent) {
    bool bad = false;
    for (std::size_t i = 0; i < count; ++i) {
        Word bits;
        std::memcpy(&bits, data + i * sizeof(Word), sizeof(Word));
        bad |= Word(bits & exponent) == exponent;
    }
    return !bad;
}
inline bool finiteFloats(const std::byte* data, std::size_t count) {
    return allFinite<std::uint32_t>(data, count, 0x7f800000);
}
inline bool finiteHalves(const std::byte* data, std::size_t count) {
    return allFinite<std::uint16_t>(data, count, 0x7c00);
}

template <class T>
void checkFinite(const Field& at, std::span<const T> values) {
    static_assert(sizeof(T) % sizeof(float) == 0);
    at.require(finiteFloats(reinterpret_cast<const std::byte*>(values.data()), values.size_bytes() / sizeof(float)),
               "has a number that is not finite");
}

inline std::span<const Vec3> vectorsOf(const flatbuffers::Vector<float>* stored, const Field& at, std::size_t count) {
    const auto vectors = spanOf<Vec3>(stored, at);
    checkCount(at, vectors, count);
    checkFinite(at, vectors);
    return vectors;
}

inline std::span<const float> floatsOf(const flatbuffers::Vector<float>* stored, const Field& at, std::uint64_t count) {
    const auto values = spanOf<float>(stored, at);
    checkCount(at, values, count);
    checkFinite(at, values);
    return values;
}

inline void checkUnit(const Field& at, std::span<const Vec3> directions) {
    for (std::size_t i = 0; i < directions.size(); ++i)
        if (!(std::abs(dot(directions[i], directions[i]) - 1) < 1e-3f)) at[i].fail("is not a unit vector");
}

template <class T>
void checkUniqueNames(const Field& at, const std::vector<T>& named) {
    std::set<std::string_view> seen;
    for (const T& element : named) {
        const std::string_view name = [&] {
            if constexpr (std::is_same_v<T, std::string_view>)
                return element;
            else
                return element.name;
        }();
        at.require(seen.insert(name).second, ("has \"" + std::string(name) + "\" twice").c_str());
    }
}

inline std::string_view textOf(const flatbuffers::String* text) { return {text->c_str(), text->size()}; }

}  // namespace penumbra
