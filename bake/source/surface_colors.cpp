#include "bake/source/surface_colors.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>

#include "bake/source/base_colors.h"
#include "formats/common/errors.h"
#include "formats/common/picture_text.h"
#include "formats/common/slot_choice.h"

namespace penumbra {

namespace {

// --- Tables ---------------------------------------------------------------------------------------------------------
// The first line of a table is "slot,r,g,b" or "vertex,r,g,b". Every further line gives one slot of the mesh, or one
// vertex by its index, a colour. The last three fields of a line are the colour, so that a slot's name may have commas.

// One line of a table, and where it stands.
struct TableLine {
    std::string name;
    Vec3 color;
    std::string where;  // starts messages
};

float parseChannel(const std::string& text, const std::string& where) {
    float value = 0;
    const std::size_t first = std::min(text.find_first_not_of(" \t"), text.size());
    const std::size_t last = text.find_last_not_of(" \t") + 1;
    const char* end = text.data() + std::max(first, last);
    const auto [stop, error] = std::from_chars(text.data() + first, end, value);
    if (error != std::errc() || stop != end || !std::isfinite(value))
        throw InvalidInput(where + "'" + text + "' is not a number");
    return value;
}

TableLine parseLine(std::string line, const std::string& where) {
    TableLine out{"", {}, where};
    for (int c = 2; c >= 0; --c) {
        const std::size_t comma = line.rfind(',');
        if (comma == std::string::npos) throw InvalidInput(where + "fewer than 4 fields");
        const float value = parseChannel(line.substr(comma + 1), where);
        (c == 0 ? out.color.x : c == 1 ? out.color.y : out.color.z) = value;
        line.resize(comma);
    }
    out.name = line;
    return out;
}

struct ColorTable {
    bool by_slot = false;
    std::vector<TableLine> lines;
};

ColorTable readTable(const std::filesystem::path& path) {
    std::ifstream in(path);
    if (!in)
        throw IoError(path.string() +
                      ": cannot read as a table, and is not a colour R/G/B of three numbers of 0 or more");
    ColorTable table;
    std::string line;
    for (std::size_t number = 1; std::getline(in, line); ++number) {
        const std::string where = path.string() + ": line " + std::to_string(number) + ": ";
        if (!line.empty() && line.back() == '\r') line.pop_back();
        if (number == 1) {
            table.by_slot = line == "slot,r,g,b";
            if (!table.by_slot && line != "vertex,r,g,b")
                throw InvalidInput(where + "must be slot,r,g,b or vertex,r,g,b");
        } else if (!line.empty()) {
            table.lines.push_back(parseLine(line, where));
        }
    }
    if (table.lines.empty()) throw InvalidInput(path.string() + ": has no colours");
    return table;
}

// Colours of vertices, some of which are still unknown.
using PartialColors = std::vector<std::optional<Vec3>>;

void colorSlot(const Mesh& mesh, const TableLine& line, PartialColors& colors) {
    const std::vector<std::string_view> slots(mesh.slots.begin(), mesh.slots.end());
    std::vector<std::size_t> found;
    try {
        found = findSlots(slots, line.name);
    } catch (const UsageError& error) {
        throw InvalidInput(line.where + error.what());
    }
    for (std::size_t v = 0; v < mesh.vertexCount(); ++v)
        if (std::find(found.begin(), found.end(), mesh.slot_of_vertex[v]) != found.end()) colors[v] = line.color;
}

void colorVertex(const Mesh& mesh, const TableLine& line, PartialColors& colors) {
    std::size_t vertex = 0;
    const char* end = line.name.data() + line.name.size();
    const auto [stop, error] = std::from_chars(line.name.data(), end, vertex);
    const std::size_t fronts = mesh.frontVertexCount();
    if (error != std::errc() || stop != end || vertex >= fronts)
        throw InvalidInput(line.where + "vertex '" + line.name + "' is not in 0.." + std::to_string(fronts - 1));
    for (std::size_t v = vertex; v < mesh.vertexCount(); v += fronts) colors[v] = line.color;
}

std::vector<Vec3> tableColors(const std::filesystem::path& path, const Mesh& mesh) {
    const ColorTable table = readTable(path);
    PartialColors found(mesh.vertexCount());
    for (const TableLine& line : table.lines)
        table.by_slot ? colorSlot(mesh, line, found) : colorVertex(mesh, line, found);
    std::vector<Vec3> colors;
    for (std::size_t v = 0; v < found.size(); ++v) {
        if (!found[v])
            throw InvalidInput(path.string() + ": has no colour for vertex " + std::to_string(v) +
                               (mesh.slots.empty() ? "" : ", slot '" + mesh.slots[mesh.slot_of_vertex[v]] + "'"));
        colors.push_back(*found[v]);
    }
    return colors;
}

// --- All sources of colours -----------------------------------------------------------------------------------------

std::vector<Vec3> chosenColors(const ColorChoice& choice, const Mesh& mesh) {
    if (choice.table) return tableColors(*choice.table, mesh);
    return std::vector<Vec3>(mesh.vertexCount(), *choice.color);
}

}  // namespace

ColorChoice readColorChoice(const std::string& text) {
    if (text.empty()) return {};
    if (const std::optional<Vec3> color = parseColor(text)) return {color, {}};
    return {{}, text};
}

std::vector<Vec3> readAlbedo(const ColorChoice& choice, const Mesh& mesh) {
    const SurfaceColors colors{chosenColors(choice, mesh)};
    if (const std::string problem = findProblem(colors, mesh); !problem.empty()) throw BadOption("albedo", problem);
    return colors.albedo;
}

ChosenColors surfaceColors(const BakeSource& source, const Mesh& mesh, const TransferOptions& options) {
    if (options.transmission.any() && !mesh.two_sided) throw BadOption("transmission", "the mesh is not two-sided");
    ChosenColors out;
    std::string where;
    if (options.albedo.any()) {
        out.colors.albedo = chosenColors(options.albedo, mesh);
        out.albedo_from = options.albedo.table ? "table " + options.albedo.table->filename().string() : "one colour";
    } else {
        const std::string file = source.filesRead().front().string();
        if (!source.rig || source.rig->part_colors.empty())
            throw BadOption("albedo", "is needed: " + file + " has no base colours");
        BaseColors base = readBaseColors(*source.rig, file);
        out.albedo_from = base.textured ? kFromTextures : kFromBaseColors;
        out.pictures = std::move(base.pictures);
        out.colors.albedo = base.colors;
        if (mesh.two_sided) out.colors.albedo.insert(out.colors.albedo.end(), base.colors.begin(), base.colors.end());
        where = "is needed: " + file + ": " + out.albedo_from + ": ";
    }
    if (options.transmission.any()) out.colors.transmission = chosenColors(options.transmission, mesh);
    if (const std::string problem = findProblem(out.colors, mesh); !problem.empty())
        throw BadOption("albedo", where + problem);
    return out;
}

}  // namespace penumbra
