#pragma once
// Lays out the fields of a character, and the constants of products and turns, for the kernel of far_kernel.h.
#include <array>
#include <vector>

#include "sh/far/far_kernel.h"
#include "sh/far/far_visibility.h"
#include "sh/far/near_parts.h"

namespace penumbra {

// How many parts are multiplied in one by one, and how many anchors sum the others. The fast one is for characters that
// are small in the picture: it takes half the time, and docs/accuracy.md has its error. kCast is for what a character
// hides from others, where parts count that block less.
enum class FarQuality : std::uint8_t { kFull, kFast, kCast };
constexpr std::size_t kFarQualities = 3;

class FarTables {
public:
    // A vertex of part p sees the parts far_parts[p]. Local visibilities have `order` bands.
    FarTables(FarFields fields, std::vector<std::vector<std::uint16_t>> far_parts, int order,
              NearParts near_parts = {});
    FarTables(const FarTables&) = delete;  // the tables point into one another
    FarTables& operator=(const FarTables&) = delete;

    std::size_t partCount() const { return fields_.tables.size(); }
    const FarFields& fields() const { return fields_; }
    const FarConstants& constants(FarQuality quality = FarQuality::kFull) const {
        return constants_[std::size_t(quality)];
    }
    // Parts that a vertex of `part` sees as far ones.
    std::span<const std::uint16_t> partsSeenBy(std::size_t part) const { return far_parts_[part]; }
    const NearParts& nearParts() const { return near_parts_; }
    // What a vertex of `part` sees, posed as `posed` [P] says.
    FarScene sceneOf(std::size_t part, const FarPart* posed) const;
    const FarTable* tables() const { return tables_.data(); }

private:
    struct Matrix {
        std::vector<std::uint16_t> first{0};
        std::vector<FarTerm> terms;
        void endRow();
        FarMatrix view() const { return {first.data(), terms.data()}; }
    };
    struct Product {
        std::vector<std::uint8_t> j, k;
        Matrix rows;
    };
    FarFields fields_;
    std::vector<std::vector<std::uint16_t>> far_parts_;  // [P]
    NearParts near_parts_;
    std::vector<FarTable> tables_;  // [P]
    Product compose_;
    std::array<FarConstants, kFarQualities> constants_;

    static Product makeProduct(int order_out, int order_a, int order_b);
};

// Constants for FarPath::compose() alone, of numbers of convention D of this order, made when they are first asked for.
const FarConstants& productConstants(int order);

// FarConstants::mirror.
using MirrorTable = std::array<float[kFieldOrder], kFarCoefficients>;
const MirrorTable& mirrorTable();

// The part as the kernel reads it; it points into `posed`.
FarPart farPart(const PosedPart& posed);

// The parts of one pose. Copies are independent once they are set.
struct FarPose {
    std::vector<PosedPart> posed;
    std::vector<FarPart> parts;

    explicit FarPose(const FarTables& tables) : posed(tables.partCount()), parts(tables.partCount()) {}
    FarPose() = default;
    // As poseParts(). Allocates nothing.
    void set(const FarTables& tables, std::span<const Affine> bones, const Affine& still = {});
};

}  // namespace penumbra
