#pragma once
// The flapping sheet as files that hold meshes or positions, and what every reader must make of it.
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cstdio>
#include <filesystem>
#include <string>

#include "formats/cache/point_cache.h"
#include "tests/difference.h"
#include "tests/formats/flapping_sheet.h"
#include "tests/formats/rig_samples.h"

namespace penumbra::samples {

// A float of about 1 is rounded by 6e-8.
constexpr double kFloat = 2e-7;

inline double distanceToSheet(const PointCache& cache, const std::vector<Vec3>& positions, double frame) {
    const std::vector<Vec3d> expected = sheetFrame(frame);
    EXPECT_EQ(positions.size(), cache.mesh.vertexCount());
    Largest worst;
    for (std::size_t v = 0; v < expected.size(); ++v)
        worst.add(length(toDouble(positions[cache.mesh.source_vertex[v]]) - expected[v]));
    return worst;
}

// Expects one clip of 13 frames, the sheet's faces, and every position within `tolerance`.
inline void expectSheet(const PointCache& cache, double tolerance) {
    ASSERT_EQ(cache.clips.size(), 1u);
    ASSERT_EQ(cache.clips[0].times.size(), kSheetFrames);
    ASSERT_EQ(cache.mesh.source_vertex.size(), kSheetVertices);
    for (std::size_t f = 0; f < kSheetFrames; ++f)
        EXPECT_LE(distanceToSheet(cache, readFrame(cache, 0, f), double(f)), tolerance) << "frame " << f;
    std::vector<Triangle> triangles;
    for (const auto& q : sheetQuads())
        for (const Triangle& t : {Triangle{q[0], q[1], q[2]}, Triangle{q[0], q[2], q[3]}})
            triangles.push_back(
                {cache.mesh.source_vertex[t[0]], cache.mesh.source_vertex[t[1]], cache.mesh.source_vertex[t[2]]});
    EXPECT_EQ(cache.mesh.triangles, triangles);
}

template <class... Numbers>
std::string format(const char* pattern, Numbers... numbers) {
    char text[200];
    std::snprintf(text, sizeof text, pattern, numbers...);
    return text;
}

inline std::string sheetObj(std::size_t frame) {
    std::string text = "# frame " + std::to_string(frame) + "\n";
    for (const Vec3d p : sheetFrame(double(frame))) text += format("v %.9g %.9g %.9g\n", p.x, p.y, p.z);
    for (const auto& q : sheetQuads()) text += format("f %u %u %u %u\n", q[0] + 1, q[1] + 1, q[2] + 1, q[3] + 1);
    return text;
}

template <class T>
std::string ordered(T value, std::endian order) {
    std::string bytes = bytesOf(value);
    if (order != std::endian::native) std::reverse(bytes.begin(), bytes.end());
    return bytes;
}

inline std::string sheetPly(std::size_t frame, const std::string& encoding) {
    const std::endian order = encoding == "binary_big_endian" ? std::endian::big : std::endian::little;
    const bool ascii = encoding == "ascii";
    std::string text = "ply\nformat " + encoding +
                       " 1.0\ncomment a sheet\nelement vertex 45\nproperty double x\nproperty float y\nproperty float "
                       "z\nproperty uchar red\nelement face 24\nproperty list uchar int vertex_indices\nend_header\n";
    for (const Vec3d p : sheetFrame(double(frame)))
        text += ascii ? format("%.17g %.9g %.9g 7\n", p.x, p.y, p.z)
                      : ordered(p.x, order) + ordered(float(p.y), order) + ordered(float(p.z), order) + "\7";
    for (const auto& q : sheetQuads()) {
        text += ascii ? std::string("4 ") : std::string("\4");
        for (const std::uint32_t v : q) text += ascii ? std::to_string(v) + " " : ordered(std::int32_t(v), order);
        if (ascii) text += "\n";
    }
    return text;
}

inline std::string sheetFloats(std::endian order) {
    std::string bytes;
    for (std::size_t f = 0; f < kSheetFrames; ++f)
        for (const Vec3d p : sheetFrame(double(f)))
            for (const double x : {p.x, p.y, p.z}) bytes += ordered(float(x), order);
    return bytes;
}

// Frame f stands at (1 + f)/8 s.
inline std::string sheetMdd() {
    std::string bytes =
        ordered(std::int32_t(kSheetFrames), std::endian::big) + ordered(std::int32_t(kSheetVertices), std::endian::big);
    for (std::size_t f = 0; f < kSheetFrames; ++f) bytes += ordered(float(1 + f) / 8, std::endian::big);
    return bytes + sheetFloats(std::endian::big);
}

inline std::string sheetPc2(float start, float step) {
    const auto little = [](auto value) { return ordered(value, std::endian::little); };
    return std::string("POINTCACHE2\0", 12) + little(std::int32_t(1)) + little(std::int32_t(kSheetVertices)) +
           little(start) + little(step) + little(std::int32_t(kSheetFrames)) + sheetFloats(std::endian::little);
}

// Writes BEFORE0000AFTER, BEFORE0001AFTER, ... in `folder`.
template <class TextOfFrame>
void writeSheets(const std::filesystem::path& folder, const std::string& before, const std::string& after,
                 const TextOfFrame& text) {
    for (std::size_t f = 0; f < kSheetFrames; ++f)
        writeText(folder / (before + format("%04u", unsigned(f)) + after), text(f));
}

}  // namespace penumbra::samples
