// Shades lobes about the mirror direction of the view (docs/formulas.md, section 16). This is a part of
// shade_lanes.cpp, which includes it.
//
// Problem: the lobe may change in every frame, so nothing of it may be tabulated by view.
//
// Naive: turn visibility and light into a frame about the mirror direction, two SH rotations of RGB light a vertex.
//
// Here: only what has no colour is turned. The moments b = G d go into the mirror frame by two turns about z. There
// t = M b, and M depends on the lobe alone, so it is made once a frame. From there on t is joined with the light as any
// other t is, only that its frame is the mirror frame.

namespace penumbra {

namespace {

// Adds the sum of value * in_from to out_to. Terms are sorted by `to`, so that a sum stays in registers.
inline void addSparse(const SparseTerm* term, std::size_t count, const Lanes* in, Lanes* out) {
    for (const SparseTerm* end = term + count; term < end;) {
        const int to = term->to;
        Lanes sum = out[to];
        for (; term < end && term->to == to; ++term) sum += term->value * in[term->from];
        out[to] = sum;
    }
}

inline void clear(int count, Lanes* out) {
    for (int i = 0; i < count; ++i) out[i] = kZeros;
}

// The turn Y(-theta) Z(-phi) that takes the mirror direction (sin theta cos phi, sin theta sin phi, cos theta) to z.
struct MirrorTurns {
    Lanes cos_phi[kMaxOrder], sin_phi[kMaxOrder], cos_theta[kMaxOrder], sin_theta[kMaxOrder];
};

// The eye is mirrored to the side of the normal.
inline void makeMirrorTurns(int order, const LaneVec3& view, MirrorTurns& out) {
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
        const float x = -view.x[lane], y = -view.y[lane], z = view.z[lane], square = x * x + y * y;
        const float sine = __builtin_sqrtf(square), scale = square > 1e-30f ? 1 / sine : 0;
        setLane(out.cos_phi[1], lane, square > 1e-30f ? x * scale : 1);
        setLane(out.sin_phi[1], lane, y * scale);
        setLane(out.cos_theta[1], lane, z < 0 ? -z : z);
        setLane(out.sin_theta[1], lane, sine);
    }
    multiples(order, out.cos_phi, out.sin_phi);
    multiples(order, out.cos_theta, out.sin_theta);
}

// Turns the frame (tangent, bitangent, normal) into that of the mirror direction.
inline void turnToMirror(const MirrorTurns& turns, LaneFrames& q) {
    const Lanes c = turns.cos_phi[1], s = turns.sin_phi[1], u = turns.cos_theta[1], w = turns.sin_theta[1];
    LaneVec3 &t = q.tangent, &b = q.bitangent, &n = q.normal;
    const LaneVec3 along{c * t.x + s * b.x, c * t.y + s * b.y, c * t.z + s * b.z};
    b = {c * b.x - s * t.x, c * b.y - s * t.y, c * b.z - s * t.z};
    t = {u * along.x - w * n.x, u * along.y - w * n.y, u * along.z - w * n.z};
    n = {w * along.x + u * n.x, w * along.y + u * n.y, w * along.z + u * n.z};
}

// Computes t of all channels in the mirror frame, and makes that the frame of the block.
inline void liveTransfer(const ShadeLive& live, int light_order, Block& block) {
    Lanes moments[kMaxOrder * kMaxOrder], turned[kMaxOrder * kMaxOrder];
    MirrorTurns turns;
    makeMirrorTurns(live.order, block.frames.view, turns);
    const int count = live.order * live.order;
    // 1. The moments of the visibility above the surface.
    for (int i = 0; i < count; ++i) moments[i] = kZeros + live.offset[i];
    addSparse(live.moment, live.moment_terms, block.v, moments);
    // 2. In the mirror frame, by Y(-theta) Z(-phi) = X(-90) Z(-theta) X(90) Z(-phi).
    turnBack(live.order, turns.cos_phi, turns.sin_phi, moments);
    clear(count, turned);
    addSparse(live.turn, live.turn_terms, moments, turned);
    turnBack(live.order, turns.cos_theta, turns.sin_theta, turned);
    clear(count, moments);
    addSparse(live.turn_back, live.turn_back_terms, turned, moments);
    // 3. Times the lobe.
    clear(light_order * light_order, block.t[0]);
    addSparse(live.matrix, live.matrix_terms, moments, block.t[0]);
    turnToMirror(turns, block.frames);
}

// Computes a - t_u as hiddenAlbedo() does. A sky that nothing hides is zonal: the turn by theta multiplies its band l
// by P_l(cos theta).
inline void liveHiddenAlbedo(const ShadeLive& live, Block& block) {
    constexpr float kRootFourPi = 3.54490770f;
    const Lanes& z = block.frames.view.z;
    Lanes cosine;
    choose(z < 0, -z, z, cosine);
    Lanes before = kZeros + 1, p = cosine, albedo = live.albedo[0] * before;
    for (int l = 1; l < live.order; ++l) {
        albedo += live.albedo[l] * p;
        const Lanes next = (float(2 * l + 1) * cosine * p - float(l) * before) / float(l + 1);
        before = p;
        p = next;
    }
    block.hidden[0] = albedo - kRootFourPi * block.t[0][0];
    raiseTo(0, block.hidden[0]);
}

}  // namespace

}  // namespace penumbra
