#include "fit/clusters/triangle_motion.h"

#include <algorithm>
#include <cmath>

#include "fit/numerics/pca.h"
#include "formats/common/parallel_for.h"

namespace penumbra {

namespace {

constexpr std::size_t kMaxFrames = 32, kMaxDimensions = 16, kMaxRows = 2000;
constexpr double kVarianceKept = 0.99;

// Returns a matrix whose columns are two edges and the unit normal.
Mat3d frameOf(Vec3 a, Vec3 b, Vec3 c) {
    const Vec3d e = toDouble(b) - toDouble(a), f = toDouble(c) - toDouble(a);
    return transposed(fromRows(e, f, normalized(cross(e, f))));
}

// Returns the rotation of the deformation gradient, or the identity where the triangle has no area at rest.
Mat3 rotationOf(const Mat3d& rest, const Mat3d& moved) {
    const Mat3d c = cofactor(rest);
    const double det = rest.m[0] * c.m[0] + rest.m[1] * c.m[1] + rest.m[2] * c.m[2];
    if (!(std::abs(det) > 0)) return {};
    Mat3d gradient = moved * transposed(c);
    Mat3 out;
    for (std::size_t i = 0; i < 9; ++i) out.m[i] = float(gradient.m[i] / det);
    return nearestRotation(out);
}

// Writes the 9 entries of every frame's rotation, scaled so that distances of rows are angles: for small angles |R_a -
// R_b|_F is sqrt(2) times the angle between the two.
void writeRotations(const DeformingFrames& mesh, std::span<const std::size_t> frames, const Triangle& t,
                    std::span<float> out) {
    const auto scale = float(1 / std::sqrt(2.0 * double(frames.size())));
    const Mat3d rest = frameOf(mesh.rest[t[0]], mesh.rest[t[1]], mesh.rest[t[2]]);
    for (std::size_t i = 0; i < frames.size(); ++i) {
        const std::span<const Vec3> p = mesh.positionsOf(frames[i]);
        const Mat3 rotation = rotationOf(rest, frameOf(p[t[0]], p[t[1]], p[t[2]]));
        for (std::size_t k = 0; k < 9; ++k) out[9 * i + k] = scale * rotation.m[k];
    }
}

}  // namespace

std::vector<std::size_t> evenlySpread(std::size_t count, std::size_t most) {
    std::vector<std::size_t> rows;
    const std::size_t kept = std::min(count, most);
    for (std::size_t i = 0; i < kept; ++i) rows.push_back(i * count / kept);
    return rows;
}

MatrixF triangleMotions(const DeformingFrames& mesh, int threads) {
    // 1. Write the rotations of a sample of triangles in a sample of frames.
    std::vector<std::size_t> frames;
    for (std::size_t i : evenlySpread(mesh.frames.size(), kMaxFrames)) frames.push_back(mesh.frames[i]);
    const std::vector<std::size_t> sample = evenlySpread(mesh.triangles.size(), kMaxRows);
    MatrixF rows(sample.size(), 9 * frames.size());
    parallelFor(sample.size(), threads,
                [&](std::size_t r) { writeRotations(mesh, frames, mesh.triangles[sample[r]], rows.row(r)); });
    // 2. Reduce them by PCA.
    const std::vector<double> mean = meanOfRows(rows, indices(rows.rows));
    for (std::size_t r = 0; r < rows.rows; ++r)
        for (std::size_t c = 0; c < rows.columns; ++c) rows(r, c) -= float(mean[c]);
    const Pca pca = principalComponents(rows);
    const std::size_t size =
        pca.energies.empty() ? 1 : std::min(componentsFor(pca, kVarianceKept), std::min(kMaxDimensions, rows.columns));
    const MatrixF basis = basisOf(pca, rows, size);

    // 3. Project the rotations of every triangle on that basis.
    MatrixF out(mesh.triangles.size(), size);
    constexpr std::size_t kBlock = 256;
    parallelFor((out.rows + kBlock - 1) / kBlock, threads, [&](std::size_t block) {
        std::vector<float> turned(rows.columns);
        for (std::size_t t = block * kBlock; t < std::min((block + 1) * kBlock, out.rows); ++t) {
            writeRotations(mesh, frames, mesh.triangles[t], turned);
            for (std::size_t d = 0; d < size; ++d) {
                double sum = 0;
                for (std::size_t c = 0; c < turned.size(); ++c) sum += (turned[c] - mean[c]) * double(basis(d, c));
                out(t, d) = float(sum);
            }
        }
    });
    return out;
}

}  // namespace penumbra
