#include "runtime/glsl/far_glsl.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>
#include <cstring>
#include <map>
#include <numbers>

#include "runtime/glsl/sh_glsl.h"
#include "runtime_shaders.h"

namespace penumbra {

namespace {

constexpr int kOrder = kFieldOrder, kFull = kOrder * kOrder;

std::uint32_t bits(float x) { return std::bit_cast<std::uint32_t>(x); }

void addFloats(std::vector<std::uint32_t>& words, const float* values, std::size_t count) {
    for (std::size_t i = 0; i < count; ++i) words.push_back(bits(values[i]));
}

void addBox(std::vector<std::uint32_t>& words, const FarBox& box) {
    for (const float* three : {box.low, box.high, box.per_cell, box.cells}) addFloats(words, three, 3);
    words.push_back(bits(box.per_width));
    for (const std::int32_t whole : {box.stride[1], box.stride[2], box.first}) words.push_back(std::uint32_t(whole));
}

// Places in a part's words.
constexpr std::size_t kPlaceOfPoints = 2 * 16 + 6, kPlaceOfScales = kPlaceOfPoints + 3;
static_assert(kPlaceOfScales + 3 * kOrder <= kFarPartWords);

void addPart(std::vector<std::uint32_t>& words, const FarTable& table) {
    const std::size_t first = words.size();
    for (const FarBox& box : table.boxes) addBox(words, box);
    addFloats(words, table.center, 3);
    words.push_back(bits(table.radius));
    words.push_back(bits(table.per_fade));
    words.push_back(std::uint32_t(table.first_sphere));
    words.insert(words.end(), 2, 0);  // the points and the distances
    words.push_back(bits(table.scale[0][kFull]));
    for (const auto& scale : table.scale)
        for (int l = 0; l < kOrder; ++l) words.push_back(bits(scale[l * l]));
    words.resize(first + kFarPartWords);
}

// Gives every vertex that is an anchor a place for its values.
class AnchorPlaces {
public:
    AnchorPlaces(const FarTables& tables, FarWords& words) : tables_(tables), words_(words) {}
    std::uint32_t of(std::uint32_t vertex, std::size_t part) {
        const auto [found, is_new] = place_of_vertex_.try_emplace(vertex, std::uint32_t(words_.anchor_values));
        if (is_new) {
            words_.anchors.insert(words_.anchors.end(), {vertex, found->second});
            words_.anchor_values += kFarAnchorSums + (tables_.partsSeenBy(part).size() + 3) / 4;
        }
        return found->second;
    }

private:
    const FarTables& tables_;
    FarWords& words_;
    std::map<std::uint32_t, std::uint32_t> place_of_vertex_;
};

}  // namespace

FarWords makeFarWords(const FarTables& tables, const FarLayout& layout) {
    FarWords words;
    for (std::size_t p = 0; p < tables.partCount(); ++p) addPart(words.parts, tables.tables()[p]);
    // 1. The parts that each part sees.
    std::uint32_t first = 0;
    for (std::size_t p = 0; p < tables.partCount(); ++p) {
        words.lists.push_back(first);
        first += std::uint32_t(tables.partsSeenBy(p).size());
    }
    words.lists.push_back(first);
    for (std::size_t p = 0; p < tables.partCount(); ++p)
        for (const std::uint16_t part : tables.partsSeenBy(p)) words.lists.push_back(part);
    // 2. Anchors, and what each vertex takes from them.
    AnchorPlaces places(tables, words);
    words.receivers.resize(layout.receivers.size() * 2 * kAnchorsOfReceiver, kNoAnchor);
    for (const FarRun& run : layout.runs) {
        if (run.anchor_count == 0) continue;
        for (std::uint32_t r = run.first; r < run.first + run.count; ++r) {
            std::uint32_t* const row = words.receivers.data() + layout.receivers[r] * 2 * kAnchorsOfReceiver;
            for (std::size_t a = 0; a < kAnchorsOfReceiver; ++a) {
                const std::size_t at = r * kAnchorsOfReceiver + a;
                row[a] = places.of(layout.anchors[run.first_anchor + layout.anchor[at]], run.part);
                row[kAnchorsOfReceiver + a] = bits(layout.weight[at]);
            }
        }
    }
    return words;
}

void setFieldWords(FarWords& words, std::size_t part, std::uint32_t points, std::uint32_t distances) {
    std::uint32_t* const at = words.parts.data() + part * kFarPartWords + kPlaceOfPoints;
    at[0] = points;
    at[1] = distances;
}

namespace {

constexpr std::size_t inQuads(std::size_t bytes) { return (bytes + 15) / 16 * 4; }  // words

}  // namespace

std::size_t fieldBlockWords(const CompositionView& composition) {
    std::size_t words = composition.parts.size() * kFarPartWords;
    for (const PartFieldView& part : composition.parts)
        words += inQuads(part.bytes.values.size()) + inQuads(part.bytes.distances.size());
    return words;
}

void writeFieldBlock(const FarTables& tables, const CompositionView& composition, std::uint32_t first_word,
                     std::span<std::uint32_t> out) {
    assert(out.size() == fieldBlockWords(composition) && first_word % 4 == 0);
    std::ranges::fill(out, 0u);
    FarWords words;
    for (std::size_t p = 0; p < tables.partCount(); ++p) addPart(words.parts, tables.tables()[p]);
    std::size_t at = words.parts.size();
    const auto place = [&](std::span<const std::int8_t> bytes) {
        std::memcpy(out.data() + at, bytes.data(), bytes.size());
        const auto begin = std::uint32_t(first_word + at);
        at += inQuads(bytes.size());
        return begin;
    };
    for (std::size_t p = 0; p < tables.partCount(); ++p) {
        const FieldBytes& bytes = composition.parts[p].bytes;
        const std::uint32_t points = place(bytes.values);
        setFieldWords(words, p, points, place(bytes.distances));
    }
    std::ranges::copy(words.parts, out.begin());
}

void writePosedPart(const PosedPart& part, const Affine& placement, std::uint32_t first_word, float* rows) {
    const Mat3 turn = placement.linear(), back = transposed(turn), into = part.to_part.linear() * back;
    const Vec3 moved = part.to_part.point(back * -placement.translation()), center = placement.point(part.center);
    const Mat3 out_of = turn * part.turn;
    for (std::size_t i = 0; i < 3; ++i) {
        rows = std::copy_n(into.m.data() + 3 * i, 3, rows);
        *rows++ = moved[int(i)];
    }
    for (std::size_t i = 0; i < 3; ++i) {
        rows = std::copy_n(out_of.m.data() + 3 * i, 3, rows);
        *rows++ = i == 0 ? float(first_word / 4) : 0;
    }
    for (const float x : {center.x, center.y, center.z, part.radius}) *rows++ = x;
}

// --- GLSL ------------------------------------------------------------------------------------------------------------

namespace {

std::string element(const char* array, int i) { return std::string(array) + "[" + std::to_string(i) + "]"; }

// Adds "value * what" to a sum, or begins it.
void addTerm(std::string& sum, double value, const std::string& what) {
    sum += (sum.empty() ? "" : " + ") + glslFloat(value) + " * " + what;
}

// Writes f = R(Z(angle)) f, as turn() of far_turns.h.
std::string turnAboutZ(const char* angle, const char* f) {
    std::string text;
    for (int l = 1; l < kOrder; ++l)
        for (int m = 1; m <= l; ++m) {
            const std::string c = "cos_" + std::string(angle) + "[" + std::to_string(m) + "]",
                              s = "sin_" + std::string(angle) + "[" + std::to_string(m) + "]",
                              plus = element(f, shIndex(l, m)), minus = element(f, shIndex(l, -m));
            text += "    turned = " + c + " * " + plus + " - " + s + " * " + minus + ";\n    " + minus + " = " + c +
                    " * " + minus + " + " + s + " * " + plus + ";\n    " + plus + " = turned;\n";
        }
    return text;
}

// Writes to = R(X(90)) from, or its transpose.
std::string quarterTurnText(const FarConstants& constants, bool back, const char* from, const char* to) {
    std::string text;
    const float* block = constants.quarter_turn;
    for (int l = 0; l < kOrder; ++l) {
        const int size = 2 * l + 1;
        for (int i = 0; i < size; ++i) {
            std::string sum;
            for (int j = 0; j < size; ++j) {
                const double value = double(back ? block[j * size + i] : block[i * size + j]);
                if (std::abs(value) > 1e-6) addTerm(sum, value, element(from, l * l + j));
            }
            text += "    " + element(to, l * l + i) + " = " + (sum.empty() ? "0.0" : sum) + ";\n";
        }
        block += size * size;
    }
    return text;
}

std::string turnGlsl(const FarConstants& constants) {
    return R"(// Turns penumbra_f into the frame whose axes are the rows: R(Q) f, Q = Z(a) Y(b) Z(c) (far_turns.h).
void penumbra_far_turn(vec3 row0, vec3 row1, vec3 row2) {
    float cos_a[6], sin_a[6], cos_b[6], sin_b[6], cos_c[6], sin_c[6], g[36], turned;
    float square = row0.z * row0.z + row1.z * row1.z, scale = square > 1e-30 ? 1.0 / sqrt(square) : 0.0;
    cos_a[1] = square > 1e-30 ? row0.z * scale : 1.0;
    sin_a[1] = row1.z * scale;
    cos_b[1] = row2.z;
    sin_b[1] = cos_a[1] * row0.z + sin_a[1] * row1.z;
    cos_c[1] = cos_a[1] * row1.y - sin_a[1] * row0.y;
    sin_c[1] = cos_a[1] * row1.x - sin_a[1] * row0.x;
    for (int m = 2; m < 6; ++m) {
        cos_a[m] = cos_a[m - 1] * cos_a[1] - sin_a[m - 1] * sin_a[1];
        sin_a[m] = sin_a[m - 1] * cos_a[1] + cos_a[m - 1] * sin_a[1];
        cos_b[m] = cos_b[m - 1] * cos_b[1] - sin_b[m - 1] * sin_b[1];
        sin_b[m] = sin_b[m - 1] * cos_b[1] + cos_b[m - 1] * sin_b[1];
        cos_c[m] = cos_c[m - 1] * cos_c[1] - sin_c[m - 1] * sin_c[1];
        sin_c[m] = sin_c[m - 1] * cos_c[1] + cos_c[m - 1] * sin_c[1];
    }
)" + turnAboutZ("c", "penumbra_f") +
           quarterTurnText(constants, false, "penumbra_f", "g") + turnAboutZ("b", "g") +
           quarterTurnText(constants, true, "g", "penumbra_f") + turnAboutZ("a", "penumbra_f") + "}\n";
}

std::string mirrorGlsl(const FarConstants& constants) {
    std::string text =
        "// Mirrors penumbra_f at the horizon into penumbra_even, with these weights for all of it and for its even\n"
        "// coefficients alone.\nvoid penumbra_far_mirror(float by_bands, float by_height) {\n";
    int place = 0;
    for (int l = 0; l < kOrder; ++l)
        for (int m = -l; m <= l; m += 2, ++place) {
            std::string odd;
            for (int from = std::abs(m) + 1; from < kOrder; from += 2)
                addTerm(odd, double(constants.mirror[place][from]), element("penumbra_f", shIndex(from, m)));
            const std::string even = element("penumbra_f", shIndex(l, m));
            text += "    " + element("penumbra_even", place) + " = (by_bands + by_height) * " + even +
                    (odd.empty() ? "" : " + by_bands * (" + odd + ")") + ";\n";
        }
    return text + "}\n";
}

int evenPlace(int l, int m) { return l * (l + 1) / 2 + (m + l) / 2; }

// Writes the values of penumbra_even at the 16 directions of a ring, toGrid() of far_grid.h, into `ring`.
std::string ringValues(const float* ring) {
    std::string text;
    for (int m = 1 - kOrder; m < kOrder; ++m) {
        std::string sum;
        for (int l = std::abs(m); l < kOrder; l += 2)
            addTerm(sum, double(ring[evenPlace(l, m)]), element("penumbra_even", evenPlace(l, m)));
        text += "    " + element(m < 0 ? "s" : "c", std::abs(m)) + " = " + sum + ";\n";
    }
    return text + R"(    penumbra_far_around(c, s, ring);
)";
}

// The other way, fromGrid() of far_grid.h: adds what the ring has of each function to penumbra_even.
std::string ringSums(const float* ring_back) {
    std::string text = "    penumbra_far_from_around(ring, c, s);\n";
    for (int m = 1 - kOrder; m < kOrder; ++m)
        for (int l = std::abs(m); l < kOrder; l += 2) {
            const int e = evenPlace(l, m);
            text += "    " + element("penumbra_even", e) + " += " + glslFloat(double(ring_back[e])) + " * " +
                    element(m < 0 ? "s" : "c", std::abs(m)) + ";\n";
        }
    return text;
}

constexpr const char* kAround = R"(// The sum over m of c[m] cos(m phi) + s[m] sin(m phi) at phi = pi q / 8.
void penumbra_far_around(float c[6], float s[6], out float ring[16]) {
    const float cos1 = 0.92387953, cos2 = 0.70710678, cos3 = 0.38268343;
    float same[4] = float[4](c[0] + c[4], c[0] + s[4], c[0] - c[4], c[0] - s[4]);
    float over[4] = float[4](c[2], cos2 * (c[2] + s[2]), s[2], cos2 * (s[2] - c[2]));
    float cosine[4] = float[4](c[1] + c[3] + c[5], cos1 * c[1] + cos3 * c[3] - cos3 * c[5],
                               cos2 * (c[1] - c[3] - c[5]), cos3 * c[1] - cos1 * c[3] + cos1 * c[5]);
    float sine[5] = float[5](0.0, cos3 * s[1] + cos1 * s[3] + cos1 * s[5], cos2 * (s[1] + s[3] - s[5]),
                             cos1 * s[1] - cos3 * s[3] - cos3 * s[5], s[1] - s[3] + s[5]);
    float even[8], odd[8];
    odd[0] = cosine[0];
    odd[4] = sine[4];
    for (int q = 0; q < 4; ++q) {
        even[q] = same[q] + over[q];
        even[q + 4] = same[q] - over[q];
    }
    for (int q = 1; q < 4; ++q) {
        odd[q] = sine[q] + cosine[q];
        odd[8 - q] = sine[q] - cosine[q];
    }
    for (int q = 0; q < 8; ++q) {
        ring[q] = even[q] + odd[q];
        ring[q + 8] = even[q] - odd[q];
    }
}

// The transpose of that.
void penumbra_far_from_around(float ring[16], out float c[6], out float s[6]) {
    const float cos1 = 0.92387953, cos2 = 0.70710678, cos3 = 0.38268343;
    float even[8], odd[8], same[4], over[4], cosine[4], sine[4];
    for (int q = 0; q < 8; ++q) {
        even[q] = ring[q] + ring[q + 8];
        odd[q] = ring[q] - ring[q + 8];
    }
    for (int q = 0; q < 4; ++q) {
        same[q] = even[q] + even[q + 4];
        over[q] = even[q] - even[q + 4];
    }
    for (int q = 1; q < 4; ++q) {
        cosine[q] = odd[q] - odd[8 - q];
        sine[q] = odd[q] + odd[8 - q];
    }
    c[0] = (same[0] + same[2]) + (same[1] + same[3]);
    c[4] = same[0] - same[2];
    s[0] = 0.0;
    s[4] = same[1] - same[3];
    c[2] = over[0] + cos2 * (over[1] - over[3]);
    s[2] = over[2] + cos2 * (over[1] + over[3]);
    float c2 = cos2 * cosine[2], s2 = cos2 * sine[2];
    c[1] = odd[0] + cos1 * cosine[1] + c2 + cos3 * cosine[3];
    c[3] = odd[0] + cos3 * cosine[1] - c2 - cos1 * cosine[3];
    c[5] = odd[0] - cos3 * cosine[1] - c2 + cos1 * cosine[3];
    s[1] = odd[4] + cos3 * sine[1] + s2 + cos1 * sine[3];
    s[3] = cos1 * sine[1] + s2 - cos3 * sine[3] - odd[4];
    s[5] = cos1 * sine[1] - s2 - cos3 * sine[3] + odd[4];
}
)";

std::string valuesGlsl(const FarConstants& constants) {
    std::string
        to = "// Writes the values of penumbra_even at the 64 directions.\n"
             "void penumbra_far_values(out float values[64]) {\n    float c[6], s[6], ring[16];\n    s[0] = 0.0;\n",
        from =
            "// Sets penumbra_even to the function that has these values at the directions.\n"
            "void penumbra_far_from_values(float values[64]) {\n    float c[6], s[6], ring[16];\n"
            "    for (int i = 0; i < 21; ++i) penumbra_even[i] = 0.0;\n";
    for (int k = 0; k < 4; ++k) {
        const std::string first = std::to_string(16 * k);
        to += ringValues(constants.grid.ring[k]) + "    for (int q = 0; q < 16; ++q) values[" + first +
              " + q] = ring[q];\n";
        from += "    for (int q = 0; q < 16; ++q) ring[q] = values[" + first + " + q];\n" +
                ringSums(constants.grid.ring_back[k]);
    }
    return kAround + to + "}\n" + from + "}\n";
}

std::string constantGlsl(const char* name, float value) {
    return std::string("const float penumbra_") + name + " = " + glslFloat(double(value)) + ";\n";
}

std::string fieldConstantsGlsl(const FarConstants& constants) {
    std::string text = "float penumbra_f[36], penumbra_even[21];\n" +
                       constantGlsl("root_of_sphere", 2 * std::sqrt(std::numbers::pi_v<float>)) +
                       constantGlsl("blocked_from", constants.blocked[0]) +
                       constantGlsl("blocked_full", constants.blocked[1]) + constantGlsl("dark", constants.dark) +
                       constantGlsl("overlap", constants.overlap) + constantGlsl("solid", constants.solid) +
                       "const float penumbra_sphere_scales[4] = float[4](";
    for (std::size_t i = 0; i < kMaxSpheres; ++i)
        text += (i > 0 ? ", " : "") + glslFloat(double(constants.sphere_scales[i]));
    return text + ");\n";
}

}  // namespace

std::string fieldGlsl(const FarConstants& constants) {
    return fieldConstantsGlsl(constants) + turnGlsl(constants) + mirrorGlsl(constants) + valuesGlsl(constants);
}

namespace {

std::string anchorConstantsGlsl(const FarConstants& constants) {
    return constantGlsl("near_from", constants.near[0]) + constantGlsl("near_full", constants.near[1]) +
           constantGlsl("depth", constants.depth);
}

const FarConstants& castConstants() {
    static const FarTables none({}, {}, kFieldOrder);  // has the constants of all
    return none.constants(FarQuality::kCast);
}

}  // namespace

std::string farGlsl(const FarConstants& constants) {
    return anchorConstantsGlsl(constants) + fieldGlsl(constants) + kShaderFieldGlsl;
}

std::string castFieldsGlsl() {
    const FarConstants& constants = castConstants();
    return constantGlsl("most", constants.most) + fieldGlsl(constants) + kShaderFieldGlsl + kShaderCastFieldsGlsl;
}

std::string castAnchorsGlsl(CasterKinds kinds) {
    const FarConstants& constants = castConstants();
    return kinds.parts ? anchorConstantsGlsl(constants) : "float penumbra_f[36];\n" + turnGlsl(constants);
}

}  // namespace penumbra
