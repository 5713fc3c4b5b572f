#pragma once
// Decides how many shading points stand at one place, by the normals that meet there.
#include <cstdint>
#include <span>
#include <vector>

#include "formats/rig/rig_build.h"

namespace penumbra {

// The vertices of a file, where one that is used on two sides, or across an edge, has become several.
struct SplitVertices {
    std::vector<std::uint32_t> original;  // [N] vertex of the file; the file's own R come first
    std::vector<Triangle> triangles;      // [T] indices < N
    // [N] unit: the file's normal where there is one that agrees with the winding, else that of the vertex' triangles;
    // 0 where these have no area
    std::vector<Vec3> normals;
    std::vector<bool> from_file;       // [N] tells whether `normals` has the file's
    std::vector<std::uint32_t> group;  // [N] what is smooth with `--crease`; vertices of two groups stay two points
    std::vector<std::size_t> against_winding;  // vertices of the file whose normal the winding contradicts, ascending
};

// Splits vertices. `place_of_vertex` [R] numbers places, which have one position and one row of weights.
SplitVertices splitVertices(const SourceVertices& vertices, std::span<const std::uint32_t> place_of_vertex,
                            const RigOptions& options);

// Returns the shading point of each of the N vertices. Points are numbered by their first vertex. Two vertices share a
// point where they share place and group and their normals agree to `split_angle` degrees: of the normals of one
// place the two nearest are joined to their mean, again and again, until no two means agree. So the order of the
// vertices decides only between pairs that are equally near, and a chain of normals joins no more than such a mean
// spans. Where the file has no normals, only opposite sides (150 degrees) stay apart.
std::vector<std::uint32_t> pointsOfVertices(const SplitVertices& split, std::span<const std::uint32_t> place_of_vertex,
                                            double split_angle);

// Returns the rest normals [V] of a welded mesh: the mean of the file's normals, renormalised, where there are any
// (a mean that agrees with the computed normal to 0.1 degrees gives way to it, so that a smooth file keeps its
// bytes), else the computed normal (vertexNormals()).
std::vector<Vec3> restNormals(const SplitVertices& split, std::span<const std::uint32_t> point_of_vertex,
                              const Mesh& mesh);

// Moves the normals that a file has for a part into it, with length 1. Those that are zero or not finite become 0,
// and a note of `source` tells how many.
void takeNormals(std::vector<Vec3> normals, RigSource& source, SourcePart& part);

// Notes for each part how many of its normals the winding contradicts.
void noteAgainstWinding(const SourceVertices& vertices, std::span<const std::size_t> against_winding,
                        RigSource& source);

}  // namespace penumbra
