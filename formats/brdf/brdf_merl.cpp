// Reads the MERL BRDF database (Matusik et al. 2003): three int32 90, 90, 180, then the planes R, G, B of doubles
// over theta_h (slowest), theta_d, phi_d in 0..pi. Numbers are little-endian. A negative one means that there is no
// measurement.
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>

#include "formats/brdf/brdf_readers.h"
#include "formats/brdf/half_difference_table.h"
#include "formats/common/errors.h"

namespace penumbra {

namespace {

static_assert(std::endian::native == std::endian::little);

constexpr std::size_t kThetaH = 90, kThetaD = 90, kPhiD = 180;
constexpr std::size_t kCells = kThetaH * kThetaD * kPhiD, kHeader = 3 * sizeof(std::int32_t);
constexpr std::array<double, 3> kScale = {1.0 / 1500, 1.15 / 1500, 1.66 / 1500};  // the scale in the database's own
                                                                                  // reader
constexpr double kMaxReflectance = 1e6;  // 1/sr: more than any measurement; keeps floats and sums finite

// Returns the three dimensions that a file begins with.
std::array<std::int32_t, 3> dimensionsOf(std::string_view bytes) {
    std::array<std::int32_t, 3> size{};
    if (bytes.size() >= kHeader) std::memcpy(size.data(), bytes.data(), kHeader);
    return size;
}

}  // namespace

bool looksLikeMerl(std::string_view bytes) {
    return dimensionsOf(bytes) == std::array<std::int32_t, 3>{kThetaH, kThetaD, kPhiD};
}

namespace {

void checkSize(std::string_view bytes, const std::string& name) {
    const std::size_t expected = kHeader + 3 * kCells * sizeof(double);
    if (bytes.size() < kHeader)
        throw InvalidInput(name + ": " + std::to_string(bytes.size()) + " bytes, too short for a MERL file");
    const std::array<std::int32_t, 3> size = dimensionsOf(bytes);
    if (!looksLikeMerl(bytes))
        throw InvalidInput(name + ": dimensions are " + std::to_string(size[0]) + " x " + std::to_string(size[1]) +
                           " x " + std::to_string(size[2]) + ", those of a MERL file are 90 x 90 x 180");
    if (bytes.size() != expected)
        throw InvalidInput(name + ": has " + std::to_string(bytes.size()) + " bytes, a MERL file has " +
                           std::to_string(expected));
}

double valueAt(std::string_view bytes, const std::string& name, std::size_t channel, std::size_t cell) {
    double value = 0;
    std::memcpy(&value, bytes.data() + kHeader + (channel * kCells + cell) * sizeof value, sizeof value);
    if (!std::isfinite(value) || value * kScale[channel] > kMaxReflectance)
        throw InvalidInput(name + ": channel " + "RGB"[channel] + " of cell theta_h " +
                           std::to_string(cell / (kThetaD * kPhiD)) + ", theta_d " +
                           std::to_string(cell / kPhiD % kThetaD) + ", phi_d " + std::to_string(cell % kPhiD) +
                           (std::isfinite(value) ? " is larger than any measurement" : " is NaN or infinite"));
    return value;
}

// Makes the cells of phi_d in 0..pi/2, each the mean of a cell and its mirror image. `known` becomes 0 where a
// channel has neither.
HalfDifferenceTable foldMirror(std::string_view bytes, const std::string& name, std::vector<char>& known) {
    HalfDifferenceTable table{int(kThetaH), int(kThetaD), int(kPhiD / 2), std::vector<Vec3>(kCells / 2)};
    known.assign(kCells / 2, 1);
    for (std::size_t row = 0; row < kThetaH * kThetaD; ++row)
        for (std::size_t phi = 0; phi < kPhiD / 2; ++phi)
            for (std::size_t channel = 0; channel < 3; ++channel) {
                const std::size_t cell = row * kPhiD / 2 + phi;
                double sum = 0;
                int measured = 0;
                for (const std::size_t image : {phi, kPhiD - 1 - phi}) {
                    const double value = valueAt(bytes, name, channel, row * kPhiD + image);
                    if (value < 0) continue;
                    sum += value * kScale[channel];
                    ++measured;
                }
                if (measured == 0)
                    known[cell] = 0;
                else
                    table.values[cell][int(channel)] = float(sum / measured);
            }
    return table;
}

std::array<std::ptrdiff_t, 6> neighboursOf(std::size_t cell, const HalfDifferenceTable& table) {
    const std::size_t p = std::size_t(table.phi_d), d = std::size_t(table.theta_d), h = std::size_t(table.theta_h);
    const std::size_t ip = cell % p, id = cell / p % d, ih = cell / (p * d);
    const auto at = std::ptrdiff_t(cell);
    return {ip > 0 ? at - 1 : -1,
            ip + 1 < p ? at + 1 : -1,
            id > 0 ? at - std::ptrdiff_t(p) : -1,
            id + 1 < d ? at + std::ptrdiff_t(p) : -1,
            ih > 0 ? at - std::ptrdiff_t(p * d) : -1,
            ih + 1 < h ? at + std::ptrdiff_t(p * d) : -1};
}

// Fills unknown cells layer by layer from the measured cells outwards. A cell gets the mean of its neighbours in the
// layers before its own.
void fillUnknown(HalfDifferenceTable& table, std::vector<char>& known) {
    std::vector<std::size_t> layer;
    const auto addUnknownNeighbours = [&](std::size_t cell, std::vector<char>& queued) {
        for (std::ptrdiff_t n : neighboursOf(cell, table))
            if (n >= 0 && !known[std::size_t(n)] && !queued[std::size_t(n)]) {
                queued[std::size_t(n)] = 1;
                layer.push_back(std::size_t(n));
            }
    };
    std::vector<char> queued(known.size());
    for (std::size_t cell = 0; cell < known.size(); ++cell)
        if (known[cell]) addUnknownNeighbours(cell, queued);
    while (!layer.empty()) {
        const std::vector<std::size_t> filling = std::move(layer);
        layer.clear();
        for (std::size_t cell : filling) {
            Vec3 sum;
            int count = 0;
            for (std::ptrdiff_t n : neighboursOf(cell, table))
                if (n >= 0 && known[std::size_t(n)]) {
                    sum += table.values[std::size_t(n)];
                    ++count;
                }
            table.values[cell] = sum / float(count);
        }
        for (std::size_t cell : filling) known[cell] = 1;
        for (std::size_t cell : filling) addUnknownNeighbours(cell, queued);
    }
}

}  // namespace

BrdfReading decodeMerl(std::string_view bytes, const std::string& name) {
    checkSize(bytes, name);
    std::vector<char> known;
    HalfDifferenceTable table = foldMirror(bytes, name, known);
    double unmeasured = 0, measured = 0;
    for (std::size_t cell = 0; cell < known.size(); ++cell) {
        measured += known[cell];
        if (known[cell]) continue;
        const auto [wi, wo] = directionsOf(table.center(cell));
        unmeasured += wi.z > 0 && wo.z > 0;
    }
    if (measured == 0) throw InvalidInput(name + ": no cell has a measurement (all values are negative)");
    fillUnknown(table, known);
    return {interpolated(name, std::move(table)), {{"samples", measured}, {"unmeasured", unmeasured}}};
}

}  // namespace penumbra
