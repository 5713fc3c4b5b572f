#include "sh/height/analytic_heights.h"

#include <cmath>
#include <numbers>
#include <numeric>
#include <stdexcept>

#include "sh/key_values.h"

namespace penumbra {

namespace {

constexpr double kGravity = 9.81, kRadians = std::numbers::pi / 180;

AnalyticHeights parseOne(std::string_view text) {
    const std::size_t colon = text.find(':');
    const std::string_view name = text.substr(0, colon);
    AnalyticHeights out;
    if (name == "waves") {
        out.kind = AnalyticHeights::Kind::kWaves;
    } else if (name == "dunes") {
        out = {AnalyticHeights::Kind::kDunes, 1, 8, 0.1, 0, 0, 1, 1};
    } else if (name == "ripples") {
        out = {AnalyticHeights::Kind::kRipples, 0.1, 1, 1, 0, 0, 1, 1};
    } else {
        throw std::invalid_argument("'" + std::string(name) + "' is not waves, dunes or ripples");
    }
    if (colon == text.npos) return out;
    for (const KeyValue& item : splitKeyValues(text.substr(colon + 1))) {
        const auto number = [&](double least, double most) { return parseNumber(item.key, item.value, least, most); };
        if (item.key == "height")
            out.height = number(0, 1e6);
        else if (item.key == "length")
            out.length = number(1e-3, 1e6);
        else if (item.key == "speed")
            out.speed = number(-1e3, 1e3);
        else if (item.key == "angle" && out.kind != AnalyticHeights::Kind::kRipples)
            out.angle = number(-360, 360);
        else if (item.key == "spread" && out.kind == AnalyticHeights::Kind::kWaves)
            out.spread = number(0, 180);
        else if (item.key == "count" && out.kind == AnalyticHeights::Kind::kWaves)
            out.count = int(number(1, 64));
        else if (item.key == "seed" && out.kind == AnalyticHeights::Kind::kWaves)
            out.seed = int(number(0, 1e6));
        else
            throw std::invalid_argument("'" + std::string(item.key) + "' is not a key of " + std::string(name));
    }
    return out;
}

// A number in [0, 1) for each i; van der Corput's sequences, so that few trains are well spread.
double scattered(int i, int seed) {
    const double x = (i + 1) * 0.6180339887498949 + seed * 0.7548776662466927;
    return x - std::floor(x);
}

// Adds amplitude sin(kx x + ky y + phase) to a row. y advances by one rotation a point, in blocks that start anew.
void addWave(double kx, double ky, double phase, double amplitude, double x, const HeightGrid& grid, double first_y,
             float* row) {
    constexpr int kBlock = 256;
    const double step_cos = std::cos(ky * double(grid.cell_y)), step_sin = std::sin(ky * double(grid.cell_y));
    for (int begin = 0; begin < grid.columns; begin += kBlock) {
        const double start = kx * x + ky * (first_y + begin * double(grid.cell_y)) + phase;
        double c = amplitude * std::cos(start), s = amplitude * std::sin(start);
        for (int i = begin; i < std::min(begin + kBlock, grid.columns); ++i) {
            row[i] += float(s);
            const double next = s * step_cos + c * step_sin;
            c = c * step_cos - s * step_sin;
            s = next;
        }
    }
}

// A direction with a rate: full waves a metre along x and along y.
struct WaveVector {
    double x = 0, y = 0;
    double length() const { return std::hypot(x, y); }
    double at(double px, double py) const { return x * px + y * py; }
};

// Returns the nearest wave vector that a field closes with: whole numbers of waves along both sides, not both 0.
WaveVector closed(WaveVector wave, const HeightGrid& grid) {
    if (grid.border != HeightBorder::kPeriodic) return wave;
    const double side_x = grid.rows * double(grid.cell_x), side_y = grid.columns * double(grid.cell_y);
    double count_x = std::round(wave.x * side_x), count_y = std::round(wave.y * side_y);
    if (count_x == 0 && count_y == 0) {
        if (std::abs(wave.x * side_x) > std::abs(wave.y * side_y))
            count_x = std::copysign(1, wave.x);
        else
            count_y = std::copysign(1, wave.y);
    }
    return {count_x / side_x, count_y / side_y};
}

void addWaves(const AnalyticHeights& waves, const HeightGrid& grid, double seconds, double x, double first_y,
              float* row) {
    for (int i = 0; i < waves.count; ++i) {
        const double angle = kRadians * (waves.angle + waves.spread * (2 * scattered(i, waves.seed) - 1)),
                     length = waves.length * std::exp2(1.5 * (scattered(i, waves.seed + 7) - 0.5));
        const WaveVector wave = closed({std::sin(angle) / length, std::cos(angle) / length}, grid);
        const double k = 2 * std::numbers::pi * wave.length(),
                     phase = 2 * std::numbers::pi * scattered(i, waves.seed + 13) -
                             std::sqrt(kGravity * k) * waves.speed * seconds;
        // Longer waves are higher, so that all are as steep.
        addWave(2 * std::numbers::pi * wave.x, 2 * std::numbers::pi * wave.y, phase,
                waves.height * (length / waves.length) / std::sqrt(double(waves.count)), x, grid, first_y, row);
    }
}

// Rises over four fifths of its length and falls over the last one, both as half a cosine.
double dune(double u) {
    u -= std::floor(u);
    constexpr double kGentle = 0.8;
    const double part = u < kGentle ? u / kGentle : (1 - u) / (1 - kGentle);
    return 0.5 - 0.5 * std::cos(std::numbers::pi * part);
}

// Returns the radians from one crest's shape to the next one's. On a periodic grid crests repeat after as many as their
// numbers along both sides have in common.
double crestTurn(const WaveVector& along, const HeightGrid& grid) {
    constexpr double kTurn = 0.9;
    if (grid.border != HeightBorder::kPeriodic) return kTurn;
    const auto count_x = std::lround(along.x * grid.rows * double(grid.cell_x)),
               count_y = std::lround(along.y * grid.columns * double(grid.cell_y));
    const double common = double(std::gcd(count_x, count_y)), full = 2 * std::numbers::pi;
    return full * std::round(kTurn * common / full) / common;
}

void addDunes(const AnalyticHeights& dunes, const HeightGrid& grid, double seconds, double x, double first_y,
              float* row) {
    constexpr double kFull = 2 * std::numbers::pi;
    const double s = std::sin(kRadians * dunes.angle), c = std::cos(kRadians * dunes.angle);
    const auto across = [&](double rate) {
        const double waves = rate / (kFull * dunes.length);
        return closed({-c * waves, s * waves}, grid);
    };
    const WaveVector along = closed({s / dunes.length, c / dunes.length}, grid), wide = across(2.1), fine = across(4.7),
                     crests = across(1.3);
    const double turn = crestTurn(along, grid), travelled = seconds * dunes.speed * along.length();
    for (int i = 0; i < grid.columns; ++i) {
        const double y = first_y + i * double(grid.cell_y);
        const double bend = 0.25 * std::sin(kFull * wide.at(x, y) + 1) + 0.12 * std::sin(kFull * fine.at(x, y)),
                     u = along.at(x, y) - travelled + bend;
        const double crest = 0.75 + 0.25 * std::sin(kFull * crests.at(x, y) + turn * std::floor(u));
        row[i] += float(dunes.height * crest * dune(u));
    }
}

void addRipples(const AnalyticHeights& ripples, const HeightGrid& grid, double seconds, double x, double first_y,
                float* row) {
    const bool closes = grid.border == HeightBorder::kPeriodic;
    const auto onTorus = [&](double at, int points, float cell) {
        const double side = points * double(cell);
        return closes ? side / std::numbers::pi * std::sin(std::numbers::pi * at / side) : at;
    };
    const double torus_x = onTorus(x, grid.rows, grid.cell_x);
    for (int i = 0; i < grid.columns; ++i) {
        const double torus_y = onTorus(first_y + i * double(grid.cell_y), grid.columns, grid.cell_y),
                     at = std::hypot(torus_x, torus_y) / ripples.length;
        row[i] += float(ripples.height / (1 + at) *
                        std::cos(2 * std::numbers::pi * (at - seconds * ripples.speed / ripples.length)));
    }
}

}  // namespace

std::vector<AnalyticHeights> parseAnalyticHeights(std::string_view text) {
    std::vector<AnalyticHeights> out;
    for (std::size_t begin = 0; begin <= text.size();) {
        std::size_t end = text.find('+', begin);
        // A digit after it: the + is of a number, as in 1e+06.
        while (end < text.size() && end + 1 < text.size() && text[end + 1] >= '0' && text[end + 1] <= '9')
            end = text.find('+', end + 1);
        end = std::min(end, text.size());
        out.push_back(parseOne(text.substr(begin, end - begin)));
        begin = end + 1;
        if (out.size() > 16) throw std::invalid_argument("more than 16 fields are joined by +");
    }
    return out;
}

void analyticHeights(std::span<const AnalyticHeights> fields, const HeightGrid& grid, double seconds, int first_row,
                     int end_row, std::span<float> heights) {
    const double first_x = -0.5 * (grid.rows - 1) * double(grid.cell_x),
                 first_y = -0.5 * (grid.columns - 1) * double(grid.cell_y);
    for (int r = first_row; r < end_row; ++r) {
        float* const row = heights.data() + std::size_t(r) * std::size_t(grid.columns);
        std::fill_n(row, grid.columns, 0.0f);
        const double x = first_x + r * double(grid.cell_x);
        for (const AnalyticHeights& field : fields) {
            switch (field.kind) {
                case AnalyticHeights::Kind::kWaves:
                    addWaves(field, grid, seconds, x, first_y, row);
                    break;
                case AnalyticHeights::Kind::kDunes:
                    addDunes(field, grid, seconds, x, first_y, row);
                    break;
                case AnalyticHeights::Kind::kRipples:
                    addRipples(field, grid, seconds, x, first_y, row);
                    break;
            }
        }
    }
}

}  // namespace penumbra
