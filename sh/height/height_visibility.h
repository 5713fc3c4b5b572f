#pragma once
// The visibility of a whole height field, and of points above it, for every frame of an animation.
//
// Horizons are looked for at receivers, every `step` points both ways (Nowrouzezahrai 2009, figure 11: visibility is
// sub-sampled, shading is not). Between them visibility is bilinear, with less weight for receivers whose normal is
// another one. Every point turns it into its own frame, so that its own slope is never smoothed away.
#include <span>
#include <vector>

#include "sh/height/height_kernel.h"
#include "sh/height/height_receivers.h"
#include "sh/height/height_refinement.h"
#include "sh/height/horizon.h"
#include "sh/visibility_convention.h"

namespace penumbra {

// Tables of a grid and an order, and what they compute. Everything that is const allocates nothing and may run on any
// number of threads at once.
enum class HeightReceiver { kOnField, kAbove };

class HeightTables {
public:
    // `order` is 4 or 5. Numbers that come out are those of mirrored functions of order `mirrored`.
    HeightTables(const HeightField& field, int order, int mirrored, const HeightPath& path = fastestHeightPath());

    int order() const { return order_; }
    std::size_t size() const { return size_; }  // numbers that come out
    const HeightPath& path() const { return *path_; }
    // V at points, in the frame of the field: out[p * stride + i], i < order^2.
    void visibility(const HeightField& field, const HeightPoints& points, std::size_t stride,
                    std::span<float> out) const;
    // Turns V into the frame of each point (normals and tangents in the frame of the field) and mirrors it at its
    // horizon: out[p * stride + i], i < size(). A point kOnField lies on the field, which hides all below its tangent
    // plane. That half counts as 1 before it is cut off, so that a level field leaves exactly 1.
    void mirror(std::span<const float> rows, std::size_t row_stride, const HeightFrames& frames,
                HeightReceiver receiver, std::size_t stride, std::span<float> out) const;
    const HorizonTaps& taps() const { return taps_; }
    // The same tables as the inner loops read them; they point into this object and the field.
    HeightScene sceneOf(const HeightField& field) const;
    HeightMirror mirrorOf(HeightReceiver receiver) const;

private:
    int order_;
    std::size_t size_;
    const HeightPath* path_;
    HorizonTaps taps_;
    std::vector<HeightTap> tap_list_;
    std::vector<float> turns_, norms_, below_, ambient_;
    std::vector<HeightTurn> quarter_, mirror_;
    std::vector<HeightPair> pairs_;
    float ambient_norm2_ = 0;

    void makeTaps(const HeightField& field);
    void makeMirror(int mirrored);
};

// Weight that a receiver keeps whose normal differs by d (length): 1 / (1 + kNormalsMatter d^2).
constexpr float kNormalsMatter = 8;

class HeightVisibility {
public:
    // Numbers are those of convention D of `order` (4 or 5). `step` is 1, 2, 4 or 8. At first all receivers are awake.
    HeightVisibility(const HeightField& field, int order, int step, const HeightPath& path = fastestHeightPath());

    const HeightTables& tables() const { return tables_; }
    int step() const { return receivers_.step(); }
    Convention convention() const { return {BelowHorizon::kMirrored, tables_.order()}; }
    std::size_t receiverRows() const { return receivers_.rows(); }
    std::size_t receiverCount() const { return receivers_.count(); }

    // Wakes the receivers that look at what HeightField::set() changed. Allocates nothing.
    void wake(const HeightField& field, std::span<const TexelBox> changed) {
        receivers_.wake(field, tables_.taps(), changed);
    }
    void wakeAll() { receivers_.wakeAll(); }
    std::size_t awake() const { return receivers_.awake(); }
    const HeightReceivers& receivers() const { return receivers_; }
    // Call this after coefficients() of all stale points.
    void freshen() { receivers_.freshen(); }

    // The rms error of V between receivers, as it is estimated, above which there are more of them. 0: nowhere.
    float tolerance() const { return tolerance_; }
    void setTolerance(float tolerance) {
        tolerance_ = step() > 1 ? tolerance : 0;
        wakeAll();
    }
    // Point (row, column) is in cell (row / step, column / step). Its numbers are those of before unless it is stale.
    // They may still be those of before where receivers().isStale() does not hold and finerKey() is what it was.
    bool isStale(const HeightField& field, std::size_t row, std::size_t column) const;
    // Lets more points of a tile look for their horizons: rows [first_row, first_row + step) and columns [first_column,
    // end_column), at most HeightRefined::kColumns. It begins at a cell. Allocates nothing.
    void refine(const HeightField& field, int first_row, int first_column, int end_column, HeightRefined& out) const;
    // Looks for the horizons of awake receivers in rows [first, end) of receivers, which then sleep. Different rows may
    // run at once. Allocates nothing.
    void evaluate(const HeightField& field, std::size_t first, std::size_t end);
    // A hash of what finer receivers of the cell see that begins at this point of a refined tile; 0 without any.
    std::uint64_t finerKey(const HeightRefined& refined, int row, int column) const;
    // Writes normals and tangents (in the frame of the field) and numbers of points [first_column,
    // first_column + normals.size()) of a row of the field: coefficients[p * stride + i]. At most kMaxPoints at once.
    // `refined` is of a tile that has them, or null: then only receivers count. Allocates nothing.
    static constexpr std::size_t kMaxPoints = 128;
    void coefficients(const HeightField& field, int row, int first_column, std::span<Vec3> normals,
                      std::span<Vec3> tangents, std::size_t stride, std::span<float> coefficients,
                      const HeightRefined* refined = nullptr) const;
    // V of a receiver, in the frame of the field.
    std::span<const float> receiver(std::size_t row, std::size_t column) const {
        return std::span(rows_).subspan((row * receivers_.columns() + column) * row_size_,
                                        std::size_t(coefficientCount(tables_.order())));
    }

private:
    struct Cell;
    struct Looker;
    // V and the normal of a receiver, also of a finer one.
    struct Seen {
        const float* row;
        Vec3 normal;
    };

    HeightTables tables_;
    HeightReceivers receivers_;
    float tolerance_ = 0;
    std::size_t row_size_;       // numbers of a receiver, padded
    std::vector<float> rows_;    // [receivers, row_size_]
    std::vector<Vec3> normals_;  // [receivers]

    Cell cellAt(const HeightGrid& grid, int row, int column, int step) const;
    Seen seenAt(const HeightGrid& grid, const HeightRefined* refined, int row, int column) const;
    float shareOf(const HeightField& field, const HeightRefined* refined, const Cell& cell, int step) const;
    void lookHalfWay(const HeightField& field, int size, HeightRefined& out) const;
    void shareHalves(const HeightField& field, int size, HeightRefined& out) const;
    void mixFiner(const HeightGrid& grid, const HeightRefined& refined, int row, int first_column,
                  std::span<const Vec3> normals, std::span<float> rows) const;
};

}  // namespace penumbra
