#include "sh/turn_about_normal.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>

#include "sh/indirect_coefficients.h"

namespace penumbra {

namespace {

TurnTable turnsOfIndices(const std::vector<int>& indices) {
    TurnTable table;
    for (std::size_t i = 0; i < indices.size(); ++i) {
        const int band = int(std::sqrt(double(indices[i]))), m = indices[i] - band * (band + 1);
        const auto partner = std::find(indices.begin(), indices.end(), band * (band + 1) - m);
        table.order.push_back(partner == indices.end() ? 0 : m);
        table.partner.push_back(partner == indices.end() ? i : std::size_t(partner - indices.begin()));
    }
    return table;
}

}  // namespace

TurnTable turnsOf(const Convention& convention) { return turnsOfIndices(convention.indices()); }

TurnTable turnsOfIndirect() {
    std::vector<int> indices;
    for (std::size_t i = 0; i < kIndirectCoefficients; ++i) indices.push_back(int(i));
    indices.resize(kIndirectSize, 0);  // means over directions of the other colours
    return turnsOfIndices(indices);
}

FrameTurn makeTurn(const TurnTable& turns, double angle) {
    FrameTurn turn{turns, {}, {}};
    for (const int m : turns.order) {
        turn.cosine.push_back(float(std::cos(m * angle)));
        turn.sine.push_back(float(std::sin(m * angle)));
    }
    return turn;
}

void apply(const FrameTurn& turn, std::span<const float> in, std::span<float> out) {
    // With y_lm ~ cos(m phi) and y_l-m ~ sin(m phi), f(phi - a) has c'_m = c_m cos(m a) - c_-m sin(m a) and
    // c'_-m = c_-m cos(m a) + c_m sin(m a).
    for (std::size_t i = 0; i < turn.turns.size(); ++i)
        out[i] = in[i] * turn.cosine[i] - in[turn.turns.partner[i]] * turn.sine[i];
}

void addTurned(const TurnTable& turns, float cosine, float sine, float weight, std::span<const float> in,
               std::span<float> out) {
    std::array<float, std::size_t(kMaxOrder)> c{1}, s{0};  // of m times the angle, by the sums of angles
    for (std::size_t m = 1; m < c.size(); ++m) {
        c[m] = c[m - 1] * cosine - s[m - 1] * sine;
        s[m] = s[m - 1] * cosine + c[m - 1] * sine;
    }
    for (std::size_t i = 0; i < turns.size(); ++i) {
        const int m = turns.order[i];
        const auto of = std::size_t(std::abs(m));
        out[i] += weight * (in[i] * c[of] - in[turns.partner[i]] * (m < 0 ? -s[of] : s[of]));
    }
}

double angleBetween(Vec3 normal, Vec3 a, Vec3 b) {
    return std::atan2(double(dot(a, cross(normal, b))), double(dot(a, b)));
}

Vec3 carriedTangent(Vec3 a, Vec3 b, Vec3 tangent) {
    constexpr float kOpposite = -0.999f;  // below this cosine the smallest rotation is not well defined
    const float cosine = dot(a, b);
    if (cosine < kOpposite) return tangent;
    return tangent - (a + b) * (dot(b, tangent) / (1 + cosine));
}

}  // namespace penumbra
