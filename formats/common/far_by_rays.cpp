// Traces rigid parts from receivers.
//
// Problem: tell how far the fields of a character's parts are from what the parts really block, in a program that fits
// or packs. Only the bake has a ray tracer library, and no other program links it.
//
// Here: a check needs few rays, some ten million, so the tree that finds nearest points traces them. Beyond a part's
// bounding sphere only the cone that holds the sphere is traced, as the bake does it. The code shares nothing with the
// bake, so a check is a second opinion, too.
#include "formats/common/far_by_rays.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <numeric>

#include "formats/common/surface_tree.h"
#include "formats/common/twin_triangles.h"
#include "sh/far/part_lookup.h"
#include "sh/reflectance.h"
#include "sh/sh_basis.h"

namespace penumbra {

std::string fieldWarning(const std::string& part, double rms) {
    char text[128];
    std::snprintf(text, sizeof text, "differs from rays by an rms V of %.3f, more than %.2g", rms, kMaxFieldRms);
    return "the field of part '" + part + "' " + text;
}

struct PartRays::Part {
    std::vector<Triangle> triangles;
    Opacity opacity;
    SurfaceTree tree;
    Vec3d center;  // of a sphere around the part
    double radius = 0;

    Part(std::span<const Vec3> positions, std::vector<Triangle> own, Opacity own_opacity)
        : triangles(std::move(own)), opacity(std::move(own_opacity)), tree(triangles, positions) {
        std::vector<Vec3> corners;
        for (const Triangle& t : triangles)
            for (const std::uint32_t corner : t) corners.push_back(positions[corner]);
        const BoundingBox box = boundsOf(corners);
        center = (toDouble(box.low) + toDouble(box.high)) * 0.5;
        for (const Vec3& corner : corners) radius = std::max(radius, length(toDouble(corner) - center));
    }
};

PartRays::PartRays(const Mesh& mesh, const Skin& skin, const PartTable& table)
    : positions_(
          restShape(mesh.morphs, {mesh.rest_positions, std::vector<Vec3>(mesh.vertexCount())}, mesh.morphs.rest_weights)
              .positions) {
    const std::vector<std::uint32_t> twins = twinTriangles(mesh, skin);
    for (std::size_t part = 0; part < table.partCount(); ++part) {
        std::vector<Triangle> triangles;
        std::vector<std::uint32_t> taken;
        for (std::uint32_t t = 0; t < mesh.frontTriangleCount(); ++t) {
            if (table.part_of_triangle[t] != part || (!twins.empty() && twins[t] < t)) continue;
            triangles.push_back(mesh.triangles[t]);
            taken.push_back(t);
        }
        parts_.push_back(std::make_unique<Part>(positions_, std::move(triangles), opacityOf(mesh.opacity, taken)));
    }
    const double golden = std::numbers::pi * (3 - std::sqrt(5.0));
    for (int i = 0; i < kComparedRays; ++i)
        cone_.push_back({float(std::cos(golden * i)), float(std::sin(golden * i)), float((i + 0.5) / kComparedRays)});
}

PartRays::~PartRays() = default;

void PartRays::sample(std::size_t part, Vec3 point, std::span<float> out) const {
    assert(out.size() == kFieldCoefficients);
    const Part& of = *parts_[part];
    const Vec3d way = of.center - toDouble(point);
    const double distance = length(way);
    const double cosine =
        distance > of.radius ? std::sqrt(1 - of.radius * of.radius / (distance * distance)) : -1;  // of the cone
    const Vec3d z = distance > 0 ? way / distance : Vec3d{0, 0, 1};
    const Vec3d x = normalized(cross(std::abs(z.x) < 0.6 ? Vec3d{1, 0, 0} : Vec3d{0, 1, 0}, z)), y = cross(z, x);
    std::array<double, kFieldCoefficients> blocked{};
    std::array<float, kFieldCoefficients> basis;
    for (const Vec3& entry : cone_) {
        const double along = 1 - (1 - cosine) * double(entry.z), across = std::sqrt(std::max(0.0, 1 - along * along));
        const Vec3 d = toFloat(x * (across * double(entry.x)) + y * (across * double(entry.y)) + z * along);
        const double stopped = 1 - of.tree.passing(point, d, of.opacity);
        if (stopped == 0) continue;
        evalBasis(kFieldOrder, d, basis);
        for (std::size_t i = 0; i < blocked.size(); ++i) blocked[i] -= stopped * double(basis[i]);
    }
    const double each = 2 * std::numbers::pi * (1 - cosine) / kComparedRays;  // solid angle of a ray
    for (std::size_t i = 0; i < blocked.size(); ++i) out[i] = float(each * blocked[i]);
}

FarComparison compareFar(const ComparedParts& compared, std::span<const std::uint16_t> parts,
                         const Receiver& receiver) {
    const PartLookup by_field = [&](std::size_t part, Vec3 point, std::span<float> out) {
        return sampleField(compared.fields.tables[part], point, out);
    };
    const PartLookup by_rays = [&](std::size_t part, Vec3 point, std::span<float> out) {
        if (part >= compared.rays.partCount()) return by_field(part, point, out);
        compared.rays.sample(part, point, out);
        return 0.0f;
    };
    FarComparison out;
    out.squares.resize(compared.posed.size());
    out.by_fields[0] = out.by_rays[0] = float(2 / std::numbers::inv_sqrtpi);
    std::array<float, kFarCoefficients> field, rays, product;
    const auto multiply = [&](std::array<float, kFarCoefficients>& all,
                              const std::array<float, kFarCoefficients>& one) {
        multiplyMirrored(kFieldOrder, all, kFieldOrder, one, kFieldOrder, product);
        all = product;
    };
    for (const std::uint16_t p : parts) {
        farVisibility(by_field, compared.posed, {&p, 1}, receiver, field);
        farVisibility(by_rays, compared.posed, {&p, 1}, receiver, rays);
        for (std::size_t i = 0; i < kFarCoefficients; ++i)
            out.squares[p] += (double(field[i]) - rays[i]) * (double(field[i]) - rays[i]) / (4 * std::numbers::pi);
        multiply(out.by_fields, field);
        multiply(out.by_rays, rays);
    }
    return out;
}

double composedError(const Convention& convention, std::span<const float> local, std::span<const float> far,
                     std::span<const float> truth) {
    std::array<float, coefficientCount(kMaxOrder)> product_buffer, weight_buffer;
    const std::span<float> product = std::span(product_buffer).first(local.size()),
                           weights = std::span(weight_buffer).first(local.size());
    multiplyMirrored(convention.order, local, convention.order, far, kFieldOrder, product);
    ambientWeights(convention, weights);
    clampAmbient(weights, std::inner_product(weights.begin(), weights.end(), weights.begin(), 0.0f), product);
    double sum = 0;
    for (std::size_t i = 0; i < truth.size(); ++i) {
        const double d = double(product[i]) - truth[i];
        sum += d * d;
    }
    return sum;
}

}  // namespace penumbra
