// Writes a picture with a row for each frame (a vertex animation texture), and texture coordinates that find a vertex
// in it.
#include <algorithm>
#include <cmath>

#include "formats/common/errors.h"
#include "formats/common/write_file.h"
#include "formats/image/image_file.h"
#include "pack/export/export_files.h"
#include "pack/export/uv_sets.h"

namespace penumbra {

namespace {

constexpr std::size_t kWidest = 4096, kHighest = 16384;  // texels, of what graphics cards take

TableLayout layoutOf(std::size_t rows, std::size_t frames) {
    TableLayout layout;
    layout.vertices = rows;
    layout.frames = frames;
    layout.width = std::min(rows, kWidest);
    layout.rows_a_frame = (rows + layout.width - 1) / layout.width;
    if (layout.height() > kHighest)
        throw Unsupported(std::to_string(frames) + " frames of " + std::to_string(rows) + " vertices take " +
                          std::to_string(layout.height()) + " lines of a picture, more than " +
                          std::to_string(kHighest) + ": choose fewer clips or a lower rate");
    return layout;
}

// The values of one frame, [rows, channels].
std::vector<float> valuesOf(const OcclusionFrame& frame, const ExportRows& rows, const ExportedGlb* glb,
                            TableValue value) {
    std::vector<float> out;
    if (value == TableValue::kOcclusion) {
        out = valuesOfRows(rows, frame.ambient);
    } else if (value == TableValue::kBounced) {
        for (const Vec3 color : valuesOfRows(rows, frame.bounced)) out.insert(out.end(), {color.x, color.y, color.z});
    } else {
        std::vector<Vec3> bent = valuesOfRows(rows, frame.bent);
        if (glb)
            for (const std::size_t p : rows.parts) {
                const ColoredPart& part = glb->rig.part_colors[p];
                bringToPrimitive(part, std::span(bent).subspan(part.first_vertex, part.vertices));
            }
        const std::vector<float> ambient = valuesOfRows(rows, frame.ambient);
        for (std::size_t r = 0; r < bent.size(); ++r) {
            const Vec3 b = normalized(bent[r]);
            out.insert(out.end(), {b.x, b.y, b.z, ambient[r]});
        }
    }
    return out;
}

// Instances that share a mesh share its texture coordinates, so the first one's rows get the mean of all.
void averageInstances(const ExportedGlb& glb, std::size_t channels, std::vector<float>& coefficients) {
    for (const GlbTarget& target : glb.targets) {
        const ColoredPart& first = glb.rig.part_colors[target.parts[0]];
        if (target.parts.size() == 1) continue;
        for (std::size_t i = 0; i < first.vertices * channels; ++i) {
            double sum = 0;
            for (const std::size_t p : target.parts)
                sum += double(coefficients[glb.rig.part_colors[p].first_vertex * channels + i]);
            coefficients[first.first_vertex * channels + i] = float(sum / double(target.parts.size()));
        }
    }
}

std::size_t channelsOf(TableValue value) {
    return value == TableValue::kOcclusion ? 1 : value == TableValue::kBounced ? 3 : 4;
}

// Returns a byte of the picture. Directions have signs, so they are mapped to 0..1 first.
std::uint8_t toByte(float number, std::size_t channel, TableValue value) {
    const float shown = value == TableValue::kBent && channel < 3 ? 0.5f + 0.5f * number : number;
    return std::uint8_t(std::lround(std::clamp(shown, 0.0f, 1.0f) * 255));
}

class TablePicture {
public:
    TablePicture(const TableLayout& layout, TableValue value, bool is_exr) : layout_(layout), value_(value) {
        const std::size_t texels = layout.width * layout.height();
        if (is_exr) {
            half_.width = int(layout.width);
            half_.height = int(layout.height());
            half_.pixels.resize(texels);
            if (value == TableValue::kBent) half_.alpha.resize(texels);
        } else {
            bytes_ = {int(layout.width), int(layout.height()), int(channelsOf(value)), {}};
            bytes_.bytes.resize(texels * channelsOf(value));
        }
    }
    void put(std::size_t frame, std::span<const float> coefficients) {
        const std::size_t channels = channelsOf(value_);
        for (std::size_t v = 0; v < layout_.vertices; ++v) {
            const std::size_t texel =
                (frame * layout_.rows_a_frame + v / layout_.width) * layout_.width + v % layout_.width;
            const std::span<const float> row = coefficients.subspan(v * channels, channels);
            if (half_.pixels.empty())
                for (std::size_t c = 0; c < channels; ++c)
                    bytes_.bytes[texel * channels + c] = toByte(row[c], c, value_);
            else
                putHalf(texel, row);
        }
    }
    void write(const std::filesystem::path& path) const {
        if (half_.pixels.empty())
            writeDataPng(path, bytes_);
        else
            writeExr(path, half_);
    }

private:
    const TableLayout& layout_;
    TableValue value_;
    Image half_;
    DataPicture bytes_;

    void putHalf(std::size_t texel, std::span<const float> row) {
        half_.pixels[texel] = row.size() == 1 ? Vec3{row[0], row[0], row[0]} : Vec3{row[0], row[1], row[2]};
        if (!half_.alpha.empty()) half_.alpha[texel] = row[3];
    }
};

double rateOf(const FrameList& frames, std::size_t begin, std::size_t end) {
    const double seconds = frames.time[end - 1] - frames.time[begin];
    return seconds > 0 ? double(end - begin - 1) / seconds : 1;
}

// docs/exports.md lists the fields.
nlohmann::ordered_json tableJson(const TableLayout& layout, const FrameList& frames, const TableFiles& files,
                                 TableValue value) {
    nlohmann::ordered_json json{{"format", "penumbra.ao_table"}, {"version", 1}};
    json["picture"] = files.picture.filename().string();
    json["width"] = layout.width;
    json["height"] = layout.height();
    json["rows_a_frame"] = layout.rows_a_frame;
    json["vertices"] = layout.vertices;
    json["frames"] = layout.frames;
    json["first_time"] = frames.time[0];
    nlohmann::ordered_json clips = nlohmann::ordered_json::array();
    for (std::size_t begin = 0; begin < frames.frameCount();) {
        std::size_t end = begin + 1;
        while (end < frames.frameCount() && frames.clip[end] == frames.clip[begin]) ++end;
        clips.push_back({{"clip", frames.clip_names[frames.clip[begin]]},
                         {"first_frame", begin},
                         {"frames", end - begin},
                         {"first_time", frames.time[begin]},
                         {"rate", rateOf(frames, begin, end)}});
        begin = end;
    }
    json["rate"] = clips[0]["rate"];
    json["clip"] = clips[0]["clip"];
    json["clips"] = std::move(clips);
    json["value"] = value == TableValue::kOcclusion ? "occlusion" : value == TableValue::kBounced ? "bounced" : "bent";
    json["texcoord"] = nullptr;
    if (layout.texcoord) json["texcoord"] = *layout.texcoord;
    return json;
}

void addTableUv(const TableLayout& layout, ExportedGlb& out) {
    for (const GlbTarget& target : out.targets) {
        const ColoredPart& part = out.rig.part_colors[target.parts[0]];
        std::vector<float> uv;
        for (std::size_t v = part.first_vertex; v < part.first_vertex + part.vertices; ++v) {
            uv.push_back(float((double(v % layout.width) + 0.5) / double(layout.width)));
            uv.push_back(float((double(v / layout.width) + 0.5) / double(layout.height())));
        }
        addUvSet(out.glb, target, *layout.texcoord, uv);
    }
}

}  // namespace

TableFiles tableFiles(const std::filesystem::path& output, TableGlb glb) {
    TableFiles files;
    const std::filesystem::path stem = output.parent_path() / output.stem();
    const auto named = [&](const char* extension) { return std::filesystem::path(stem.string() + extension); };
    files.picture = output.extension() == ".exr" ? output : named(".png");
    files.description = named(".json");
    if (glb == TableGlb::kWritten) files.glb = named(".glb");
    return files;
}

TableLayout exportTable(const FrameReader& reader, const ExportRows& rows, TableValue value, const TableFiles& files,
                        ExportedGlb* glb) {
    const FrameList& list = reader.source.frames();
    if (value == TableValue::kBounced && !reader.source.hasBounces())
        throw BadOption("bounced", "the source has no light that bounces");
    TableLayout layout = layoutOf(rows.count(), list.frameCount());
    TablePicture picture(layout, value, files.picture.extension() == ".exr");
    const FrameParts parts = value == TableValue::kOcclusion ? FrameParts::kAmbient : FrameParts::kAll;
    for (std::size_t f = 0; f < list.frameCount(); ++f) {
        std::vector<float> coefficients = valuesOf(reader.read(f, parts), rows, glb, value);
        if (glb) averageInstances(*glb, channelsOf(value), coefficients);
        picture.put(f, coefficients);
    }
    if (glb) {
        layout.texcoord = freeUvSet(glb->glb, glb->targets, 1);
        markExport(glb->glb, {{"version", 1}, {"as", "table"}, {"texcoord", *layout.texcoord}});
        addTableUv(layout, *glb);
    }
    picture.write(files.picture);
    writeWholeFile(files.description, tableJson(layout, list, files, value).dump(1) + "\n");
    return layout;
}

}  // namespace penumbra
