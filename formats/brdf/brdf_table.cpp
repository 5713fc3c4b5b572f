// Reads our own table of a BRDF, a text file (formats/README.md).
#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <numbers>

#include "formats/brdf/brdf_readers.h"
#include "formats/brdf/number_scanner.h"

namespace penumbra {

constexpr std::string_view kMagic = "penumbra-brdf-table";
constexpr int kMaxSteps = 1024;
constexpr std::size_t kMaxCells = std::size_t(1) << 24;
constexpr double kPi = std::numbers::pi, kMaxTableRadiance = 1e6;  // 1/sr

bool looksLikeBrdfTable(std::string_view text) { return text.starts_with(kMagic); }

namespace {

// Tells how an angle becomes a place between the nodes of the grid.
struct Axis {
    int count = 1;
    double first = 0, step = 1;  // angle of node 0 and angle between nodes, radians
    bool periodic = false;
};

struct BrdfTable {
    BrdfSymmetry symmetry = BrdfSymmetry::kIsotropic;
    std::array<Axis, 4> axes;  // theta_i, phi_i, theta_o, phi_o; isotropic: phi_i has one node, phi_o is the difference
    std::vector<Vec3> values;  // the last axis fastest
};

struct Between {
    std::size_t below, above;
    float share;  // weight of `above`

    Between(double angle, const Axis& axis) {
        double at = (angle - axis.first) / axis.step;
        if (axis.periodic)
            at -= axis.count * std::floor(at / axis.count);
        else
            at = std::clamp(at, 0.0, double(axis.count - 1));
        below = std::min(std::size_t(at), std::size_t(axis.count - 1));
        above =
            axis.periodic ? (below + 1) % std::size_t(axis.count) : std::min(below + 1, std::size_t(axis.count - 1));
        share = float(at - double(below));
    }
};

Vec3d lookUp(const BrdfTable& table, const std::array<double, 4>& angles) {
    const std::array<Between, 4> at = {Between(angles[0], table.axes[0]), Between(angles[1], table.axes[1]),
                                       Between(angles[2], table.axes[2]), Between(angles[3], table.axes[3])};
    Vec3 sum;
    for (unsigned corner = 0; corner < 16; ++corner) {
        std::size_t cell = 0;
        float weight = 1;
        for (std::size_t a = 0; a < 4; ++a) {
            const bool above = corner >> a & 1;
            cell = cell * std::size_t(table.axes[a].count) + (above ? at[a].above : at[a].below);
            weight *= above ? at[a].share : 1 - at[a].share;
        }
        if (weight > 0) sum += table.values[cell] * weight;
    }
    return toDouble(sum);
}

// The angles of a direction above the horizon, in radians.
struct Angles {
    double theta, phi;
};
Angles anglesOf(Vec3d w) { return {std::atan2(std::hypot(w.x, w.y), w.z), std::atan2(w.y, w.x)}; }

// Returns the angles of a view and remembers them. Integrals ask for one view with thousands of incident directions,
// and arc tangents take half of the time of a look-up.
Angles anglesOfView(Vec3d w) {
    thread_local Vec3d last{0, 0, 1};
    thread_local Angles angles = anglesOf(last);
    if (w != last) {
        last = w;
        angles = anglesOf(w);
    }
    return angles;
}

Vec3d evalTable(const BrdfTable& table, Vec3d wi, Vec3d wo) {
    if (wi.z <= 0 || wo.z <= 0) return {};
    if (table.symmetry == BrdfSymmetry::kOrthotropic) {
        if (wi.x < 0) wi.x = -wi.x, wo.x = -wo.x;
        if (wi.y < 0) wi.y = -wi.y, wo.y = -wo.y;
    }
    const Angles in = anglesOf(wi), out = anglesOfView(wo);
    double phi_i = in.phi, phi_o = out.phi;
    if (table.symmetry == BrdfSymmetry::kIsotropic) {
        phi_o = std::abs(std::remainder(phi_o - phi_i, 2 * kPi));
        phi_i = 0;
    }
    return lookUp(table, {in.theta, phi_i, out.theta, phi_o});
}

int readSteps(NumberScanner& scanner, const std::string& key, int least) {
    if (scanner.word() != key) scanner.fail("expected '" + key + "' and its number of steps");
    return scanner.integer(key, least, kMaxSteps);
}

Axis thetaAxis(int n) { return {n, kPi / 2 * 0.5 / n, kPi / 2 / n, false}; }
Axis openAxis(int n, double range) { return {n, 0, range / (n - 1), false}; }  // nodes at both ends
Axis circle(int n) { return {n, 0, 2 * kPi / n, true}; }

BrdfTable readHeader(NumberScanner& scanner) {
    if (scanner.word() != kMagic) scanner.fail("does not start with 'penumbra-brdf-table 1'");
    scanner.integer("the version", 1, 1);
    if (scanner.word() != "symmetry") scanner.fail("expected 'symmetry'");
    const std::string_view symmetry = scanner.word();
    BrdfTable table;
    if (symmetry == "isotropic") {
        table.axes[0] = thetaAxis(readSteps(scanner, "theta_i", 2));
        table.axes[2] = thetaAxis(readSteps(scanner, "theta_o", 2));
        table.axes[3] = openAxis(readSteps(scanner, "phi", 2), kPi);
        return table;
    }
    if (symmetry != "orthotropic" && symmetry != "general")
        scanner.fail("symmetry is '" + std::string(symmetry.substr(0, 40)) +
                     "', not isotropic, orthotropic or general");
    table.symmetry = symmetry == "general" ? BrdfSymmetry::kGeneral : BrdfSymmetry::kOrthotropic;
    table.axes[0] = thetaAxis(readSteps(scanner, "theta_i", 2));
    const int phi_i = readSteps(scanner, "phi_i", 2);
    table.axes[1] = symmetry == "general" ? circle(phi_i) : openAxis(phi_i, kPi / 2);
    table.axes[2] = thetaAxis(readSteps(scanner, "theta_o", 2));
    table.axes[3] = circle(readSteps(scanner, "phi_o", 2));
    return table;
}

}  // namespace

BrdfReading decodeBrdfTable(std::string_view text, const std::string& name) {
    NumberScanner scanner(text, name);
    BrdfTable table = readHeader(scanner);
    std::size_t cells = 1;
    for (const Axis& axis : table.axes) cells *= std::size_t(axis.count);
    if (cells > kMaxCells) scanner.fail("more than 16777216 cells");
    if (cells * 6 > text.size()) scanner.fail("is too short for its " + std::to_string(cells) + " cells");  // "0 0 0\n"
    table.values.resize(cells);
    for (std::size_t cell = 0; cell < cells; ++cell)
        for (int c = 0; c < 3; ++c) {
            const auto where = [&] { return std::string("channel ") + "RGB"[c] + " of cell " + std::to_string(cell); };
            const double value = scanner.number("a value");
            if (value < 0) scanner.fail(where() + " is negative");
            if (value > kMaxTableRadiance) scanner.fail(where() + " is above 1e6");
            table.values[cell][c] = float(value);
        }
    if (!scanner.atEnd()) scanner.fail("has more values than its " + std::to_string(cells) + " cells");
    const BrdfSymmetry symmetry = table.symmetry;
    const auto shared = std::make_shared<const BrdfTable>(std::move(table));
    return {{name, symmetry, [shared](Vec3d wi, Vec3d wo) { return evalTable(*shared, wi, wo); }},
            {{"samples", double(cells)}}};
}

}  // namespace penumbra
