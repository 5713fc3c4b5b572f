#include "runtime/glsl/shading_glsl.h"

#include <numeric>

#include "runtime/glsl/sh_glsl.h"

namespace penumbra {

namespace {

// Returns the text of number i of a vertex, such as "numbers[2].w".
std::string numberGlsl(std::size_t i) { return "numbers[" + std::to_string(i / 4) + "]." + "xyzw"[i % 4]; }

std::string name(const char* prefix, std::size_t i) { return prefix + std::to_string(i); }

}  // namespace

// Writes E and clampAmbient() of sh/visibility_convention.h.
std::string ambientGlsl(const Convention& convention) {
    std::vector<float> weights(std::size_t(convention.size()));
    ambientWeights(convention, weights);
    const float norm2 = std::inner_product(weights.begin(), weights.end(), weights.begin(), 0.0f);
    std::string ambient = "float penumbra_ambient(vec4 numbers[PENUMBRA_STRIDE4]) {\n    return 0.0";
    std::string clamp =
        "void penumbra_clamp_ambient(inout vec4 numbers[PENUMBRA_STRIDE4]) {\n    float e = "
        "penumbra_ambient(numbers);\n"
        "    float excess = min(e, 0.0) + max(e - 1.0, 0.0);\n";
    for (std::size_t i = 0; i < weights.size(); ++i) {
        if (weights[i] == 0) continue;
        ambient += "\n        + " + glslFloat(weights[i]) + " * " + numberGlsl(i);
        clamp += "    " + numberGlsl(i) + " -= " + glslFloat(weights[i] / norm2) + " * excess;\n";
    }
    return ambient + ";\n}\n" + clamp + "}\n";
}

std::string sightGlsl(const Convention& convention) {
    const bool mirrored = convention.below == BelowHorizon::kMirrored;
    std::string sum;
    std::size_t number = 0;
    for (int l = 0; l < convention.order; ++l)
        for (int m = -l; m <= l; m += mirrored ? 2 : 1)
            sum += "\n        + y" + std::to_string(shIndex(l, m)) + " * " + numberGlsl(number++);
    return "float penumbra_sight(vec4 numbers[PENUMBRA_STRIDE4], vec3 direction) {\n" +
           basisGlsl(convention.order, mirrored ? BasisPart::kEven : BasisPart::kAll, "y", "direction") +
           "    return 0.0" + sum + ";\n}\n";
}

namespace {

// Gives the text of an entry of the material, whose texel is fetched into a variable before its first use.
class EntryReader {
public:
    // `has_steps`: some materials have their entries in the light's data.
    EntryReader(int channels, bool has_steps) : channels_(channels), has_steps_(has_steps) {}
    std::string entry(std::size_t i, std::string& declarations) {
        const std::size_t texel = channels_ == 3 ? i : i / 4;
        if (texel == fetched_) {
            const std::string at = std::to_string(texel);
            declarations += "    vec4 " + name("c", texel) + " = " +
                            (has_steps_ ? "penumbra_entry(material, stepped, " + at + ")"
                                        : "PENUMBRA_MATERIAL(material + " + std::to_string(texel + 1) + ")") +
                            ";\n";
            ++fetched_;
        }
        return name("c", texel) + (channels_ == 3 ? ".rgb" : std::string(".") + "xyzw"[i % 4]);
    }

private:
    int channels_;
    bool has_steps_;
    std::size_t fetched_ = 0;  // number of texels fetched, in order
};

// Writes f_k = sum over e of A_ke y_e, for every k that has an entry. `type` is float or vec3 (three colour
// channels).
std::string viewGlsl(const ShadingLayout& layout, const std::string& type, EntryReader& reader) {
    std::string text;
    for (std::size_t at = 0; at < layout.views.size();) {
        const std::uint16_t k = layout.views[at].k;
        std::string sum, fetches;
        for (; at < layout.views.size() && layout.views[at].k == k; ++at)
            sum += (sum.empty() ? "" : " + ") + reader.entry(at, fetches) + " * " + name("e", layout.views[at].e);
        text += fetches + "    " + type + " " + name("f", k) + " = " + sum + ";\n";
    }
    return text;
}

// Writes t_i = sum over j of v_j (sum over k of B_ijk f_k). The inner sum of (i, j) serves (j, i) too.
std::string productGlsl(const ShadingLayout& layout, const std::string& type, EntryReader& reader) {
    const ProductRows grouped = groupRows(layout.convention, layout.products);
    const bool slices = layout.choice.reflectance == Reflectance::kSlices;
    std::string text, fetches;
    if (!slices)  // in the order of the entries, since a reader only goes forward
        for (std::size_t p = 0; p < layout.products.size(); ++p) reader.entry(layout.views.size() + p, fetches);
    text += fetches + "    " + type + " s;\n";
    for (std::size_t r = 0; r < grouped.rows.size(); ++r) {
        const ProductRow& row = grouped.rows[r];
        std::string sum;
        for (std::size_t p = grouped.first[r]; p < grouped.first[r] + row.terms; ++p) {
            const ProductEntry& entry = layout.products[p];
            sum += (sum.empty() ? "" : " + ") +
                   (slices ? glslFloat(entry.value) : reader.entry(layout.views.size() + p, fetches)) + " * " +
                   name("f", entry.k);
        }
        text += "    s = " + sum + ";\n";
        if (layout.bounces && row.i == 0 && row.j == 0) text += "    albedo = " + type + "(12.566370614) * s;\n";
        text += "    " + name("t", row.i) + " += " + numberGlsl(row.j) + " * s;\n";
        if (r < grouped.mirrored)
            text += "    " + name("t", row.mirror_i) + " += " + numberGlsl(row.mirror_j) + " * s;\n";
    }
    return text;
}

// Writes L = sum over lobes d and bands l of w_dl sum over m of y_lm(Q s_d) t_lm (exact_light_lobes.h).
std::string lobesGlsl(const ShadingLayout& layout) {
    const int order = layout.light_order;
    std::string text =
        "    for (int d = 0; d < int(PENUMBRA_LIGHT(0).x); ++d) {\n    vec3 s = local_from_model * PENUMBRA_LIGHT(1 + "
        "d).xyz;\n" +
        basisGlsl(order, BasisPart::kAll, "y", "s");
    for (int band = 0; band < order; ++band) {
        text += "    radiance += PENUMBRA_LIGHT(" + std::to_string(1 + layout.lobe_count + band) + " + " +
                std::to_string(order) + " * d).rgb * (";
        for (int i = band * band; i < (band + 1) * (band + 1); ++i)
            text += (i == band * band ? "" : " + ") + name("y", std::size_t(i)) + " * " + name("t", std::size_t(i));
        text += ");\n";
    }
    return text + "    }\n";
}

// Writes t = R(Z(-angle)) t, as turnBack() of shade_lanes.cpp does it.
std::string turnBackGlsl(int order, const std::string& angle, const char* t) {
    std::string text;
    for (int l = 1; l < order; ++l)
        for (int m = 1; m <= l; ++m) {
            const std::string c = "cos_" + angle + std::to_string(m), s = "sin_" + angle + std::to_string(m);
            const std::string plus = name(t, std::size_t(shIndex(l, m))), minus = name(t, std::size_t(shIndex(l, -m)));
            text += "    turned = " + c + " * " + plus + " + " + s + " * " + minus + ";\n    " + minus + " = " + c +
                    " * " + minus + " - " + s + " * " + plus + ";\n    " + plus + " = turned;\n";
        }
    return text;
}

std::string multiplesGlsl(int order, const std::string& angle) {
    const std::string c = "cos_" + angle, s = "sin_" + angle;
    std::string text;
    for (int m = 2; m < order; ++m) {
        const std::string before = std::to_string(m - 1), now = std::to_string(m);
        text += "    float " + c + now + " = " + c + before + " * " + c + "1 - " + s + before + " * " + s + "1, " + s +
                now + " = " + s + before + " * " + c + "1 + " + c + before + " * " + s + "1;\n";
    }
    return text;
}

// Writes out = R(X(90)) in, or its transpose.
std::string quarterTurnGlsl(int order, const std::string& type, bool transposed, const char* in, const char* out) {
    std::vector<std::string> sums(std::size_t(coefficientCount(order)));
    for (const TurnTerm& term : quarterTurn(order)) {
        std::string& sum = sums[transposed ? term.from : term.to];
        sum += (sum.empty() ? "" : " + ") + glslFloat(term.value) + " * " + name(in, transposed ? term.to : term.from);
    }
    std::string text;
    for (std::size_t i = 0; i < sums.size(); ++i) text += "    " + type + " " + name(out, i) + " = " + sums[i] + ";\n";
    return text;
}

// Writes L = l . Z(-c) X(-90) Z(-b) X(90) Z(-a) t, Q = Z(a) Y(b) Z(c), as makeTurns() and lightByRotation() of
// shade_lanes.cpp compute it.
std::string rotationGlsl(const ShadingLayout& layout, const std::string& type) {
    const int order = layout.light_order;
    std::string text;
    if (order > 1)
        text = R"(    mat3 q = transpose(local_from_model);  // q[0]: what the tangent row of Q has
    float square = q[0].z * q[0].z + q[1].z * q[1].z;
    float scale = square > 1e-30 ? inversesqrt(square) : 0.0;
    float cos_a1 = square > 1e-30 ? q[0].z * scale : 1.0, sin_a1 = q[1].z * scale;
    float cos_b1 = q[2].z, sin_b1 = cos_a1 * q[0].z + sin_a1 * q[1].z;
    float cos_c1 = cos_a1 * q[1].y - sin_a1 * q[0].y, sin_c1 = cos_a1 * q[1].x - sin_a1 * q[0].x;
)";
    for (const char* angle : {"a", "b", "c"}) text += multiplesGlsl(order, angle);
    text += "    " + type + " turned;\n" + turnBackGlsl(order, "a", "t") +
            quarterTurnGlsl(order, type, false, "t", "u") + turnBackGlsl(order, "b", "u") +
            quarterTurnGlsl(order, type, true, "u", "w") + turnBackGlsl(order, "c", "w");
    for (int i = 0; i < coefficientCount(order); ++i)
        text +=
            "    radiance += PENUMBRA_LIGHT(" + std::to_string(1 + i) + ").rgb * " + name("w", std::size_t(i)) + ";\n";
    return text;
}

}  // namespace

namespace {

// Writes out = sum over the terms of value in, for every `to` that has a term; `value` gives the text of a term's.
template <class Value>
std::string sparseGlsl(std::span<const SparseTerm> terms, const char* in, const char* out, const Value& value) {
    std::vector<std::string> sums(coefficientCount(kMaxOrder));
    for (std::size_t e = 0; e < terms.size(); ++e) {
        std::string& sum = sums[terms[e].to];
        sum +=
            (sum.empty() ? "" : " + ") + value(e) + " * " + (*in ? name(in, terms[e].from) : numberGlsl(terms[e].from));
    }
    std::string text;
    for (std::size_t i = 0; i < sums.size(); ++i)
        if (!sums[i].empty()) text += "        " + name(out, i) + " = " + sums[i] + ";\n";
    return text;
}

std::string declaredGlsl(const char* type, const char* prefix, int order) {
    std::string text;
    for (int i = 0; i < coefficientCount(order); ++i)
        text += std::string("    ") + type + " " + name(prefix, std::size_t(i)) + " = " + type + "(0.0);\n";
    return text;
}

// Writes the albedo of a live material towards the eye, as liveHiddenAlbedo() of shade_live_lanes.h has it.
std::string liveAlbedoGlsl(const MomentForm& form, const std::string& type) {
    std::string text = "    float legendre0 = 1.0, legendre1 = cos_q1;\n", sum;
    for (int l = 2; l < form.order; ++l)
        text += "    float " + name("legendre", std::size_t(l)) + " = " + glslFloat((2 * l - 1) / double(l)) +
                " * cos_q1 * " + name("legendre", std::size_t(l - 1)) + " - " + glslFloat((l - 1) / double(l)) + " * " +
                name("legendre", std::size_t(l - 2)) + ";\n";
    for (std::size_t l = 0; l < form.sky.size(); ++l)
        sum += (l == 0 ? "" : " + ") + glslFloat(double(form.sky[l])) + " * " + name("m", l / 4) + "." + "xyzw"[l % 4] +
               " * " + name("legendre", l);
    return text + "    albedo = " + type + "(" + sum + ");\n";
}

// Writes t of a live material, and turns local_from_model into the mirror frame, as liveTransfer() of
// shade_live_lanes.h does it.
std::string liveGlsl(const ShadingLayout& layout, const std::string& type) {
    const MomentForm form = momentForm(layout.convention);
    const int order = form.order;
    const MirrorLobeSum sum(layout.light_order, order);
    std::vector<SparseTerm> matrix;
    for (const auto& [i, j] : sum.entries()) matrix.push_back({i, j, 0});
    std::string text = "        int live = " + std::to_string(layout.firstLiveTexel()) + " + (int(looks.w) - 1) * " +
                       std::to_string(layout.liveTexels()) + ";\n" + declaredGlsl("float", "b", order) +
                       sparseGlsl(form.terms, "", "b", [&](std::size_t e) { return glslFloat(form.terms[e].value); });
    for (std::size_t i = 0; i < form.offset.size(); ++i)
        if (form.offset[i] != 0) text += "    " + name("b", i) + " += " + glslFloat(form.offset[i]) + ";\n";
    text += R"(    vec3 r = vec3(-to_eye.xy, abs(to_eye.z));
    float across = r.x * r.x + r.y * r.y, scale = across > 1e-30 ? inversesqrt(across) : 0.0;
    float cos_p1 = across > 1e-30 ? r.x * scale : 1.0, sin_p1 = r.y * scale, cos_q1 = r.z, sin_q1 = sqrt(across);
)";
    text += multiplesGlsl(order, "p") + multiplesGlsl(order, "q") + "    float turned;\n" +
            turnBackGlsl(order, "p", "b") + quarterTurnGlsl(order, "float", false, "b", "d") +
            turnBackGlsl(order, "q", "d") + quarterTurnGlsl(order, "float", true, "d", "g");
    for (std::size_t texel = 0; texel < layout.liveTexels(); ++texel)
        text += "    vec4 " + name("m", texel) + " = PENUMBRA_LIGHT(live + " + std::to_string(texel) + ");\n";
    text += sparseGlsl(matrix, "g", "t", [&](std::size_t e) {
        return (type == "float" ? "" : type + "(1.0) * ") + name("m", e / 4) + "." + "xyzw"[e % 4];
    });
    if (layout.bounces) text += liveAlbedoGlsl(form, type);
    return text + R"(    local_from_model = mat3(cos_q1 * cos_p1, -sin_p1, sin_q1 * cos_p1, cos_q1 * sin_p1, cos_p1,
                            sin_q1 * sin_p1, -sin_q1, 0.0, cos_q1) * local_from_model;
)";
}

// Writes what joins the sides of a membrane (ShadingSet::shadeMembrane()).
std::string membraneGlsl(const ShadingLayout& layout) {
    const std::string texels = std::to_string(layout.materialTexels());
    const auto texel = [&](int from_end) {
        return "PENUMBRA_MATERIAL(material * " + texels + " + " +
               std::to_string(int(layout.materialTexels()) - from_end) + ")";
    };
    std::string text = "bool penumbra_is_membrane(int material) { return " + texel(2) +
                       ".w > 0.0; }\nvoid penumbra_other_side(int material, inout vec4 numbers[PENUMBRA_STRIDE4]) {\n"
                       "    if (" +
                       texel(2) + ".w < 1.5) return;\n";
    const std::vector<float> free_sight = freeSight(layout.convention);
    for (std::size_t i = 0; i < free_sight.size(); ++i)
        text += "    " + numberGlsl(i) + " = " + glslFloat(double(free_sight[i])) + ";\n";
    return text + "}\nvec3 penumbra_join_sides(int material, vec3 own, vec3 other) {\n    return " + texel(2) +
           ".rgb * own + " + texel(1) + ".rgb * other;\n}\n";
}

// Writes the light that bounces to a vertex, before its material: turnIndirect() and addBounced() of shade_lanes.cpp.
std::string bouncedGlsl(const ShadingLayout& layout) {
    const auto light = [&](std::size_t i) {
        return "PENUMBRA_LIGHT(" + std::to_string(layout.directTexels() + i) + ").rgb";
    };
    const char* const factors[kBouncedLight] = {"n[0].x",  "v.x",     "v.y",     "v.z",     "m[0][0]", "m[1][1]",
                                                "m[2][2]", "m[1][0]", "m[2][0]", "m[2][1]", "n[2].y",  "n[2].z"};
    std::string text = R"(
// Returns the light that reaches a vertex from other surfaces. n: its indirect numbers, 12 with one that is not read.
vec3 penumbra_bounced(vec4 n[3], mat3 local_from_model) {
    vec3 v = vec3(-n[0].w, -n[0].y, n[0].z) * local_from_model;
    float xy = 0.546274215 * n[1].x, yz = -0.546274215 * n[1].y, xz = -0.546274215 * n[1].w;
    float square = 0.546274215 * n[2].x, height = 0.315391565 * n[1].z;
    mat3 m = mat3(square - height, xy, xz, xy, -square - height, yz, xz, yz, 2.0 * height);
    m = transpose(local_from_model) * m * local_from_model;
    return max(vec3(0.0))";
    for (std::size_t i = 0; i < kBouncedLight; ++i) text += std::string("\n        + ") + factors[i] + " * " + light(i);
    return text + ", vec3(0.0));\n}\n";
}

// Reads texel i of a material's entries; those of a material with steps begin at `stepped` in the light's data.
constexpr const char* kEntryGlsl = R"(vec4 penumbra_entry(int material, int stepped, int i) {
    if (stepped < 0) return PENUMBRA_MATERIAL(material + 1 + i);
    return PENUMBRA_LIGHT(stepped + i);
}
)";

std::string steppedGlsl(const ShadingLayout& layout) {
    return "    int stepped = looks.w < 0.0 ? " + std::to_string(layout.firstSteppedTexel()) +
           " + (int(-looks.w) - 1) * " + std::to_string(layout.entryTexels()) + " : -1;\n";
}

// Writes what a surface adds to the light that it reflects. The material's number is that of its first texel here.
std::string emissionGlsl(const ShadingLayout& layout) {
    if (!layout.emission) return "";
    return " + PENUMBRA_MATERIAL(material + " + std::to_string(layout.emissionTexel()) + ").rgb";
}

}  // namespace

std::string shadingGlsl(const ShadingLayout& layout) {
    const std::string type = layout.channels == 3 ? "vec3" : "float";
    EntryReader reader(layout.channels, layout.stepped_count > 0);
    // before the products, because entries are fetched in order
    const std::string views = viewGlsl(layout, type, reader);
    const std::string products = productGlsl(layout, type, reader);
    const bool rotation = layout.choice.light_form == LightForm::kRotation;
    // Where every material is live, there is no table to read.
    const std::string table = basisGlsl(layout.view_order, BasisPart::kEven, "e", "to_eye") + views + products,
                      transfer = layout.live_count == 0 ? table
                                 : layout.views.empty() ? "    {\n" + liveGlsl(layout, type) + "    }\n"
                                                        : "    if (looks.w > 0.0) {\n" + liveGlsl(layout, type) +
                                                              "    } else {\n" + table + "    }\n";
    const std::string arguments = "vec3 to_eye, mat3 local_from_model, int material) {\n",
                      body = "    material *= " + std::to_string(layout.materialTexels()) +
                             ";\n    vec4 looks = PENUMBRA_MATERIAL(material);\n" +
                             (layout.stepped_count > 0 ? steppedGlsl(layout) : "") +
                             declaredGlsl(type.c_str(), "t", layout.light_order) + transfer +
                             "    vec3 radiance = vec3(0.0);\n" +
                             (rotation ? rotationGlsl(layout, type) : lobesGlsl(layout)),
                      end = "    return looks.rgb * radiance" + emissionGlsl(layout) + ";\n}\n",
                      functions =
                          (layout.membranes ? membraneGlsl(layout) : "") + (layout.stepped_count > 0 ? kEntryGlsl : "");
    if (!layout.bounces)
        return functions + "vec3 penumbra_shade(vec4 numbers[PENUMBRA_STRIDE4], " + arguments + body + end;
    return functions + bouncedGlsl(layout) +
           "vec3 penumbra_shade_bounced(vec4 numbers[PENUMBRA_STRIDE4], vec4 indirect[3], " + arguments + "    " +
           type + " albedo = " + type + "(0.0);\n    mat3 local_frame = local_from_model;\n" + body +
           "    vec3 hidden = max(vec3(albedo) - 3.54490770 * vec3(t0), vec3(0.0));\n"
           "    radiance *= 1.0 - PENUMBRA_LIGHT(" +
           std::to_string(layout.directTexels() + kBouncedLight) +
           ").x;\n    radiance += penumbra_bounced(indirect, local_frame) * hidden / (3.14159265 * max(1.0 - "
           "penumbra_ambient(numbers), 0.01));\n" +
           end +
           "vec3 penumbra_shade(vec4 numbers[PENUMBRA_STRIDE4], vec3 to_eye, mat3 local_from_model, int material) {\n"
           "    vec4 none[3] = vec4[3](vec4(0.0), vec4(0.0), vec4(0.0));\n"
           "    return penumbra_shade_bounced(numbers, none, to_eye, local_from_model, material);\n}\n";
}

}  // namespace penumbra
