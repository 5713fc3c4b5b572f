#pragma once
// More receivers of a height field, where those of a cell do not tell what its points see.
//
// Problem: on steep and fine ground visibility between receivers is not what their mean says, and FLIP of a picture
// is 0.09 off. Full resolution takes 7 times as long, also where the ground is smooth.
//
// Here: an estimate of the error decides for each cell. How far V of the four corners is apart says how much light is
// at stake, and how far normals inside are from those of the corners how rough the ground is; the error of V is near
// half their geometric mean, on waves, dunes and fractals alike (tests/bench/results/NOTES.md). Above a tolerance the
// points half-way are receivers too, and their smaller cells are looked at in the same way, down to every point.
//
// From the tolerance to half as much again, what is finer fades in. So it moves continuously with the heights: nothing
// pops in an animation, and processors that round differently show the same.
#include <array>
#include <cstdint>

#include "sh/height/height_field.h"

namespace penumbra {

constexpr float kHeightTolerance = 0.025f;   // rms V, a good default
constexpr float kMaxHeightTolerance = 1.0f;  // visibility itself is no larger

// Half the geometric mean of `apart`, the rms of V of the corners around their mean, and `rough`, the rms of the
// normals half-way from those between the corners. A tenth of each is added to the other: neither corners that agree by
// chance nor normals that do let a cell pass for smooth.
float cellError(float apart, float rough);
// How much of what is finer shows, 0 to 1.
float refinementOf(float error, float tolerance);

// Part of a tile that finer receivers read: rows of one band of cells, and some columns. The tile begins at a cell.
struct HeightRefined {
    static constexpr int kColumns = 64;  // columns of points, at most
    static constexpr int kMaxStep = 8, kStride = kColumns + 1, kPlaces = (kMaxStep + 1) * kStride;

    int first_row = 0, first_column = 0, end_row = 0, end_column = 0;
    bool any = false;  // else nothing below is set
    std::size_t count = 0;
    // At a cell's first point: how much of what is finer shows, for cells of 8, 4 and 2 points.
    std::array<std::array<float, kPlaces>, 3> shares;
    std::array<std::int16_t, kPlaces> slot;  // slot of each point among those below, or -1
    std::array<float, kPlaces * 32> rows;    // [count, 32] V
    std::array<Vec3, kPlaces> normals;       // [count]

    std::size_t place(int row, int column) const {
        return std::size_t((row - first_row) * kStride + column - first_column);
    }
    std::array<float, kPlaces>& sharesOf(int step) { return shares[step == 8 ? 0 : step == 4 ? 1 : 2]; }
    const std::array<float, kPlaces>& sharesOf(int step) const { return shares[step == 8 ? 0 : step == 4 ? 1 : 2]; }
};

}  // namespace penumbra
