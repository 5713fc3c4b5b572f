// Shades all terms of a surface with pictures at once (docs/formulas.md, section 18). This is a part of
// shade_lanes.cpp, which includes it.
//
// Problem: a vertex shows up to seven materials and two slopes, which differ in their f alone.
//
// Naive: shade one after the other. Each joins visibility with its f, and turns what results to the light.
//
// Here: light is turned into the frame of the vertex and joined with visibility once. A material is then a short sum
// over its f. That costs more than one material and less than two, since three colours of light are turned and joined
// in the place of one grey material. The frame has the eye at azimuth 0, so that nearly half of f is zero.

namespace penumbra {

namespace {

// The numbers of kBlocks blocks. They stand side by side, so that each entry of a table is read once for all.
struct JointBlocks {
    LaneFrames frames[kBlocks];  // turned to the eye
    BouncedLanes bounced[kBlocks];
    Lanes v[kMaxOrder * kMaxOrder][kBlocks];  // visibility
    Lanes view_basis[kMaxOrder * kMaxOrder][kBlocks];
    Lanes light[kMaxOrder * kMaxOrder][3][kBlocks];
    Lanes g[kMaxOrder * kMaxOrder][3][kBlocks];
    Lanes sky[kMaxOrder * kMaxOrder][kBlocks];  // T_0k
};

struct JointTurn {
    Lanes cosine[kMaxOrder], sine[kMaxOrder];
};

// The turn by the angle of (x, y). Where both are 0, any angle will do.
inline void turnOf(int order, const Lanes& x, const Lanes& y, JointTurn& out) {
    const Lanes square = x * x + y * y, one = kZeros + 1;
    Lanes length = square, scale;
    root(length);
    choose(square > 1e-30f, one / length, kZeros, scale);
    choose(square > 1e-30f, x * scale, one, out.cosine[1]);
    out.sine[1] = y * scale;
    multiples(order, out.cosine, out.sine);
}

// Reads the numbers of 8 vertices, in the order of the convention.
inline void gatherRows(const ShadeInput& in, std::size_t first, std::size_t end, Lanes* out) {
    constexpr std::size_t kMax = kMaxOrder * kMaxOrder;
    float rows[kLanes][kMax];
    for (std::size_t lane = 0; lane < kLanes; ++lane)
        __builtin_memcpy(rows[lane], in.coefficients + vertexOf(in, first, end, lane) * std::size_t(in.stride),
                         std::size_t(in.size) * sizeof(float));
    for (int j = 0; j < in.size; j += 8) transpose(&rows[0][j], kMax, out + j);
}

// Turns the frame of a block about the normal until the eye has azimuth 0, and what was gathered with it.
inline void turnToEye(const ShadeTerms& terms, const Lanes* coefficients, const ShadeInput& in, int block,
                      JointBlocks& out) {
    const int order = terms.joint.order;
    LaneFrames& q = out.frames[block];
    JointTurn turn;
    turnOf(order, q.view.x, q.view.y, turn);
    for (const JointCoefficient* n = terms.joint.coefficients; n < terms.joint.coefficients + in.size; ++n) {
        const Lanes &plus = coefficients[n->plus], &minus = coefficients[n->minus];
        // (l, m) and (l, -m) are a pair; the functions with m = 0 stay as they are.
        if (n->m == 0)
            out.v[n->index][block] = plus;
        else if (n->m > 0)
            out.v[n->index][block] = turn.cosine[n->m] * plus + turn.sine[n->m] * minus;
        else
            out.v[n->index][block] = turn.cosine[-n->m] * minus - turn.sine[-n->m] * plus;
    }
    const Lanes c = turn.cosine[1], s = turn.sine[1];
    LaneVec3 &t = q.tangent, &b = q.bitangent;
    const LaneVec3 along{c * t.x + s * b.x, c * t.y + s * b.y, c * t.z + s * b.z};
    b = {c * b.x - s * t.x, c * b.y - s * t.y, c * b.z - s * t.z};
    t = along;
    q.view.x = c * q.view.x + s * q.view.y;
}

// The basis at azimuth 0, m >= 0 and l + m even, by the recurrences of shade_kernel.h.
inline void meridianBasis(const ShadeLight& light, int order, int block, JointBlocks& out) {
    const Lanes x = out.frames[block].view.x, z = out.frames[block].view.z;
    Lanes power = kZeros + 1;
    for (int m = 0; m < order; ++m) {
        Lanes q = kZeros + light.basis_a[m * kMaxOrder + m], before = kZeros;
        for (int l = m; l < order; ++l) {
            if (l > m) {
                const float a = light.basis_a[l * kMaxOrder + m], b = light.basis_b[l * kMaxOrder + m];
                const Lanes next = a * (z * q) - b * before;
                before = q;
                q = next;
            }
            if ((l + m) % 2 == 0) out.view_basis[l * l + l + m][block] = q * power;
        }
        power = power * x;
    }
}

// Q = Z(a) Y(b) Z(c) of a block, as makeTurns() has it.
struct FrameTurns {
    JointTurn a, b, c;
};
inline void frameTurns(int order, const LaneFrames& q, FrameTurns& out) {
    turnOf(order, q.tangent.z, q.bitangent.z, out.a);
    const Lanes cosine = out.a.cosine[1], sine = out.a.sine[1];
    out.b.cosine[1] = q.normal.z;
    out.b.sine[1] = cosine * q.tangent.z + sine * q.bitangent.z;
    out.c.cosine[1] = cosine * q.bitangent.y - sine * q.tangent.y;
    out.c.sine[1] = cosine * q.bitangent.x - sine * q.tangent.x;
    multiples(order, out.b.cosine, out.b.sine);
    multiples(order, out.c.cosine, out.c.sine);
}

using JointLight = Lanes[3][kBlocks];

// Sets the light of a block to R(Z(angle)) light.
inline void turnLight(int order, const JointTurn& turn, int block, JointLight* light) {
    for (int m = 1; m < order; ++m) {
        const Lanes cosine = turn.cosine[m], sine = turn.sine[m];
        for (int l = m; l < order; ++l)
            for (int c = 0; c < 3; ++c) {
                Lanes &plus = light[l * l + l + m][c][block], &minus = light[l * l + l - m][c][block];
                const Lanes turned = cosine * plus - sine * minus;
                minus = cosine * minus + sine * plus;
                plus = turned;
            }
    }
}

// out_to = sum of value * in_from. Every `to` has a term.
inline void quarterTurnLight(const SparseTerm* term, std::size_t count, const JointLight* in, JointLight* out) {
    for (const SparseTerm* end = term + count; term < end;) {
        const int to = term->to;
        Lanes sum[3][kBlocks];
        for (int c = 0; c < 3; ++c)
            for (int b = 0; b < kBlocks; ++b) sum[c][b] = term->value * in[term->from][c][b];
        for (++term; term < end && term->to == to; ++term)
            for (int c = 0; c < 3; ++c)
                for (int b = 0; b < kBlocks; ++b) sum[c][b] += term->value * in[term->from][c][b];
        for (int c = 0; c < 3; ++c)
            for (int b = 0; b < kBlocks; ++b) out[to][c][b] = sum[c][b];
    }
}

// Computes R(Q) l = Z(a) X(-90) Z(b) X(90) Z(c) l.
inline void lightOfRotation(const ShadeJoint& joint, const ShadeLight& light, JointBlocks& blocks) {
    JointLight turned[kMaxOrder * kMaxOrder];
    FrameTurns turns[kBlocks];
    const int count = light.order * light.order;
    for (int b = 0; b < kBlocks; ++b) {
        frameTurns(light.order, blocks.frames[b], turns[b]);
        for (int i = 0; i < count; ++i) {
            blocks.light[i][0][b] = kZeros + light.sh[i].x;
            blocks.light[i][1][b] = kZeros + light.sh[i].y;
            blocks.light[i][2][b] = kZeros + light.sh[i].z;
        }
        turnLight(light.order, turns[b].c, b, blocks.light);
    }
    quarterTurnLight(joint.turn, joint.turn_terms, blocks.light, turned);
    for (int b = 0; b < kBlocks; ++b) turnLight(light.order, turns[b].b, b, turned);
    quarterTurnLight(joint.turn_back, joint.turn_terms, turned, blocks.light);
    for (int b = 0; b < kBlocks; ++b) turnLight(light.order, turns[b].a, b, blocks.light);
}

// Computes l_lm = sum_d g_dl y_lm(Q a_d).
inline void lightOfLobes(const ShadeLight& light, int block, JointBlocks& blocks) {
    Lanes basis[kMaxOrder * kMaxOrder];
    for (int i = 0; i < light.order * light.order; ++i)
        for (int c = 0; c < 3; ++c) blocks.light[i][c][block] = kZeros;
    const LaneFrames& q = blocks.frames[block];
    const Vec3* g = light.lobe;
    for (std::size_t d = 0; d < light.axis_count; ++d) {
        const Vec3 a = light.axes[d];
        const LaneVec3 local{q.tangent.x * a.x + q.tangent.y * a.y + q.tangent.z * a.z,
                             q.bitangent.x * a.x + q.bitangent.y * a.y + q.bitangent.z * a.z,
                             q.normal.x * a.x + q.normal.y * a.y + q.normal.z * a.z};
        laneBasis(light, light.order, local, basis);
        for (int l = 0; l < light.order; ++l, ++g)
            for (int i = l * l; i < (l + 1) * (l + 1); ++i) {
                blocks.light[i][0][block] += g->x * basis[i];
                blocks.light[i][1][block] += g->y * basis[i];
                blocks.light[i][2][block] += g->z * basis[i];
            }
    }
}

// Joins light and visibility.
inline void join(const ShadeJoint& joint, JointBlocks& blocks) {
    const JointTerm* term = joint.products;
    const JointRow *row = joint.rows, *end = row + joint.row_count;
    while (row < end) {
        const int k = row->k;
        Lanes g[3][kBlocks] = {};
        for (int b = 0; b < kBlocks; ++b) blocks.sky[k][b] = kZeros;
        for (; row < end && row->k == k; ++row) {
            Lanes t[kBlocks];
            for (int b = 0; b < kBlocks; ++b) t[b] = term->value * blocks.v[term->j][b];
            for (const JointTerm* last = term++ + row->terms; term < last; ++term)
                for (int b = 0; b < kBlocks; ++b) t[b] += term->value * blocks.v[term->j][b];
            for (int c = 0; c < 3; ++c)
                for (int b = 0; b < kBlocks; ++b) g[c][b] += blocks.light[row->i][c][b] * t[b];
            if (row->i == 0)
                for (int b = 0; b < kBlocks; ++b) blocks.sky[k][b] = t[b];
        }
        for (int c = 0; c < 3; ++c)
            for (int b = 0; b < kBlocks; ++b) blocks.g[k][c][b] = g[c][b];
    }
}

struct TermSums {
    Lanes radiance[3][kBlocks], hidden[kBlocks];
};

// Computes the next f_k of a term.
inline void nextF(const ViewTerm*& view, const ViewTerm* end, const JointBlocks& blocks, Lanes* f) {
    const int k = view->k;
    for (int b = 0; b < kBlocks; ++b) f[b] = view->value * blocks.view_basis[view->e][b];
    for (++view; view < end && view->k == k; ++view)
        for (int b = 0; b < kBlocks; ++b) f[b] += view->value * blocks.view_basis[view->e][b];
}

inline void sumTerm(const ShadeTerm& term, const JointBlocks& blocks, TermSums& out) {
    Lanes sum[3][kBlocks] = {}, f[kBlocks];
    const ViewTerm* view = term.views;
    for (const ViewTerm* end = view + term.view_terms; view < end;) {
        const int k = view->k;
        nextF(view, end, blocks, f);
        for (int c = 0; c < 3; ++c)
            for (int b = 0; b < kBlocks; ++b) sum[c][b] += f[b] * blocks.g[k][c][b];
    }
    for (int c = 0; c < 3; ++c)
        for (int b = 0; b < kBlocks; ++b) out.radiance[c][b] = sum[c][b];
}

// Computes what a term would show of a white sky where that is hidden (hiddenAlbedo()). 4 pi Gamma_00k is sqrt(4 pi)
// where k is 0, and else nothing.
inline void sumHidden(const ShadeTerm& term, const JointBlocks& blocks, TermSums& out) {
    Lanes sum[kBlocks] = {}, f[kBlocks];
    const ViewTerm* view = term.views;
    for (const ViewTerm* end = view + term.view_terms; view < end;) {
        const int k = view->k;
        nextF(view, end, blocks, f);
        for (int b = 0; b < kBlocks; ++b) sum[b] += k == 0 ? f[b] - f[b] * blocks.sky[k][b] : -f[b] * blocks.sky[k][b];
    }
    for (int b = 0; b < kBlocks; ++b) out.hidden[b] = 3.54490770f * sum[b];
}

inline void addBouncedTerm(const BouncedLanes& bounced, int block, TermSums& sums) {
    for (int c = 0; c < 3; ++c) sums.radiance[c][block] += bounced.light[c] * sums.hidden[block] * bounced.scale;
}

// The vertices that the blocks have: kBlocks * kLanes from the first on, but none from `end` on.
struct Piece {
    std::size_t first, end;
};

inline void storeTerm(const ShadeTerms& terms, const ShadeInput& in, const Piece& piece, std::size_t to,
                      const LaneVec3& value) {
    Vec3* const out = in.radiance + to * terms.vertices;
    for (std::size_t lane = 0; lane < kLanes && piece.first + lane < piece.end; ++lane)
        out[vertexOf(in, piece.first, piece.end, lane)] = {value.x[lane], value.y[lane], value.z[lane]};
}

inline void shadeSums(const ShadeTerms& terms, const ShadeInput& in, const Piece& piece, const JointBlocks& blocks) {
    TermSums sums;
    for (std::size_t n = 0; n < terms.count; ++n) {
        const ShadeTerm& term = terms.terms[n];
        sumTerm(term, blocks, sums);
        if (in.bounces()) sumHidden(term, blocks, sums);
        for (int b = 0; b < kBlocks; ++b) {
            if (in.bounces()) {
                raiseTo(0, sums.hidden[b]);
                addBouncedTerm(blocks.bounced[b], b, sums);
            }
            storeTerm(terms, in, {piece.first + std::size_t(b) * kLanes, piece.end}, term.to,
                      {term.color[0] * sums.radiance[0][b], term.color[1] * sums.radiance[1][b],
                       term.color[2] * sums.radiance[2][b]});
        }
    }
}

// The slopes along both axes become a vector in the model frame.
inline void shadeSlopes(const ShadeTerms& terms, const ShadeInput& in, const Piece& piece, const JointBlocks& blocks) {
    TermSums x, y;
    sumTerm(terms.slopes[0], blocks, x);
    sumTerm(terms.slopes[1], blocks, y);
    if (in.bounces()) {
        sumHidden(terms.slopes[0], blocks, x);
        sumHidden(terms.slopes[1], blocks, y);
    }
    for (int b = 0; b < kBlocks; ++b) {
        if (in.bounces()) {
            addBouncedTerm(blocks.bounced[b], b, x);
            addBouncedTerm(blocks.bounced[b], b, y);
        }
        const LaneVec3 &t = blocks.frames[b].tangent, &s = blocks.frames[b].bitangent;
        for (std::size_t c = 0; c < 3; ++c) {
            const Lanes &along = x.radiance[c][b], &across = y.radiance[c][b];
            storeTerm(terms, in, {piece.first + std::size_t(b) * kLanes, piece.end}, 1 + c,
                      {t.x * along + s.x * across, t.y * along + s.y * across, t.z * along + s.z * across});
        }
    }
}

inline void clearLight(int order, JointBlocks& blocks) {
    for (int i = 0; i < order * order; ++i)
        for (int c = 0; c < 3; ++c)
            for (int b = 0; b < kBlocks; ++b) blocks.light[i][c][b] = kZeros;
}

inline void gatherJoint(const ShadeTerms& terms, const ShadeLight& light, const ShadeInput& in, const Piece& piece,
                        JointBlocks& blocks) {
    Lanes coefficients[kMaxOrder * kMaxOrder];
    for (int b = 0; b < kBlocks; ++b) {
        const std::size_t first = piece.first + std::size_t(b) * kLanes;
        gather(in, first, piece.end, blocks.frames[b]);
        gatherRows(in, first, piece.end, coefficients);
        if (in.bounces()) gatherBounced(in, first, piece.end, blocks.frames[b], coefficients, blocks.bounced[b]);
        turnToEye(terms, coefficients, in, b, blocks);
        meridianBasis(light, terms.view_order, b, blocks);
    }
}

inline void shadeTermLanes(const ShadeTerms& terms, const ShadeLight& light, const ShadeInput& in, std::size_t begin,
                           std::size_t end) {
    JointBlocks blocks;
    for (std::size_t first = begin; first < end; first += kBlocks * kLanes) {
        const Piece piece{first, end};
        gatherJoint(terms, light, in, piece, blocks);
        if (!in.direct)
            clearLight(light.order, blocks);
        else if (light.lobes)
            for (int b = 0; b < kBlocks; ++b) lightOfLobes(light, b, blocks);
        else
            lightOfRotation(terms.joint, light, blocks);
        join(terms.joint, blocks);
        shadeSums(terms, in, piece, blocks);
        if (terms.has_slopes) shadeSlopes(terms, in, piece, blocks);
    }
}

}  // namespace

}  // namespace penumbra
