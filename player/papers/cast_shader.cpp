#include "player/papers/cast_shader.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <numbers>

#include "formats/common/parallel_for.h"
#include "sh/cast/cast_fold.h"
#include "sh/quadrature.h"
#include "sh/sh_product.h"
#include "sh/sh_rotation.h"

namespace penumbra {

namespace {

constexpr Convention kSphereProductConvention{BelowHorizon::kOpen, 4};
constexpr std::size_t kSphereProductSize = 16;

// Row r of V_c turned into the local frame of its vertex.
void localCast(int order, SphereCast cast, const FrameVertices& own, std::size_t r, std::span<float> out) {
    apply(makeShRotation(order, toLocalFrame(own.normals[r], own.tangents[r])),
          cast.subspan(r * out.size(), out.size()), out);
}

// Moments over the upper hemisphere of the functions that the numbers of a convention stand for: [16, numbers].
std::vector<double> momentsOf(const Convention& convention) {
    const std::vector<int> indices = convention.indices();
    std::vector<double> matrix(kSphereProductSize * indices.size()), y(coefficientCount(kMaxOrder));
    for (const WeightedDirection& d : gaussHemisphere(8, 16)) {
        evalBasis(kMaxOrder, d.direction, y);
        for (std::size_t i = 0; i < kSphereProductSize; ++i)
            for (std::size_t k = 0; k < indices.size(); ++k)
                matrix[i * indices.size() + k] += d.weight * y[i] * y[std::size_t(indices[k])];
    }
    return matrix;
}

std::vector<float> sphereProductCoefficients(const ModelView& model, const FrameVertices& own, SphereCast cast) {
    std::vector<float> coefficients = ownInA4(model.convention, model.stride, own.coefficients);
    std::array<float, kSphereProductSize> others;
    std::array<double, kSphereProductSize> a, b, product;
    for (std::size_t v = 0; v < own.positions.size(); ++v) {
        localCast(4, cast, own, v, others);
        const auto row = coefficients.begin() + std::ptrdiff_t(v * kSphereProductSize);
        std::copy_n(row, kSphereProductSize, a.begin());
        std::copy(others.begin(), others.end(), b.begin());
        multiply(4, a, 4, b, 4, product);
        std::copy(product.begin(), product.end(), row);
    }
    return coefficients;
}

std::vector<float> ownCoefficients(CastMode mode, const Convention& convention, int stride, const FrameVertices& own) {
    std::vector<float> coefficients = own.coefficients;
    if (mode == CastMode::kHemisphereShare) keepHemisphereShare(convention, stride, coefficients);
    return coefficients;
}

double sumOf(std::span<const float> coefficients, std::span<const double> y) {
    double sum = 0;
    for (std::size_t i = 0; i < coefficients.size(); ++i) sum += double(coefficients[i]) * y[i];
    return sum;
}

}  // namespace

std::vector<float> ownInA4(const Convention& convention, int stride, std::span<const float> coefficients) {
    const std::size_t count = coefficients.size() / std::size_t(stride), size = std::size_t(convention.size());
    std::vector<double> below(kSphereProductSize);
    belowHorizonCoefficients(4, below);
    const bool mirrored = convention.below == BelowHorizon::kMirrored;
    const std::vector<double> moments = mirrored ? momentsOf(convention) : std::vector<double>();
    std::vector<float> out(count * kSphereProductSize);
    for (std::size_t v = 0; v < count; ++v)
        for (std::size_t i = 0; i < kSphereProductSize; ++i) {
            const std::span<const float> row = coefficients.subspan(v * std::size_t(stride), size);
            double number = convention.below == BelowHorizon::kOpen ? 0 : below[i];
            if (mirrored)
                for (std::size_t k = 0; k < size; ++k) number += moments[i * size + k] * double(row[k]);
            else if (i < size)
                number += double(row[i]);
            out[v * kSphereProductSize + i] = float(number);
        }
    return out;
}

void keepHemisphereShare(const Convention& convention, int stride, std::span<float> coefficients) {
    const std::vector<float> open = freeSight(convention);
    std::vector<float> below(open.size(), 0.0f);
    if (convention.below == BelowHorizon::kOpen) {
        std::vector<double> all(below.size());
        belowHorizonCoefficients(convention.order, all);
        std::copy(all.begin(), all.end(), below.begin());
    }
    for (std::size_t first = 0; first < coefficients.size(); first += std::size_t(stride)) {
        const std::span<float> row = coefficients.subspan(first, open.size());
        const float share = (row[0] - below[0]) / (open[0] - below[0]);
        for (std::size_t i = 0; i < row.size(); ++i) row[i] = below[i] + share * (open[i] - below[i]);
    }
}

std::vector<float> castAmbient(CastMode mode, const ModelView& model, const FrameVertices& own, SphereCast cast) {
    const std::size_t count = own.positions.size();
    std::vector<float> e(count);
    if (mode == CastMode::kSphereProduct) {
        ambient(kSphereProductConvention, int(kSphereProductSize), sphereProductCoefficients(model, own, cast), e);
        return e;
    }
    const int order = castOrderOf(mode);
    const Convention& convention = model.convention;
    const std::vector<float> coefficients = ownCoefficients(mode, convention, model.stride, own);
    const std::vector<WeightedDirection> directions = gaussHemisphere(8, 16);  // exact: the degree is 12 at most
    std::vector<std::vector<double>> y(directions.size(), std::vector<double>(coefficientCount(kMaxOrder)));
    for (std::size_t d = 0; d < y.size(); ++d) evalBasis(kMaxOrder, directions[d].direction, y[d]);
    std::vector<float> mine(std::size_t(coefficientCount(convention.order))),
        others(std::size_t(coefficientCount(order)));
    for (std::size_t v = 0; v < count; ++v) {
        fullCoefficients(convention,
                         std::span(coefficients).subspan(v * std::size_t(model.stride), std::size_t(convention.size())),
                         mine);
        localCast(order, cast, own, v, others);
        double sum = 0;
        for (std::size_t d = 0; d < directions.size(); ++d)
            sum += directions[d].weight * directions[d].direction.z * sumOf(mine, y[d]) * sumOf(others, y[d]);
        e[v] = float(sum / std::numbers::pi);
    }
    return e;
}

std::vector<float> turnedLight(const LightView& light, const Mat3d& rotation) {
    const ShRotationD turn = makeShRotation(light.order, rotation);
    const std::size_t n = std::size_t(coefficientCount(light.order));
    std::vector<double> in(n), out(n);
    std::vector<float> turned(3 * n);
    for (std::size_t c = 0; c < 3; ++c) {
        for (std::size_t i = 0; i < n; ++i) in[i] = light.sh[3 * i + c];
        apply(turn, in, out);
        for (std::size_t i = 0; i < n; ++i) turned[3 * i + c] = float(out[i]);
    }
    return turned;
}

CastShader::CastShader(CastMode mode, const Shot& shot)
    : mode_(mode),
      convention_(shot.asset->model.convention),
      stride_(shot.asset->model.stride),
      view_(*shot.asset),
      light_(turnedLight(shot.asset->lights[shot.light], toDouble(shot.light_rotation))),
      light_order_(shot.asset->lights[shot.light].order) {
    assert(mode != CastMode::kProduct && shot.shaded);
    view_.lights = {{"light", light_order_, light_}};
    if (mode == CastMode::kSphereProduct) {
        view_.model.convention = kSphereProductConvention;
        view_.model.stride = int(kSphereProductSize);
    }
    Shot look = shot;
    look.asset = &view_;
    look.light = 0;
    look.light_rotation = Mat3();
    look.shading.light_form = LightForm::kRotation;
    set_.emplace(shadingOf(look));
}

void CastShader::shade(const FrameVertices& own, SphereCast cast, Vec3 eye, int threads, std::vector<Vec3>& radiance) {
    if (mode_ != CastMode::kSphereProduct) return shadeFolded(own, cast, eye, threads, radiance);
    ModelView model;
    model.convention = convention_;
    model.stride = stride_;
    FrameVertices joined = own;
    joined.coefficients = sphereProductCoefficients(model, own, cast);
    shadeFrame(*set_, joined, eye, threads, radiance);
}

// Radiance is linear in the light, and every vertex has a light of its own. So all vertices are shaded under each SH
// function, in white, and the results are weighted by the light of the vertex.
void CastShader::shadeFolded(const FrameVertices& own, SphereCast cast, Vec3 eye, int threads,
                             std::vector<Vec3>& radiance) {
    const std::size_t count = own.positions.size(), n = std::size_t(coefficientCount(light_order_));
    const int order = castOrderOf(mode_);
    const std::size_t row = std::size_t(coefficientCount(order));
    const CastFold fold = makeCastFold(light_order_, light_, order);
    std::vector<float> lights(count * 3 * n), coefficients = ownCoefficients(mode_, convention_, stride_, own);
    for (std::size_t v = 0; v < count; ++v)
        foldCast(fold, cast.subspan(v * row, row), std::span(lights).subspan(v * 3 * n, 3 * n));
    radiance.assign(count, Vec3{});
    std::vector<Vec3> by_one(count);
    constexpr std::size_t kShadePiece = 512;
    for (std::size_t i = 0; i < n; ++i) {
        std::vector<float> one(3 * n);
        std::fill_n(one.begin() + std::ptrdiff_t(3 * i), 3, 1.0f);
        set_->setLight(0, one);
        parallelFor((count + kShadePiece - 1) / kShadePiece, threads, [&](std::size_t piece) {
            const std::size_t begin = piece * kShadePiece, end = std::min(count, begin + kShadePiece);
            set_->shade({own.positions, own.normals, own.tangents, coefficients, begin, end}, eye, by_one);
        });
        for (std::size_t v = 0; v < count; ++v)
            for (int c = 0; c < 3; ++c) radiance[v][c] += lights[v * 3 * n + 3 * i + std::size_t(c)] * by_one[v][c];
    }
    for (Vec3& r : radiance)
        for (int c = 0; c < 3; ++c) r[c] = std::max(r[c], 0.0f);
}

std::vector<Vec3> groundWeights(CastMode mode, std::span<const float> light, int light_order) {
    const int order = castOrderOf(mode);
    std::vector<Vec3d> weights(std::size_t(coefficientCount(order)));
    std::vector<double> y(coefficientCount(kMaxOrder)), cosine(std::size_t(coefficientCount(light_order)));
    for (const WeightedDirection& d : gaussHemisphere(16, 32)) {
        evalBasis(kMaxOrder, Vec3d{d.direction.y, d.direction.z, d.direction.x}, y);  // the ground faces +y
        const double weight = d.weight * d.direction.z / std::numbers::pi;
        for (std::size_t i = 0; i < cosine.size(); ++i) cosine[i] += weight * y[i];
        Vec3d radiance{light.empty() ? 1.0 : 0.0, 0, 0};
        for (std::size_t i = 0; i < light.size(); ++i) radiance[int(i % 3)] += double(light[i]) * y[i / 3];
        for (std::size_t k = 0; k < weights.size(); ++k) weights[k] += radiance * (weight * y[k]);
    }
    if (mode != CastMode::kSphereProduct && !light.empty()) {
        const CastFold fold = makeCastFold(light_order, light, order);
        for (std::size_t k = 0; k < weights.size(); ++k) {
            weights[k] = {};
            for (std::size_t i = 0; i < light.size(); ++i)
                weights[k][int(i % 3)] += cosine[i / 3] * double(fold.matrix[k * light.size() + i]);
        }
    }
    std::vector<Vec3> out;
    for (const Vec3d& w : weights) out.push_back(toFloat(w));
    return out;
}

std::vector<Vec3> groundInMode(CastMode mode, SphereCast cast, const LightView* light, const Mat3d& light_rotation,
                               Vec3 albedo) {
    std::vector<float> turned;
    if (light) turned = turnedLight(*light, light_rotation);
    const std::vector<Vec3> weights = groundWeights(mode, turned, light ? light->order : 1);
    const Vec3 reflected = light ? albedo : Vec3{1, 1, 1};
    std::vector<Vec3> values(cast.size() / weights.size());
    for (std::size_t v = 0; v < values.size(); ++v) {
        for (std::size_t k = 0; k < weights.size(); ++k) values[v] += weights[k] * cast[v * weights.size() + k];
        for (int c = 0; c < 3; ++c) values[v][c] = std::max(values[v][c], 0.0f) * reflected[c];
    }
    return values;
}

}  // namespace penumbra
