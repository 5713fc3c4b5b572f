#include "formats/image/picture_light.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>

#include "formats/common/light_picture.h"
#include "formats/common/write_file.h"
#include "formats/image/cube_faces.h"
#include "formats/image/factor_light.h"
#include "formats/image/project_rows.h"

namespace penumbra {

namespace {

// Takes the means over boxes of a lat-long picture, by solid angle, as its rows come.
class BoxMeans {
public:
    BoxMeans(PictureSides from, int width) : from_(from), image_{width, width / 2, {}, {}} {
        image_.pixels.resize(std::size_t(image_.width) * std::size_t(image_.height));
        for (int x = 0; x < from.width; ++x) addColumn(x);
    }

    void add(int row, const std::array<const float*, 3>& color) {
        averageColumns(color);
        const double top = edge(row, from_.height), bottom = edge(row + 1, from_.height);
        const int first = int(std::int64_t(row) * image_.height / from_.height);
        for (int y = first; y < image_.height; ++y) {
            const double box_top = edge(y, image_.height), box_bottom = edge(y + 1, image_.height);
            if (box_top >= bottom) break;
            const float share = float((std::min(bottom, box_bottom) - std::max(top, box_top)) / (box_bottom - box_top));
            if (!(share > 0)) continue;
            Vec3* out = &image_.pixels[std::size_t(y) * std::size_t(image_.width)];
            for (std::size_t x = 0; x < std::size_t(image_.width); ++x)
                out[x] += share * Vec3{means_[0][x], means_[1][x], means_[2][x]};
        }
    }
    Image take() { return std::move(image_); }

private:
    static double edge(int row, int rows) { return -std::cos(std::numbers::pi * row / rows); }

    // Column x lies in one box, or in two: its shares in box_[x] and in the next.
    void addColumn(int x) {
        const double scale = double(image_.width) / from_.width;
        const int box = std::min(int(x * scale + 1e-9), image_.width - 1);
        const double inside = std::min((x + 1) * scale, box + 1.0) - x * scale;
        box_.push_back(box);
        share_.push_back(float(inside));
        share_of_next_.push_back(box + 1 < image_.width ? float(std::max(0.0, scale - inside)) : 0);
    }

    void averageColumns(const std::array<const float*, 3>& color) {
        const std::size_t boxes = std::size_t(image_.width), factor = std::size_t(from_.width) / boxes;
        for (std::size_t c = 0; c < 3; ++c) {
            std::vector<float>& mean = means_[c];
            mean.assign(boxes + 1, 0);
            if (factor * boxes == std::size_t(from_.width)) {
                for (std::size_t x = 0; x < boxes; ++x) {
                    float sum = 0;
                    for (std::size_t i = 0; i < factor; ++i) sum += color[c][x * factor + i];
                    mean[x] = sum / float(factor);
                }
                continue;
            }
            for (std::size_t x = 0; x < box_.size(); ++x) {
                mean[std::size_t(box_[x])] += share_[x] * color[c][x];
                mean[std::size_t(box_[x]) + 1] += share_of_next_[x] * color[c][x];
            }
        }
    }

    PictureSides from_;
    Image image_;
    std::vector<int> box_;
    std::vector<float> share_, share_of_next_;
    std::array<std::vector<float>, 3> means_;
};

// Tells whether all numbers are radiances: not negative, NaN or beyond kMaxRadiance.
bool areRadiances(const std::vector<float>& values) {
    int bad = 0;
    for (float value : values) bad += int(!(value >= 0)) | int(!(value <= float(kMaxRadiance)));
    return bad == 0;
}

void convertBand(const Mat3d& to_rec709, PictureBand& band) {
    const auto& m = to_rec709.m;
    float *r = band.color[0].data(), *g = band.color[1].data(), *b = band.color[2].data();
    for (std::size_t i = 0; i < band.color[0].size(); ++i) {
        const Vec3 p = toFloat(Vec3d{m[0] * r[i] + m[1] * g[i] + m[2] * b[i], m[3] * r[i] + m[4] * g[i] + m[5] * b[i],
                                     m[6] * r[i] + m[7] * g[i] + m[8] * b[i]});
        r[i] = p.x, g[i] = p.y, b[i] = p.z;
    }
}

// Reads a large picture in bands, or returns nothing where it has pixels that must be looked at with their neighbours.
std::optional<PictureLight> readBands(PictureRows& rows, const PictureLightChoice& choice) {
    const PictureInfo& info = rows.info();
    const PictureSides sides{info.width, info.height};
    RowProjection projection(sides, std::max(choice.order, kFactorOrder));
    BoxMeans boxes(sides, choice.suns > 1 ? choice.large.boxes / 2 : choice.large.boxes);
    PictureBand band;
    for (int y = 0; y < info.height; y += band.rows) {
        throwIfInterrupted();
        rows.next(band);
        if (!std::ranges::all_of(band.color, areRadiances)) return std::nullopt;
        if (info.to_rec709) convertBand(*info.to_rec709, band);
        for (int row = 0; row < band.rows; ++row) {
            const std::size_t at = std::size_t(row) * std::size_t(info.width);
            const std::array<const float*, 3> color{&band.color[0][at], &band.color[1][at], &band.color[2][at]};
            projection.add(y + row, color);
            boxes.add(y + row, color);
        }
        if (choice.progress) choice.progress(double(y + band.rows) / info.height);
    }
    PictureLight light;
    light.map.image = boxes.take();
    light.map.notes = info.notes;
    light.shape = {MapLayout::kLatLong, info.width, info.height};
    light.whole = projection.result();
    return light;
}

// Makes the light of a whole picture. Ringing of compression overshoots and undershoots by the same flux, which cancels
// in sums: where pixels below 0 were mended for the suns and the small picture, the projection is still that of the
// file's own pixels.
PictureLight makePictureLight(FilePicture picture, const PictureOptions& options, const std::string& name, int order) {
    const bool below = std::ranges::any_of(picture.image.pixels, [](Vec3 p) { return std::min({p.x, p.y, p.z}) < 0; });
    FilePicture kept;
    if (below) kept = picture;
    PictureLight light;
    light.map = makeEnvironmentMap(std::move(picture), options.layout, name);
    light.shape = light.map.shape();
    if (light.map.negative_pixels == 0) return light;
    EnvironmentMap unmended;
    unmended.layout = light.map.layout;
    const bool same_shape = kept.image.width == light.map.image.width;
    unmended.image = same_shape ? std::move(kept.image) : crossOfStrip(kept.image);
    convertColors(kept.info.to_rec709, unmended.image);
    light.whole = projectMap(unmended, std::max(order, kFactorOrder), 0);
    return light;
}

}  // namespace

MapProjection PictureLight::project(int order, int threads) const {
    if (!whole) return projectMap(map, order, threads);
    const std::size_t count = std::size_t(3 * coefficientCount(order));
    assert(count <= whole->sh.size());
    return {{whole->sh.begin(), whole->sh.begin() + std::ptrdiff_t(count)}, whole->energy};
}

PictureLight readPictureLight(std::span<const std::filesystem::path> paths, const PictureOptions& options,
                              const PictureLightChoice& choice) {
    if (paths.size() == 1 && filesOfPicture(paths.front(), options).size() == 1) {
        const std::unique_ptr<PictureRows> rows =
            openPicture(openBytes(paths.front()), paths.front().string(), options);
        const PictureInfo& info = rows->info();
        if (std::int64_t(info.width) * info.height > choice.large.from && info.from_the_top &&
            isLatLongMap({info.width, info.height}, options.layout, info.layout))
            if (std::optional<PictureLight> light = readBands(*rows, choice)) return std::move(*light);
    }
    return makePictureLight(readLightPicture(paths, options), options, paths.front().string(), choice.order);
}

}  // namespace penumbra
