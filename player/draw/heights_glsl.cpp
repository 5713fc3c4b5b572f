// Writes how V of a point of a height field turns into its own frame and is mirrored there.
//
// Problem: this is a turn about z, a sparse matrix, a turn, another sparse matrix and a turn, at every point of a
// field.
//
// Naive: the entries of both matrices in a table, which every point reads and whose places are no constants.
//
// Here: every entry is a line of the shader, so that all numbers stay in registers. Turns about z are pairs of numbers.
#include "player/draw/heights_glsl.h"

#include <bit>

#include "player_shaders.h"
#include "runtime/glsl/sh_glsl.h"

namespace penumbra {

namespace {

std::string element(const char* array, std::size_t i) { return std::string(array) + "[" + std::to_string(i) + "]"; }

// Declares by1, by2, ...: the turn `name` taken m times.
std::string turnsGlsl(const char* by, const std::string& once, int order) {
    std::string text = "    vec2 " + std::string(by) + "1 = " + once + ";\n";
    for (int m = 2; m < order; ++m)
        text += "    vec2 " + std::string(by) + std::to_string(m) + " = turnedTwice(" + by + std::to_string(m - 1) +
                ", " + by + "1);\n";
    return text;
}

std::string turnGlsl(const char* array, std::size_t plus, std::size_t minus, const char* by, int m) {
    return "    turn(" + element(array, plus) + ", " + element(array, minus) + ", " + by + std::to_string(m) + ");\n";
}

std::string turnAllGlsl(const char* array, const char* by, int order) {
    std::string text;
    for (int m = 1; m < order; ++m)
        for (int l = m; l < order; ++l)
            text += turnGlsl(array, std::size_t(l * (l + 1) + m), std::size_t(l * (l + 1) - m), by, m);
    return text;
}

// out = sum over the turns of value in, for `count` numbers; turns are sorted by where they go to.
std::string sparseTurnGlsl(const HeightTurn* turns, std::size_t turn_count, std::size_t count, const char* in,
                           const char* out) {
    std::vector<std::string> sums(count);
    for (std::size_t i = 0; i < turn_count; ++i)
        sums[turns[i].to] += (sums[turns[i].to].empty() ? "" : " + ") + glslFloat(double(turns[i].value)) + " * " +
                             element(in, turns[i].from);
    std::string text;
    for (std::size_t i = 0; i < count; ++i)
        text += "    " + element(out, i) + " = " + (sums[i].empty() ? "0.0" : sums[i]) + ";\n";
    return text;
}

// Moves the numbers the shortest way to where E lies in [0, 1].
std::string clampGlsl(const HeightMirror& mirror) {
    std::string sum = "0.0", text;
    for (int i = 0; i < mirror.size; ++i) {
        const std::string number = element("numbers", std::size_t(i)), weight = glslFloat(double(mirror.ambient[i]));
        if (mirror.ambient[i] == 0) continue;
        sum += " + " + weight + " * " + number;
        text += "    " + number + " -= excess * " + weight + ";\n";
    }
    return "    float e = " + sum + ";\n    float excess = (e - clamp(e, 0.0, 1.0)) / " +
           glslFloat(double(mirror.ambient_norm2)) + ";\n" + text;
}

std::string mirrorGlsl(const HeightMirror& mirror) {
    const auto size = std::size_t(mirror.size), count = std::size_t(mirror.order * mirror.order);
    int most = 1;
    for (std::size_t p = 0; p < mirror.pair_count; ++p) most = std::max(most, int(mirror.pairs[p].m));
    std::string text = "void heightsMirror(inout float v[" + std::to_string(count) +
                       "], vec3 normal, vec3 tangent, out float numbers[" + std::to_string(size) + "]) {\n";
    text += "    vec2 phi, beta, psi;\n    turnsOf(normal, tangent, phi, beta, psi);\n";
    text += turnsGlsl("a", "vec2(phi.x, -phi.y)", mirror.order) +
            turnsGlsl("b", "vec2(beta.x, -beta.y)", mirror.order) + turnsGlsl("c", "psi", most + 1);
    text += "    float upright[" + std::to_string(count) + "];\n";
    text += turnAllGlsl("v", "a", mirror.order);
    text += sparseTurnGlsl(mirror.quarter, mirror.quarter_count, count, "v", "upright");
    text += turnAllGlsl("upright", "b", mirror.order);
    text += sparseTurnGlsl(mirror.mirror, mirror.mirror_count, size, "upright", "numbers");
    for (std::size_t p = 0; p < mirror.pair_count; ++p)
        text += turnGlsl("numbers", mirror.pairs[p].plus, mirror.pairs[p].minus, "c", mirror.pairs[p].m);
    for (std::size_t i = 0; mirror.below && i < size; ++i)
        text += "    " + element("numbers", i) + " += " + glslFloat(double(mirror.below[i])) + ";\n";
    return text + clampGlsl(mirror) + "}\n";
}

std::string define(const std::string& name, const std::string& value = "") {
    return "#define " + name + " " + value + "\n";
}

}  // namespace

std::size_t heightRowQuads(int order) { return std::size_t(order * order + 3 + 3) / 4; }

std::size_t heightCellShares(int step) { return std::size_t(step * step - 1) / 3; }

std::string heightsGlsl(const HeightField& field, const HeightTables& tables, Vec3 corner, HeightReceiver receiver) {
    const HeightScene scene = tables.sceneOf(field);
    const HeightGrid& grid = field.grid();
    const auto number = [](float x) { return glslFloat(double(x)); };
    std::string text =
        define("SIDE", "ivec2(" + std::to_string(grid.rows) + ", " + std::to_string(grid.columns) + ")") +
        define("CORNER", "vec3(" + number(corner.x) + ", " + number(corner.y) + ", " + number(corner.z) + ")") +
        define("CELL", "vec2(" + number(grid.cell_x) + ", " + number(grid.cell_y) + ")") +
        define("AZIMUTHS", std::to_string(scene.azimuths) + "u") +
        define("TAPS", std::to_string(scene.tap_count) + "u") + define("ORDER", std::to_string(scene.order)) +
        define("LEAST", glslFloat(double(scene.least)));
    if (scene.wraps) text += define("WRAPS");
    if (scene.open) text += define("OPEN");
    text += kShaderHeightsGlsl;
    const std::string mark = "GENERATED_BY_HEIGHTS_GLSL";
    return text.replace(text.rfind(mark), mark.size(), mirrorGlsl(tables.mirrorOf(receiver)));
}

std::vector<std::uint32_t> heightTapWords(const HeightField& field, const HeightTables& tables) {
    const HeightScene scene = tables.sceneOf(field);
    std::vector<std::uint32_t> words;
    const auto put = [&](float x) { words.push_back(std::bit_cast<std::uint32_t>(x)); };
    for (std::size_t t = 0; t < std::size_t(scene.azimuths) * scene.tap_count; ++t) {
        const HeightTap& tap = scene.taps[t];
        for (const float x :
             {tap.row, tap.column, tap.per_metre, tap.scale, tap.offset, tap.last_row, tap.last_column, 0.0f})
            put(x);
        words.insert(words.end(), {std::uint32_t(tap.columns), std::uint32_t(tap.first), 0, 0});
    }
    for (int i = 0; i < 2 * scene.azimuths * scene.order; ++i) put(scene.turns[i]);
    for (int i = 0; i < scene.order * (scene.order + 1) / 2; ++i) put(scene.norms[i]);
    words.resize((words.size() + 3) / 4 * 4);
    return words;
}

}  // namespace penumbra
