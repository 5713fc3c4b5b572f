// Writes a level of the pyramid of a height field from the one below: the largest of two by two.
layout(local_size_x = 8, local_size_y = 8) in;

layout(std430, binding = 0) buffer Heights { float heights[]; };  // heights of all levels

uniform ivec2 first, count;  // in the level: first row and column, and how many
uniform ivec2 below;         // rows and columns of the level below
uniform ivec2 begins;        // where the level begins and where the one below does
uniform int columns;         // columns of the level

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.yx);
    if (any(greaterThanEqual(at, count))) return;
    at += first;
    ivec2 low = 2 * at, high = min(low + 1, below - 1);
    int upper = begins.y + low.x * below.y, lower = begins.y + high.x * below.y;
    heights[begins.x + at.x * columns + at.y] = max(max(heights[upper + low.y], heights[upper + high.y]),
                                                     max(heights[lower + low.y], heights[lower + high.y]));
}
