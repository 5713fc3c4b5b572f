#pragma once
// Computes the visibility past spheres, and its logarithm.
//
// Problem: a character as a caster of shadows is 10 to 20 spheres. A receiver needs the SH of the visibility past all
// of them.
//
// Naive: multiply the visibilities past the single spheres (productChain(), sh/cast/log_visibility.h). Each factor is
// an SH product, which takes longer than all else, and the result depends on the order of the factors.
//
// Here: sums of logarithms. The sphere hides a cap, whose logarithm is a zonal function that only the cap's size
// determines. It comes from a table. A receiver turns the logarithms to the axes of its caps and adds them; one
// exponential (sh/cast/log_visibility.h) gives the visibility. The logarithm of a cap's band-limited visibility g is
// that of the matrix M of products with g, with eigenvalues below 0.02 of the largest raised to that (docs/formulas.md,
// section 10).
#include <array>
#include <cstddef>
#include <span>

#include "sh/cast/caster_sphere.h"
#include "sh/sh_basis.h"

namespace penumbra {

constexpr int kMinLogOrder = 3, kMaxLogOrder = 6;  // orders of the logarithms
constexpr std::size_t kCapLogEntries = 512;
constexpr double kMaxCapAngle = 2.8797932657906435;  // 165 degrees: logarithms of larger caps tend to -infinity

// The directions within `angle` of the unit `axis`.
struct Cap {
    Vec3d axis;
    double angle = 0;
};

// Returns the sine of the half-angle of the cap that a sphere hides from a point at `distance` from its center; 0 where
// it hides nothing. From outside this is radius / distance. The spheres of a character reach out of its skin, so a
// receiver may be inside of one: the cap then shrinks, and from 15% of the radius inwards nothing is left of it.
float sineOfCap(float distance, float radius);
double sineOfCap(double distance, double radius);

// Returns the cap that a sphere hides from `position`; its angle is 0 where sineOfCap() is, or the center is less than
// 1e-6 away.
Cap capOf(const CasterSphereD& sphere, Vec3d position);

// Writes the zonal harmonics of the logarithm of the visibility past a cap around +z. z.size() is the order, 3 to 6.
// Slow; `angle` in [0, kMaxCapAngle].
void capLogZonal(double angle, std::span<double> z);

// The logarithms of caps of all sizes, for linear interpolation. Entry e stands for u = sin(angle / 2) = e / 511
// sin(kMaxCapAngle / 2); the logarithm begins with u^2. A row holds sqrt(4pi / (2l+1)) z_l, so that the coefficients
// of a cap around an axis are row[l] y_lm(axis).
template <class T>
struct BasicCapLogTable {
    int order = 0;
    std::array<std::array<T, 8>, kCapLogEntries> rows{};
};
using CapLogTable = BasicCapLogTable<float>;
using CapLogTableD = BasicCapLogTable<double>;

// Makes the table of an order from kMinLogOrder to kMaxLogOrder, in some 20 ms, when it is first asked for.
const CapLogTable& capLogTable(int order);
const CapLogTableD& capLogTableD(int order);

// Writes the sum of the logarithms of all spheres at `position`, in the frame of both; out.size() ==
// coefficientCount(table.order). Allocates nothing.
void netLog(const CapLogTable& table, std::span<const CasterSphere> spheres, Vec3 position, std::span<float> out);
void netLog(const CapLogTableD& table, std::span<const CasterSphereD> spheres, Vec3d position, std::span<double> out);
// Does the same for caps that are given. Angles above kMaxCapAngle count as that.
void netLog(const CapLogTableD& table, std::span<const Cap> caps, std::span<double> out);

}  // namespace penumbra
