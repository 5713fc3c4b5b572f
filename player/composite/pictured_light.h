#pragma once
// Computes the light that the vertices of a character with pictures send onto the ground.
#include <span>
#include <vector>

#include "runtime/shade/shading_set.h"

namespace penumbra {

class PicturedLight {
public:
    // Opens the pictures of the set's asset, which has some, and looks at the texel of each vertex. Throws what
    // openTexture() throws. Keeps no reference.
    explicit PicturedLight(const ShadingSet& shading);

    // Joins the terms of vertices, [terms, V] (ShadingSet::shadeTerms()), into their radiance [V]. A and B are those of
    // the step that is next to the roughness of the vertex. Occlusion is left out.
    void join(std::span<const Vec3> terms, std::span<Vec3> radiance) const;

private:
    struct Look {
        Vec3 diffuse{1, 1, 1}, f0, emissive;
        float f90 = 0;
        std::size_t f0_term = 0;  // A; B follows. 0: there is none
    };
    std::vector<Look> looks_;  // [V]; of a slot that does not show its pictures the first term is all
};

}  // namespace penumbra
