#include "formats/image/file_picture.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "formats/common/errors.h"
#include "formats/image/picture_shape.h"

namespace penumbra {

namespace {

bool isFinitePixel(Vec3 p) { return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z); }

// Joins the bands of a picture. It grows band by band, so that a short file that claims a large size fails early.
Image joinBands(PictureRows& rows) {
    const PictureInfo& info = rows.info();
    Image image{info.width, info.height, {}, {}};
    PictureBand band;
    for (int y = 0; y < info.height; y += band.rows) {
        rows.next(band);
        const std::size_t count = std::size_t(info.width) * std::size_t(band.rows), before = image.pixels.size();
        image.pixels.resize(before + count);
        for (std::size_t i = 0; i < count; ++i)
            image.pixels[before + i] = {band.color[0][i], band.color[1][i], band.color[2][i]};
        image.alpha.insert(image.alpha.end(), band.alpha.begin(), band.alpha.end());
    }
    const auto flip = [&](auto& values) {
        for (std::ptrdiff_t y = 0; y < info.height / 2; ++y)
            std::swap_ranges(values.begin() + y * info.width, values.begin() + (y + 1) * info.width,
                             values.end() - (y + 1) * info.width);
    };
    if (info.from_the_top) return image;
    flip(image.pixels);
    if (!image.alpha.empty()) flip(image.alpha);
    return image;
}

}  // namespace

void requireFinite(const Image& image, const std::string& name) {
    for (std::size_t i = 0; i < image.pixels.size(); ++i)
        if (!isFinitePixel(image.pixels[i]))
            throw InvalidInput(name + ": NaN or infinity in pixel (" + std::to_string(i % std::size_t(image.width)) +
                               ", " + std::to_string(i / std::size_t(image.width)) +
                               "); a repair would replace such pixels by their neighbours");
    for (float alpha : image.alpha)
        if (!std::isfinite(alpha)) throw InvalidInput(name + ": NaN or infinity in channel A");
}

void repairPixels(Image& image, RowEnds ends, const std::string& name, PictureNotes& notes) {
    for (float& alpha : image.alpha)
        if (!std::isfinite(alpha)) alpha = 1;
    std::vector<std::size_t> bad;
    for (std::size_t i = 0; i < image.pixels.size(); ++i)
        if (!isFinitePixel(image.pixels[i])) bad.push_back(i);
    if (bad.empty()) return;
    if (bad.size() == image.pixels.size()) throw InvalidInput(name + ": every pixel has NaN or infinity");
    notes.repaired_pixels = bad.size();
    notes.repaired_share = double(bad.size()) / double(image.pixels.size());
    char text[120];
    std::snprintf(text, sizeof text,
                  "%zu pixel%s with NaN or infinity, %.2g%% of the picture, became the mean of their "
                  "neighbours",
                  bad.size(), bad.size() == 1 ? "" : "s", 100 * notes.repaired_share);
    notes.lines.push_back(text);
    const int width = image.width;
    while (!bad.empty()) {
        // 1. Pixels beside finite ones; their new colours count only from the next pass on.
        std::vector<std::pair<std::size_t, Vec3>> mended;
        for (std::size_t at : bad) {
            const int x = int(at % std::size_t(width)), y = int(at / std::size_t(width));
            Vec3d sum;
            int count = 0;
            for (int j = std::max(0, y - 1); j <= std::min(image.height - 1, y + 1); ++j)
                for (int i = x - 1; i <= x + 1; ++i) {
                    if ((i < 0 || i >= width) && ends == RowEnds::kStop) continue;
                    const Vec3 p = image.pixels[std::size_t(j) * std::size_t(width) + std::size_t((i + width) % width)];
                    if (isFinitePixel(p)) sum += toDouble(p), ++count;
                }
            if (count > 0) mended.emplace_back(at, toFloat(sum / double(count)));
        }
        // 2. The next ring of a larger spot.
        for (const auto& [at, color] : mended) image.pixels[at] = color;
        std::erase_if(bad, [&](std::size_t at) { return isFinitePixel(image.pixels[at]); });
    }
}

FilePicture readFilePicture(PictureRows& rows, const std::string& name, const PictureOptions& options) {
    FilePicture picture{joinBands(rows), rows.info()};
    if (!options.repair) {
        requireFinite(picture.image, name);
        return picture;
    }
    const bool around = isLatLongShape({picture.image.width, picture.image.height}) && !options.any_shape;
    repairPixels(picture.image, around ? RowEnds::kGoAround : RowEnds::kStop, name, picture.info.notes);
    return picture;
}

void convertColors(const std::optional<Mat3d>& to_rec709, Image& image) {
    if (!to_rec709) return;
    for (Vec3& p : image.pixels) p = toFloat(*to_rec709 * toDouble(p));
}

}  // namespace penumbra
