#pragma once
// Light that characters throw onto the ground and onto one another: one diffuse bounce.
//
// Problem: near the feet of a character the ground loses light to its shadow and gets light from its skin and clothes,
// in their colours: 40% of what the shadow takes in red, where the skin sends back half of the red.
//
// Naive: sum over all triangles what each sends to each point of the ground, if it sees it.
//
// Here: the fields say how much of a point's hemisphere the characters hide, H = pi (1 - E), exactly as their shadow
// does. What is hidden shows the characters, so the light from them is H times the mean radiance of what the point
// sees of them. That mean changes slowly. It is taken over a few hundred emitters, each of which stands for the
// vertices of a cell of space whose normals point into one octant, and counts by the solid angle that it would have
// without the others.
#include <cstdint>
#include <span>
#include <vector>

#include "sh/vec3.h"

namespace penumbra {

// A flat piece of a surface that sends the same radiance everywhere on its front.
struct Emitter {
    Vec3 position;
    Vec3 area;  // unit normal times m^2
    Vec3 radiance;
};

// A vertex that shines.
struct ShiningVertex {
    Vec3 position, area, radiance;  // see Emitter
};

// A mesh and what its vertices send out, [V] or more.
struct ShiningMesh {
    std::span<const Vec3> positions, normals;
    std::span<const std::uint32_t> triangles;  // [3 T]
    std::span<const Vec3> radiance;
};
// Returns the vertices of a mesh of V that stand for all, each for its neighbours as well: a few, those of one slot
// together. `slot_of_vertex` is [V], or empty where there is one slot.
std::vector<std::uint32_t> shiningVertices(std::size_t vertices, std::span<const std::uint16_t> slot_of_vertex);
// Adds the vertices of a mesh that stand for all. Only their radiance is read.
void addShining(const ShiningMesh& mesh, std::vector<ShiningVertex>& vertices);

// Joins vertices that are in one cube of `cell` metres a side and whose normals lie in one octant.
void emittersOf(std::span<const ShiningVertex> vertices, float cell, std::vector<Emitter>& out);

// Returns the mean radiance of what a point sees of the emitters above its horizon, 0 where it sees none.
Vec3 meanRadiance(std::span<const Emitter> emitters, Vec3 point, Vec3 normal);

}  // namespace penumbra
