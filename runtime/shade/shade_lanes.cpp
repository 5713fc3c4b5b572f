// Shades 8 vertices at a time.
//
// Problem: radiance is the product of light, visibility and reflectance, each expanded in SH, in the local frame of
// each vertex (docs/formulas.md, section 3). That takes hundreds of multiply-adds a vertex, and an SH rotation of the
// light.
//
// Naive: multiply by the full tensor of triple products, and rotate the light by a matrix for each vertex. Most of
// the tensor and of the rotation is zero.
//
// Here: tables list only what is not zero (material_tables.h). They are the same for all vertices, so each entry is
// read once and used for the lanes of several blocks. The light is not rotated: t is turned into the model frame by
// three turns about z and two fixed ones, all without trigonometry.
#include "runtime/shade/shade_kernel.h"
#include "sh/indirect_coefficients.h"
#include "sh/lanes.h"

namespace penumbra {

namespace {

struct LaneVec3 {
    Lanes x, y, z;
};
inline void setLane(LaneVec3& out, std::size_t lane, const Vec3& value) { setLane(&out.x, lane, value); }

// Evaluates the SH basis at 8 unit directions by the recurrences of shade_kernel.h.
inline void laneBasis(const ShadeLight& light, int order, const LaneVec3& d, Lanes* out) {
    Lanes re = kZeros + 1, im = kZeros;
    for (int m = 0; m < order; ++m) {
        Lanes q = kZeros + light.basis_a[m * kMaxOrder + m], before = kZeros;
        for (int l = m; l < order; ++l) {
            if (l > m) {
                const float a = light.basis_a[l * kMaxOrder + m], b = light.basis_b[l * kMaxOrder + m];
                const Lanes next = a * (d.z * q) - b * before;
                before = q;
                q = next;
            }
            if (m > 0) out[l * l + l - m] = q * im;
            out[l * l + l + m] = q * re;
        }
        const Lanes turned = re * d.x - im * d.y;
        im = re * d.y + im * d.x;
        re = turned;
    }
}

struct LaneFrames {
    LaneVec3 tangent, bitangent, normal;
    LaneVec3 view;  // local frame, unit
};

// Returns the vertex that lane `lane` of the block at `first` has; beyond `end` it is the last one again.
inline std::size_t vertexOf(const ShadeInput& in, std::size_t first, std::size_t end, std::size_t lane) {
    const std::size_t at = first + lane < end ? first + lane : end - 1;
    return in.order ? in.order[at] : at;
}

// Gathers the frames of 8 vertices, and their view directions in these frames.
inline void gather(const ShadeInput& in, std::size_t first, std::size_t end, LaneFrames& out) {
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
        const std::size_t v = vertexOf(in, first, end, lane);
        const Vec3 n = in.normals[v], t = in.tangents[v], p = in.positions[v];
        const float bx = n.y * t.z - n.z * t.y, by = n.z * t.x - n.x * t.z, bz = n.x * t.y - n.y * t.x;
        float ox = in.eye.x - p.x, oy = in.eye.y - p.y, oz = in.eye.z - p.z;
        const float square = ox * ox + oy * oy + oz * oz;
        const float scale = square > 0 ? 1 / __builtin_sqrtf(square) : 0;
        ox *= scale, oy *= scale, oz *= scale;
        setLane(out.tangent, lane, t);
        setLane(out.bitangent, lane, {bx, by, bz});
        setLane(out.normal, lane, n);
        setLane(out.view, lane,
                {ox * t.x + oy * t.y + oz * t.z, ox * bx + oy * by + oz * bz,
                 square > 0 ? ox * n.x + oy * n.y + oz * n.z : 1});
    }
}

inline void gatherCoefficients(const ShadeInput& in, std::size_t first, std::size_t end, Lanes* v) {
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
        const float* coefficients = in.coefficients + vertexOf(in, first, end, lane) * std::size_t(in.stride);
        for (int j = 0; j < in.size; ++j) setLane(v[j], lane, coefficients[j]);
    }
}

// The numbers that the kernel computes for 8 vertices.
struct Block {
    LaneFrames frames;
    Lanes v[kMaxOrder * kMaxOrder], view_basis[kMaxOrder * kMaxOrder], t[3][kMaxOrder * kMaxOrder];
    Lanes hidden[3];  // a - t_u of a colour channel, not below 0; only where light bounces
};
// The tables are walked for several blocks at once: the sums of one block fill the gaps in which those of another
// wait. Without AVX2 there are too few registers for that.
#ifdef __AVX2__
constexpr int kBlocks = 2;
#else
constexpr int kBlocks = 1;
#endif

// Computes s = sum of value * f_k over the next `terms` of the products.
inline void productSum(int terms, const Lanes (*f)[kBlocks], const ProductTerm*& term, Lanes* s) {
    for (int b = 0; b < kBlocks; ++b) s[b] = term->value * f[term->k][b];
    for (const ProductTerm* last = term++ + terms; term < last; ++term)
        for (int b = 0; b < kBlocks; ++b) s[b] += term->value * f[term->k][b];
}

inline void raiseTo(float least, Lanes& x) { choose(x > least, x, x * 0.0f + least, x); }

// Computes what the material sends to the eye of the light that comes from where the sky is hidden, as if it were
// white.
inline void hiddenAlbedo(const ShadeMaterial& material, std::size_t channel, const Lanes (*f)[kBlocks], Block* blocks) {
    constexpr float kFourPi = 12.5663706f, kRootFourPi = 3.54490770f;
    Lanes s[kBlocks];
    for (int b = 0; b < kBlocks; ++b) s[b] = kZeros;
    const ProductTerm* term = material.products[channel] + material.albedo_first;
    for (const ProductTerm* end = term + material.albedo_terms; term < end; ++term)
        for (int b = 0; b < kBlocks; ++b) s[b] += term->value * f[term->k][b];
    for (int b = 0; b < kBlocks; ++b) {
        blocks[b].hidden[channel] = kFourPi * s[b] - kRootFourPi * blocks[b].t[channel][0];
        raiseTo(material.least_hidden, blocks[b].hidden[channel]);
    }
}

// Computes t of one colour channel.
inline void transfer(const ShadeMaterial& material, int light_order, bool bounces, std::size_t channel, Block* blocks) {
    Lanes f[kMaxOrder * kMaxOrder][kBlocks], s[kBlocks];
    // 1. View terms give f. They are sorted by k, so that a sum stays in registers.
    const ViewTerm* view = material.views[channel];
    for (const ViewTerm* end = view + material.view_terms[channel]; view < end;) {
        const int k = view->k;
        for (int b = 0; b < kBlocks; ++b) s[b] = view->value * blocks[b].view_basis[view->e];
        for (++view; view < end && view->k == k; ++view)
            for (int b = 0; b < kBlocks; ++b) s[b] += view->value * blocks[b].view_basis[view->e];
        for (int b = 0; b < kBlocks; ++b) f[k][b] = s[b];
    }
    // 2. Product rows add to t. Rows with a mirror come first and use their sum twice.
    for (int b = 0; b < kBlocks; ++b)
        for (int i = 0; i < light_order * light_order; ++i) blocks[b].t[channel][i] = kZeros;
    const ProductTerm* term = material.products[channel];
    std::size_t r = 0;
    for (; r < material.mirrored_rows; ++r) {
        const ProductRow row = material.rows[r];
        productSum(row.terms, f, term, s);
        for (int b = 0; b < kBlocks; ++b) {
            blocks[b].t[channel][row.i] += blocks[b].v[row.j] * s[b];
            blocks[b].t[channel][row.mirror_i] += blocks[b].v[row.mirror_j] * s[b];
        }
    }
    for (; r < material.row_count; ++r) {
        const ProductRow row = material.rows[r];
        productSum(row.terms, f, term, s);
        for (int b = 0; b < kBlocks; ++b) blocks[b].t[channel][row.i] += blocks[b].v[row.j] * s[b];
    }
    // 3. What the sky does not reach.
    if (bounces) hiddenAlbedo(material, channel, f, blocks);
}

// Adds g_c * (sum over m of t y(axis in the local frame)) to radiance_c for every axis and band.
inline void lightByLobes(const ShadeLight& light, std::size_t channels, const LaneFrames& frames,
                         const Lanes (*t)[kMaxOrder * kMaxOrder], Lanes* radiance) {
    Lanes basis[kMaxOrder * kMaxOrder];
    const Vec3* g = light.lobe;
    for (std::size_t d = 0; d < light.axis_count; ++d) {
        const Vec3 a = light.axes[d];
        const LaneVec3 local{frames.tangent.x * a.x + frames.tangent.y * a.y + frames.tangent.z * a.z,
                             frames.bitangent.x * a.x + frames.bitangent.y * a.y + frames.bitangent.z * a.z,
                             frames.normal.x * a.x + frames.normal.y * a.y + frames.normal.z * a.z};
        laneBasis(light, light.order, local, basis);
        for (int l = 0; l < light.order; ++l, ++g) {
            const float weight[3] = {g->x, g->y, g->z};
            Lanes sum = {};
            for (std::size_t c = 0; c < 3; ++c) {
                if (c < channels) {
                    sum = t[c][l * l] * basis[l * l];
                    for (int i = l * l + 1; i < (l + 1) * (l + 1); ++i) sum += t[c][i] * basis[i];
                }
                radiance[c] += weight[c] * sum;
            }
        }
    }
}

// The cosines and sines of m times the angles of Q = Z(a) Y(b) Z(c), m < order.
struct LaneTurns {
    Lanes cos_a[kMaxOrder], sin_a[kMaxOrder], cos_b[kMaxOrder], sin_b[kMaxOrder], cos_c[kMaxOrder], sin_c[kMaxOrder];
};

// Fills in the multiples of an angle from 2 on by the addition theorems.
inline void multiples(int order, Lanes* cosine, Lanes* sine) {
    for (int m = 2; m < order; ++m) {
        cosine[m] = cosine[m - 1] * cosine[1] - sine[m - 1] * sine[1];
        sine[m] = sine[m - 1] * cosine[1] + cosine[m - 1] * sine[1];
    }
}

// The rows of Q are tangent, bitangent and normal, so that its last column is (cos a sin b, sin a sin b, cos b). Near
// the pole a is ill defined, and any value will do: b and c are taken from Z(-a) Q, which makes up for it.
inline void makeTurns(int order, const LaneFrames& q, LaneTurns& out) {
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
        const float x = q.tangent.z[lane], y = q.bitangent.z[lane], square = x * x + y * y;
        const float scale = square > 1e-30f ? 1 / __builtin_sqrtf(square) : 0;
        setLane(out.cos_a[1], lane, square > 1e-30f ? x * scale : 1);
        setLane(out.sin_a[1], lane, y * scale);
    }
    const Lanes cos_a = out.cos_a[1], sin_a = out.sin_a[1];
    out.cos_b[1] = q.normal.z;
    out.sin_b[1] = cos_a * q.tangent.z + sin_a * q.bitangent.z;
    out.cos_c[1] = cos_a * q.bitangent.y - sin_a * q.tangent.y;
    out.sin_c[1] = cos_a * q.bitangent.x - sin_a * q.tangent.x;
    multiples(order, out.cos_a, out.sin_a);
    multiples(order, out.cos_b, out.sin_b);
    multiples(order, out.cos_c, out.sin_c);
}

// Sets t to R(Z(-angle)) t in place.
inline void turnBack(int order, const Lanes* cosine, const Lanes* sine, Lanes* t) {
    for (int l = 1; l < order; ++l)
        for (int m = 1; m <= l; ++m) {
            Lanes &plus = t[l * l + l + m], &minus = t[l * l + l - m];
            const Lanes turned = cosine[m] * plus + sine[m] * minus;
            minus = cosine[m] * minus - sine[m] * plus;
            plus = turned;
        }
}

// Adds l . (R(Q)^T t) = l . Z(-c) X(-90) Z(-b) X(90) Z(-a) t to the radiance.
inline void lightByRotation(const ShadeLight& light, std::size_t channels, const LaneFrames& frames,
                            Lanes (*t)[kMaxOrder * kMaxOrder], Lanes* radiance) {
    LaneTurns turns;
    makeTurns(light.order, frames, turns);
    const int count = light.order * light.order;
    for (std::size_t c = 0; c < channels; ++c) {
        Lanes *in = t[c], turned[kMaxOrder * kMaxOrder];
        turnBack(light.order, turns.cos_a, turns.sin_a, in);
        for (int i = 0; i < count; ++i) turned[i] = kZeros;
        for (const TurnTerm* s = light.turns; s < light.turns + light.turn_count; ++s)
            turned[s->to] += s->value * in[s->from];
        turnBack(light.order, turns.cos_b, turns.sin_b, turned);
        for (int i = 0; i < count; ++i) in[i] = kZeros;
        for (const TurnTerm* s = light.turns; s < light.turns + light.turn_count; ++s)
            in[s->from] += s->value * turned[s->to];
        turnBack(light.order, turns.cos_c, turns.sin_c, in);
    }
    const Lanes *red = t[0], *green = t[channels == 3 ? 1 : 0], *blue = t[channels == 3 ? 2 : 0];
    for (int i = 0; i < count; ++i) {
        radiance[0] += light.sh[i].x * red[i];
        radiance[1] += light.sh[i].y * green[i];
        radiance[2] += light.sh[i].z * blue[i];
    }
}

// Turns the indirect numbers of a block into the model frame, as bounced light has its coefficients: the factors of
// band 1 are those of -y, z, -x, and those of band 2 make a quadratic form of the direction.
inline void turnIndirect(const LaneFrames& q, const Lanes* n, Lanes* out) {
    constexpr float kXy = 0.546274215f, kZz = 0.315391565f;  // sqrt(15 / 16 pi), sqrt(5 / 16 pi)
    const Lanes vx = -n[3], vy = -n[1], vz = n[2];
    const Lanes xx = kXy * n[8] - kZz * n[6], yy = -kXy * n[8] - kZz * n[6], zz = 2 * kZz * n[6];
    const Lanes xy = kXy * n[4], yz = -kXy * n[5], xz = -kXy * n[7];
    const Lanes* const rows[3][3] = {{&q.tangent.x, &q.tangent.y, &q.tangent.z},
                                     {&q.bitangent.x, &q.bitangent.y, &q.bitangent.z},
                                     {&q.normal.x, &q.normal.y, &q.normal.z}};
    Lanes half[3][3];  // M Q
    out[0] = n[0];
    for (int i = 0; i < 3; ++i) {
        const Lanes &t = *rows[0][i], &b = *rows[1][i], &z = *rows[2][i];
        out[1 + i] = vx * t + vy * b + vz * z;
        half[0][i] = xx * t + xy * b + xz * z;
        half[1][i] = xy * t + yy * b + yz * z;
        half[2][i] = xz * t + yz * b + zz * z;
    }
    constexpr int kPairs[6][2] = {{0, 0}, {1, 1}, {2, 2}, {0, 1}, {0, 2}, {1, 2}};
    for (int p = 0; p < 6; ++p) {
        const int i = kPairs[p][0], j = kPairs[p][1];
        out[4 + p] = *rows[0][i] * half[0][j] + *rows[1][i] * half[1][j] + *rows[2][i] * half[2][j];
    }
    out[10] = n[9];
    out[11] = n[10];
}

// The light that bounces to 8 vertices. `scale` is 1 / (pi (1 - E)).
struct BouncedLanes {
    Lanes light[3], scale;
};

inline void gatherIndirect(const ShadeInput& in, std::size_t first, std::size_t end, const LaneFrames& own,
                           Lanes* light) {
    Lanes n[kIndirectSize], turned[kBouncedLight];
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
        const float* coefficients = in.indirect + vertexOf(in, first, end, lane) * kIndirectStride;
        for (std::size_t i = 0; i < kIndirectSize; ++i) setLane(n[i], lane, coefficients[i]);
    }
    turnIndirect(own, n, turned);
    for (std::size_t i = 0; i < kBouncedLight; ++i) {
        light[0] += in.bounced[i].x * turned[i];
        light[1] += in.bounced[i].y * turned[i];
        light[2] += in.bounced[i].z * turned[i];
    }
    for (std::size_t c = 0; c < 3; ++c) raiseTo(0, light[c]);
}

inline void gatherBounced(const ShadeInput& in, std::size_t first, std::size_t end, const LaneFrames& own,
                          const Lanes* v, BouncedLanes& out) {
    constexpr float kPi = 3.14159265f, kMinHidden = 0.01f;  // below it the light fades out
    for (std::size_t c = 0; c < 3; ++c) out.light[c] = kZeros;
    if (in.indirect) gatherIndirect(in, first, end, own, out.light);
    for (std::size_t lane = 0; in.received && lane < kLanes; ++lane) {
        const Vec3 received = in.received[vertexOf(in, first, end, lane)];
        for (std::size_t c = 0; c < 3; ++c) setLane(out.light[c], lane, out.light[c][lane] + received[int(c)]);
    }
    Lanes hidden = kZeros + 1;
    for (int j = 0; j < in.size; ++j) hidden -= in.ambient[j] * v[j];
    raiseTo(kMinHidden, hidden);
    out.scale = 1 / (kPi * hidden);
}

// Adds the light that bounces to the radiance of one block, before the colour of the material.
inline void addBounced(const ShadeMaterial& material, const ShadeInput& in, std::size_t first, std::size_t end,
                       const Block& block, Lanes* radiance) {
    LaneFrames own = block.frames;
    if (material.is_live) gather(in, first, end, own);  // the block has the mirror frame
    BouncedLanes bounced;
    gatherBounced(in, first, end, own, block.v, bounced);
    for (std::size_t c = 0; c < 3; ++c)
        radiance[c] += bounced.light[c] * block.hidden[material.channels == 3 ? c : 0] * bounced.scale;
}

}  // namespace

}  // namespace penumbra

#include "runtime/shade/shade_live_lanes.h"
#include "runtime/shade/shade_terms_lanes.h"

namespace penumbra {

namespace {

// Joins t of one block with the light, and stores the radiance of its vertices.
inline void shadeBlock(const ShadeMaterial& material, const ShadeLight& light, const ShadeInput& in, std::size_t first,
                       std::size_t end, Block& block) {
    Lanes radiance[3] = {};
    if (in.direct && light.lobes)
        lightByLobes(light, material.channels, block.frames, block.t, radiance);
    else if (in.direct)
        lightByRotation(light, material.channels, block.frames, block.t, radiance);
    if (in.bounces()) addBounced(material, in, first, end, block, radiance);
    for (std::size_t lane = 0; lane < kLanes && first + lane < end; ++lane) {
        Vec3& out = in.packed ? in.packed[first + lane - in.packed_first] : in.radiance[vertexOf(in, first, end, lane)];
        out.x = material.color[0] * radiance[0][lane];
        out.y = material.color[1] * radiance[1][lane];
        out.z = material.color[2] * radiance[2][lane];
    }
}

inline void shadeLanes(const ShadeMaterial& material, const ShadeLight& light, const ShadeInput& in, std::size_t begin,
                       std::size_t end) {
    Block blocks[kBlocks];
    for (std::size_t first = begin; first < end; first += kBlocks * kLanes) {
        for (std::size_t b = 0; b < kBlocks; ++b) {
            gather(in, first + b * kLanes, end, blocks[b].frames);
            gatherCoefficients(in, first + b * kLanes, end, blocks[b].v);
            if (material.is_live) liveTransfer(material.live, light.order, blocks[b]);
            if (material.is_live && in.bounces()) liveHiddenAlbedo(material.live, blocks[b]);
            if (!material.is_live) laneBasis(light, material.view_order, blocks[b].frames.view, blocks[b].view_basis);
        }
        for (std::size_t c = 0; c < material.channels && !material.is_live; ++c)
            transfer(material, light.order, in.bounces(), c, blocks);
        for (std::size_t b = 0; b < kBlocks; ++b) shadeBlock(material, light, in, first + b * kLanes, end, blocks[b]);
    }
}

}  // namespace

const ShadePath ShadePath::PENUMBRA_TARGET{PENUMBRA_TARGET_NAME, shadeLanes, shadeTermLanes};

}  // namespace penumbra
