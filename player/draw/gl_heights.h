#pragma once
// A height field on the GPU: its pyramid, the visibility of its receivers, and what it hides from characters. It gives
// what HeightVisibility and fieldVisibility() give.
#include <span>
#include <vector>

#include "player/gl/gl_objects.h"
#include "sh/height/height_visibility.h"

namespace penumbra {

class GlHeights {
public:
    // The field outlives this object; `corner` is where height 0 of row 0 and column 0 stands in the scene. Throws
    // Unsupported where the field is too large for this OpenGL. `tolerance` is that of HeightVisibility.
    GlHeights(const HeightField& field, int order, int step, float tolerance, Vec3 corner);

    const HeightField& field() const { return *field_; }
    const HeightTables& tables() const { return tables_; }
    const HeightReceivers& receivers() const { return receivers_; }
    float tolerance() const { return tolerance_; }
    Vec3 corner() const { return corner_; }

    // Takes over what HeightField::set() changed: uploads the box of heights, makes the maxima above it anew and lets
    // those receivers look that see it. The first call takes all.
    void update(std::span<const TexelBox> changed);
    // How many heights were uploaded, maxima computed and receivers evaluated by the last update().
    struct Work {
        std::size_t heights = 0, maxima = 0, receivers = 0;
    };
    const Work& work() const { return work_; }

    // Writes the second set of `casts` for receivers of GlCast.
    void castOn(const GlObject& receivers, const GlObject& casts, std::size_t count) const;
    // Binds the heights and the taps of points, blocks 0 and 1, the rows of receivers, block 2, and what finer ones
    // see, blocks 6 and 7.
    void bind() const;

private:
    const HeightField* field_;
    HeightTables tables_, above_;
    HeightReceivers receivers_;
    float tolerance_;
    Vec3 corner_;
    bool is_new_ = true;
    Work work_;
    std::vector<std::uint32_t> awake_, looking_;  // receivers of the last update, and cells between them
    GlObject numbers_, taps_, above_taps_, rows_, awake_list_;
    GlObject finer_, shares_, looking_list_;  // where there is a tolerance
    GlObject pyramid_, horizons_, cell_shares_, look_finer_, cast_;

    void makePyramid(TexelBox box);
    void lookForHorizons();
    void lookFiner();
};

}  // namespace penumbra
