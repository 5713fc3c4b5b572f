#include "sh/far/far_tables.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <map>
#include <memory>
#include <mutex>
#include <numbers>

#include "sh/mutex.h"
#include "sh/reflectance.h"
#include "sh/sh_product.h"

namespace penumbra {

static_assert(kFieldOrder == 6 && kFarCoefficients == 21 && FieldTable::kStride == 40 && kFieldSpheres == kMaxSpheres &&
                  kFieldSphereSide == 13,
              "far_lanes.cpp has these numbers too");
static_assert(mirroredCount(kMaxOrder) == 36 && rotationEntryCount(kFieldOrder) == 286);

namespace {

// See FarConstants. Chosen on training frames of mh_male: thresholds of half this size leave .003 less error and take a
// quarter more time, and depths of 0 and 0.5 leave more error than 0.25.
constexpr float kNear[kFarQualities][2] = {{0.02f, 0.04f}, {0.1f, 0.2f}, {0.02f, 0.04f}};
// What one character hides from another is many parts that each block little. Together they count: a person at 4 m
// hides .002 of the light.
constexpr float kBlocked[kFarQualities][2] = {
    {kMinBlocked, kFullBlocked}, {kMinBlocked, kFullBlocked}, {kMinBlocked / 5, kFullBlocked / 5}};
constexpr float kDepth = 0.25f;
// The silhouettes of a body's parts overlap, and six bands see through what is thin: together, parts that are far or
// small block more than the body does. A character's own far parts leave that to its local model and its residual,
// which are fitted with them. Chosen on training frames of three rigs (docs/scene.md); 0.75 to 0.85 and 0.03 to 0.1 are
// alike.
constexpr float kOverlap[kFarQualities] = {1, 1, 0.8f}, kSolid = 0.05f;
// Vertices of a character hardly sink into its own parts, but others walk through them: a point that went dark within
// the few millimetres of FieldTable::fade would pop.
constexpr float kDark[kFarQualities] = {1, 1, 0.25f};

// A crowd may have thousands of factors, each of which rings above 1 somewhere.
constexpr float kMax[kFarQualities] = {0, 0, 1.25f};

FarBox boxOf(const FieldBox& box, std::size_t first, float width) {
    FarBox out{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
        out.low[axis] = box.low[int(axis)];
        out.high[axis] = box.high[int(axis)];
        out.cells[axis] = float(box.size[axis] - 1);
        out.per_cell[axis] = out.cells[axis] / (out.high[axis] - out.low[axis]);
    }
    out.stride[0] = 1;
    out.stride[1] = box.size[0];
    out.stride[2] = box.size[0] * box.size[1];
    out.first = std::int32_t(first);
    out.per_width = 1 / width;
    return out;
}

FarTable tableOf(const FieldTable& field) {
    FarTable out{};
    const std::size_t fine = field.boxes[0].pointCount(), boxes = fine + field.boxes[1].pointCount();
    out.boxes[0] = boxOf(field.boxes[0], 0, kFieldBlendWidth[0] * field.radius);
    out.boxes[1] = boxOf(field.boxes[1], fine, kFieldBlendWidth[1] * field.radius);
    out.first_sphere = std::int32_t(boxes);
    for (std::size_t axis = 0; axis < 3; ++axis) out.center[axis] = field.center[int(axis)];
    out.radius = field.radius;
    out.per_fade = 1 / field.fade;
    for (std::size_t level = 0; level < kFieldLevels; ++level)
        std::copy(field.scale[level].begin(), field.scale[level].end(), out.scale[level]);
    out.points = field.points.data();
    return out;
}

// The 4 positive nodes of the Gauss-Legendre rule with 8 nodes, which is exact up to degree 15, and their weights.
constexpr double kHeights[4] = {0.18343464249564980, 0.52553240991632899, 0.79666647741362674, 0.96028985649753623};
constexpr double kHeightWeights[4] = {0.36268378337836198, 0.31370664587788729, 0.22238103445337447,
                                      0.10122853629037626};

// y_i is a function of height times cos(m phi) or sin(m phi). It is read where that is 1.
FarGrid makeGrid() {
    FarGrid grid{};
    std::vector<double> y(kFieldCoefficients);
    for (std::size_t k = 0; k < 4; ++k) {
        const double z = kHeights[k], flat = std::sqrt(1 - z * z);
        std::size_t i = 0;
        for (int l = 0; l < kFieldOrder; ++l)
            for (int m = -l; m <= l; m += 2, ++i) {
                const double phi = m < 0 ? std::numbers::pi / (-2.0 * m) : 0;
                evalBasis(kFieldOrder, Vec3d{flat * std::cos(phi), flat * std::sin(phi), z}, std::span<double>(y));
                const double value = y[std::size_t(shIndex(l, m))];
                grid.ring[k][i] = float(value);
                // Twice for the mirror image below the horizon, and an eighth of pi for each of 16 directions.
                grid.ring_back[k][i] = float(2 * kHeightWeights[k] * std::numbers::pi / 8 * value);
            }
    }
    return grid;
}

MirrorTable makeMirrorTable() {
    MirrorTable table{};
    for (int l = 0; l < kFieldOrder; ++l)
        for (int m = 1 - l; m < l; m += 2) {  // odd l + m
            std::array<float, kFieldCoefficients> odd{};
            std::array<float, kFarCoefficients> even;
            odd[std::size_t(shIndex(l, m))] = 1;
            mirrorAtHorizon(kFieldOrder, odd, even);
            for (int to = std::abs(m); to < kFieldOrder; to += 2) {
                const int place = to * (to + 1) / 2 + (m + to) / 2;
                table[std::size_t(place)][l] = even[std::size_t(place)];
            }
        }
    return table;
}

}  // namespace

const MirrorTable& mirrorTable() {
    static const MirrorTable table = makeMirrorTable();
    return table;
}

void FarTables::Matrix::endRow() { first.push_back(std::uint16_t(terms.size())); }

FarTables::Product FarTables::makeProduct(int order_out, int order_a, int order_b) {
    const auto places = [](int order) {
        std::map<int, std::uint16_t> place;
        for (int i : evenIndices(order)) place.emplace(i, std::uint16_t(place.size()));
        return place;
    };
    const std::map<int, std::uint16_t> out = places(order_out), a = places(order_a), b = places(order_b);
    std::map<std::pair<int, int>, std::uint16_t> pairs;
    std::vector<std::map<std::uint16_t, float>> rows(out.size());
    Product product;
    for (const TripleProductEntry& e : tripleProduct(order_out, order_a, order_b)) {
        if (!out.contains(e.i) || !a.contains(e.j) || !b.contains(e.k)) continue;
        const std::pair<int, int> pair = std::minmax(int(a.at(e.j)), int(b.at(e.k)));
        const auto [place, fresh] = pairs.emplace(pair, std::uint16_t(pairs.size()));
        if (fresh) {
            product.j.push_back(std::uint8_t(pair.first));
            product.k.push_back(std::uint8_t(pair.second));
        }
        rows[out.at(e.i)][place->second] = float(e.value);  // the same for (j, k) and (k, j)
    }
    for (const std::map<std::uint16_t, float>& row : rows) {
        for (const auto& [from, value] : row) product.rows.terms.push_back({from, value});
        product.rows.endRow();
    }
    assert(pairs.size() <= kMaxPairs);
    return product;
}

FarTables::FarTables(FarFields fields, std::vector<std::vector<std::uint16_t>> far_parts, int order,
                     NearParts near_parts)
    : fields_(std::move(fields)),
      far_parts_(std::move(far_parts)),
      near_parts_(std::move(near_parts)),
      compose_(makeProduct(order, order, kFieldOrder)) {
    assert(far_parts_.size() == partCount());
    assert(near_parts_.parts.size() == partCount() * near_parts_.count && near_parts_.count <= kMaxNear);
    for (const FieldTable& field : fields_.tables) tables_.push_back(tableOf(field));
    const FarProduct compose{compose_.j.data(), compose_.k.data(), compose_.j.size(), compose_.rows.view(),
                             int(compose_.rows.first.size()) - 1};
    FarConstants constants = {{}, {}, makeGrid(), compose, order, {}, {}, kDepth, 1, 1, 0, 1, {}};
    const ShRotation turn = makeShRotation(kFieldOrder, Mat3{{1, 0, 0, 0, 0, -1, 0, 1, 0}});
    std::copy_n(turn.blocks.begin(), rotationEntryCount(kFieldOrder), constants.quarter_turn);
    for (std::size_t i = 0; i < kFarCoefficients; ++i) std::copy_n(mirrorTable()[i], kFieldOrder, constants.mirror[i]);
    std::copy(kFieldSphereScales.begin(), kFieldSphereScales.end(), constants.sphere_scales);
    constants_.fill(constants);
    for (std::size_t q = 0; q < kFarQualities; ++q) {
        std::copy_n(kNear[q], 2, constants_[q].near);
        std::copy_n(kBlocked[q], 2, constants_[q].blocked);
        constants_[q].overlap = kOverlap[q];
        constants_[q].solid = kSolid;
        constants_[q].dark = kDark[q];
        constants_[q].most = kMax[q];
    }
}

FarScene FarTables::sceneOf(std::size_t part, const FarPart* posed) const {
    const std::vector<std::uint16_t>& far = far_parts_[part];
    return {tables(), posed, far.data(), far.size(), 0, near_parts_.of(part).data(), near_parts_.count};
}

const FarConstants& productConstants(int order) {
    static Mutex mutex;
    static std::array<std::unique_ptr<FarTables>, kMaxOrder + 1> made;
    const std::lock_guard lock(mutex);
    std::unique_ptr<FarTables>& tables = made[std::size_t(order)];
    if (!tables) tables = std::make_unique<FarTables>(FarFields(), std::vector<std::vector<std::uint16_t>>(), order);
    return tables->constants();
}

FarPart farPart(const PosedPart& posed) {
    FarPart out;
    std::copy(posed.to_part.m.begin(), posed.to_part.m.end(), out.to_part);
    std::copy(posed.turn.m.begin(), posed.turn.m.end(), out.turn);
    for (std::size_t axis = 0; axis < 3; ++axis) out.center[axis] = posed.center[int(axis)];
    out.radius = posed.radius;
    out.to_model = posed.to_model.blocks.data();
    return out;
}

void FarPose::set(const FarTables& tables, std::span<const Affine> bones, const Affine& still) {
    poseParts(tables.fields(), bones, posed, still);
    for (std::size_t p = 0; p < posed.size(); ++p) parts[p] = farPart(posed[p]);
}

}  // namespace penumbra
