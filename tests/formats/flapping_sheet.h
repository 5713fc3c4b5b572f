#pragma once
// The sheet of scripts/samples/flapping_sheet.py by formula, and point caches that a test writes.
#include <zlib.h>

#include <cmath>
#include <cstdint>
#include <numbers>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "formats/common/mesh.h"

namespace penumbra::samples {

constexpr std::size_t kSheetColumns = 7, kSheetRows = 5, kSheetFrames = 13, kSheetVertices = 45, kSheetPoints = 40;
constexpr std::size_t kSeamColumn = 3, kSlitColumn = 5;

// Returns column and row of a source vertex. The last ten are the doubles of the seam and of the slit.
inline std::pair<std::size_t, std::size_t> sheetPlace(std::size_t vertex) {
    const std::size_t grid = kSheetColumns * kSheetRows;
    if (vertex < grid) return {vertex % kSheetColumns, vertex / kSheetColumns};
    return {vertex < grid + kSheetRows ? kSeamColumn : kSlitColumn, (vertex - grid) % kSheetRows};
}

inline std::vector<Vec3d> sheetFrame(double frame) {
    std::vector<Vec3d> positions;
    for (std::size_t vertex = 0; vertex < kSheetVertices; ++vertex) {
        const auto [column, row] = sheetPlace(vertex);
        const double u = double(column) / 6, v = double(row) / 4, phase = frame / 12;
        const double opening = vertex >= kSheetRows * (kSheetColumns + 1) ? 0.05 : 0;
        positions.push_back(
            {1.2 * u, v, 0.3 * u * std::sin(2 * std::numbers::pi * phase + 3 * u + v) + opening * phase});
    }
    return positions;
}

inline std::vector<std::array<std::uint32_t, 4>> sheetQuads() {
    const auto vertex = [](std::size_t column, std::size_t row, bool right) {
        if (right && column == kSeamColumn) return std::uint32_t(35 + row);
        if (right && column == kSlitColumn) return std::uint32_t(40 + row);
        return std::uint32_t(row * kSheetColumns + column);
    };
    std::vector<std::array<std::uint32_t, 4>> quads;
    for (std::size_t r = 0; r + 1 < kSheetRows; ++r)
        for (std::size_t c = 0; c + 1 < kSheetColumns; ++c)
            quads.push_back(
                {vertex(c, r, true), vertex(c + 1, r, false), vertex(c + 1, r + 1, false), vertex(c, r + 1, true)});
    return quads;
}

// --- Bytes of NumPy files -------------------------------------------------------------------------------------------

template <class T>
std::string bytesOf(const T& value) {
    return {reinterpret_cast<const char*>(&value), sizeof(T)};
}

template <class T>
std::string bytesOf(const std::vector<T>& values) {
    return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)};
}

// Returns a header such as "{'descr': '<f4', 'fortran_order': False, 'shape': (2, 3), }" and the data.
inline std::string npy(const std::string& header, const std::string& data) {
    return std::string("\x93NUMPY\x01\x00", 8) + bytesOf(std::uint16_t(header.size())) + header + data;
}

inline std::string npy(const std::string& type, const std::string& shape, const std::string& data) {
    return npy("{'descr': '" + type + "', 'fortran_order': False, 'shape': (" + shape + "), }", data);
}

inline std::string deflated(const std::string& data) {
    z_stream z{};
    deflateInit2(&z, 6, Z_DEFLATED, -15, 8, Z_DEFAULT_STRATEGY);
    std::string out(deflateBound(&z, data.size()), '\0');
    z.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(data.data()));
    z.avail_in = uInt(data.size());
    z.next_out = reinterpret_cast<Bytef*>(out.data());
    z.avail_out = uInt(out.size());
    deflate(&z, Z_FINISH);
    out.resize(z.total_out);
    deflateEnd(&z);
    return out;
}

struct ZipEntry {
    std::string name, data;
    bool compress = false;
    bool zip64 = false;  // sizes and offset in the extra field, as in archives beyond 4 GiB
    int method = -1;     // method that the directory states instead of the true one; -1: the true one
    std::uint64_t stated_size = 0;
    std::string behind = "";  // bytes of the member behind the end of its deflate stream
};

inline std::string zipOf(const std::vector<ZipEntry>& entries, bool zip64_end = false) {
    std::string file, directory;
    const auto u16 = [](std::size_t v) { return bytesOf(std::uint16_t(v)); };
    const auto u32 = [](std::size_t v) { return bytesOf(std::uint32_t(v)); };
    const auto u64 = [](std::size_t v) { return bytesOf(std::uint64_t(v)); };
    for (const ZipEntry& entry : entries) {
        const std::string packed = entry.compress ? deflated(entry.data) + entry.behind : entry.data;
        const std::size_t size = entry.stated_size != 0 ? entry.stated_size : entry.data.size(), offset = file.size();
        const auto crc = crc32(0, reinterpret_cast<const Bytef*>(entry.data.data()), uInt(entry.data.size()));
        const std::string method = u16(entry.method >= 0 ? std::size_t(entry.method) : entry.compress ? 8 : 0);
        const std::string extra = entry.zip64 ? u16(1) + u16(24) + u64(size) + u64(packed.size()) + u64(offset) : "";
        const std::string sizes = entry.zip64 ? u32(0xffffffff) + u32(0xffffffff) : u32(packed.size()) + u32(size);
        const std::string common = u16(0) + method + u32(0) + u32(crc) + sizes + u16(entry.name.size());
        file += "PK\3\4" + u16(45) + common + u16(0) + entry.name + packed;
        directory += "PK\1\2" + u16(45) + u16(45) + common + u16(extra.size()) + u16(0) + u16(0) + u16(0) + u32(0) +
                     u32(entry.zip64 ? 0xffffffff : offset) + entry.name + extra;
    }
    const std::size_t start = file.size();
    file += directory;
    if (zip64_end) {
        const std::size_t end64 = file.size();
        file += "PK\6\6" + u64(44) + u16(45) + u16(45) + u32(0) + u32(0) + u64(entries.size()) + u64(entries.size()) +
                u64(directory.size()) + u64(start) + "PK\6\7" + u32(0) + u64(end64) + u32(1);
        return file + "PK\5\6" + u16(0) + u16(0) + u16(0xffff) + u16(0xffff) + u32(0xffffffff) + u32(0xffffffff) +
               u16(0);
    }
    return file + "PK\5\6" + u16(0) + u16(0) + u16(entries.size()) + u16(entries.size()) + u32(directory.size()) +
           u32(start) + u16(0);
}

inline std::string sheetVerts(std::size_t frames = kSheetFrames) {
    std::vector<float> numbers;
    for (std::size_t f = 0; f < frames; ++f)
        for (const Vec3d p : sheetFrame(double(f))) numbers.insert(numbers.end(), {float(p.x), float(p.y), float(p.z)});
    return npy("<f4", std::to_string(frames) + ", 45, 3", bytesOf(numbers));
}

inline std::string sheetFaces() { return npy("<u4", "24, 4", bytesOf(sheetQuads())); }

}  // namespace penumbra::samples
