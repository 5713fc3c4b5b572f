#pragma once
// Which triangles of a scene stop all rays, and which a filter decides on.
#include <vector>

#include "bake/trace/see_through.h"

namespace penumbra {

// Geometry 0 of a scene has the triangles that stop all rays, and geometry 1 the others.
constexpr unsigned kFilteredGeometry = 1;

// A triangle that does not stop all rays.
struct FilteredTriangle {
    std::uint32_t number;  // in the scene as it was given
    std::uint32_t pieces;  // n, along an edge
    std::uint32_t first;   // index of the first of its n^2 values
};

struct SceneTriangles {
    std::vector<std::uint32_t> stopping;     // triangles of geometry 0; empty with `all_stop`: all triangles in their
                                             // order
    std::vector<FilteredTriangle> filtered;  // triangles of geometry 1
    std::vector<std::uint8_t> values;        // opacities of their pieces
    std::vector<bool> has_twin;              // one for each triangle as it was given; empty: none has a twin
    bool all_stop = true;

    SceneTriangles() = default;
    SceneTriangles(std::size_t triangles, const SeeThrough& through) {
        const bool any_opacity = through.opacity && !through.opacity->empty();
        if (!any_opacity && through.twins.empty()) return;
        all_stop = false;
        if (any_opacity) values = through.opacity->values;
        for (std::uint32_t t = 0; t < through.twins.size(); ++t) has_twin.push_back(through.twins[t] != t);
        for (std::uint32_t t = 0; t < triangles; ++t) {
            if (t < through.twins.size() && through.twins[t] < t) continue;
            const std::size_t place = any_opacity ? through.opacity->find(t) : kUnlisted;
            if (place == kUnlisted)
                stopping.push_back(t);
            else
                filtered.push_back({t, through.opacity->pieces[place], through.opacity->first[place]});
        }
    }

    // Returns the number of a triangle that was hit, in the scene as it was given.
    std::uint32_t numberOf(unsigned geometry, unsigned primitive) const {
        if (geometry == kFilteredGeometry) return filtered[primitive].number;
        return all_stop ? primitive : stopping[primitive];
    }
    // Tells whether both sides of a triangle are fronts.
    bool isTwin(unsigned geometry, unsigned primitive) const {
        if (has_twin.empty()) return false;
        const std::uint32_t number = numberOf(geometry, primitive);
        return number < has_twin.size() && has_twin[number];
    }
    // Tells whether a filtered triangle stops a ray that meets it at u, v.
    bool stops(unsigned primitive, float u, float v, Vec3 origin, Vec3 direction) const {
        const FilteredTriangle& triangle = filtered[primitive];
        const std::uint32_t piece = triangle.pieces == 1 ? 0 : opacityPiece(triangle.pieces, u, v);
        return stopsRay(values[triangle.first + piece], origin, direction, triangle.number);
    }
};

}  // namespace penumbra
