#include "formats/height/height_file.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "formats/cache/numbered_files.h"
#include "formats/cache/zip_archive.h"
#include "formats/common/errors.h"
#include "formats/common/parallel_for.h"
#include "formats/height/raw_heights.h"
#include "formats/image/picture_kinds.h"

namespace penumbra {

namespace {

constexpr std::uint64_t kMaxFileBytes = std::uint64_t(1) << 30;
constexpr std::uint64_t kMaxFrames = 100000;

struct Numbers {
    int rows = 0, columns = 0;
    std::vector<double> values;
};

std::string extensionOf(const std::filesystem::path& path) {
    std::string extension = path.extension().string();
    std::ranges::transform(extension, extension.begin(), [](unsigned char c) { return char(std::tolower(c)); });
    return extension;
}

std::vector<std::byte> wholeFile(const std::filesystem::path& path) {
    const RandomBytes bytes = openBytes(path);
    if (bytes.size > kMaxFileBytes) throw InvalidInput(path.string() + ": is larger than 1 GiB");
    return readBytes(bytes, 0, std::size_t(bytes.size));
}

Numbers numbersOfPicture(const std::filesystem::path& path, const std::string& channel) {
    const std::vector<std::byte> bytes = wholeFile(path);
    const PictureKind* kind = findPictureKind(bytes);
    if (!kind || !kind->gray)
        throw InvalidInput(path.string() +
                           ": is not a file of heights, which are .npy, .npz, grey PNG, OpenEXR, .bil and .raw");
    const GrayImage image = kind->gray(bytes, path.string(), {channel, kMaxHeightSide});
    return {image.height, image.width, {image.numbers.begin(), image.numbers.end()}};
}

// One array of a sequence of files.
Numbers numbersOfNumpy(const std::filesystem::path& path) {
    const NumpyArray array = openNumpy(openBytes(path), path.string());
    if (array.shape.size() != 2 || array.shape[0] < 1 || array.shape[1] < 1 || array.shape[0] > kMaxHeightSide ||
        array.shape[1] > kMaxHeightSide)
        throw InvalidInput(array.what + ": " + describe(array) + " is not [rows, columns] of 1 to 65536");
    const std::uint64_t count = array.shape[0] * array.shape[1];
    if (count > kMaxHeightTexels) throw InvalidInput(array.what + ": has more than 2^26 numbers");
    return {int(array.shape[0]), int(array.shape[1]), readNumbers(array, 0, std::size_t(count))};
}

Numbers numbersOf(const std::filesystem::path& path, const std::string& channel) {
    const std::string extension = extensionOf(path);
    if (extension == ".npy") return numbersOfNumpy(path);
    if (extension != ".bil" && extension != ".raw") return numbersOfPicture(path, channel);
    const RawHeights raw = readRawHeights(path);
    return {raw.rows, raw.columns, raw.numbers};
}

NumpyArray openZipArray(const std::filesystem::path& path, const std::string& wanted) {
    const ZipArchive zip = openZip(path);
    std::optional<NumpyArray> found;
    for (const ZipMember& member : zip.members) {
        if (!member.name.ends_with(".npy")) continue;
        const std::string key = member.name.substr(0, member.name.size() - 4);
        if (!wanted.empty() && key != wanted) continue;
        NumpyArray array = openNumpy(*openMember(zip, member.name), path.string() + ": '" + key + "'");
        if (wanted.empty() && (array.shape.size() < 2 || array.shape.size() > 3)) continue;
        if (found)
            throw InvalidInput(path.string() + ": has several arrays of two or three axes; \"array\" says which");
        found = std::move(array);
    }
    if (!found)
        throw InvalidInput(path.string() + (wanted.empty() ? ": has no array of two or three axes"
                                                           : ": has no array \"" + wanted + "\""));
    return *found;
}

std::vector<std::filesystem::path> framesOf(const std::filesystem::path& file) {
    if (!namesSequence(file)) return {file};
    return findNumberedFiles(file, {".npy", ".png", ".exr", ".bil", ".raw"}).files;
}

}  // namespace

std::vector<std::filesystem::path> filesOf(const HeightSource& source) {
    if (source.file.empty()) return {};
    std::vector<std::filesystem::path> out;
    for (const std::filesystem::path& frame : framesOf(source.file)) {
        out.push_back(frame);
        if (const std::string extension = extensionOf(frame); extension == ".bil" || extension == ".raw")
            out.push_back(std::filesystem::path(frame).replace_extension(".hdr"));
    }
    return out;
}

HeightSequence::HeightSequence(HeightSource source) : source_(std::move(source)) {
    if (source_.analytic.empty()) {
        openFiles();
    } else {
        grid_.rows = source_.rows;
        grid_.columns = source_.columns;
        try {
            analytic_ = parseAnalyticHeights(source_.analytic);
        } catch (const std::invalid_argument& error) {
            throw InvalidInput(source_.at + "/analytic: " + error.what());
        }
    }
    grid_.cell_x = float(source_.cell_rows);
    grid_.cell_y = float(source_.cell_columns);
    grid_.border = source_.border;
    if (const std::string problem = findProblem(grid_); !problem.empty())
        throw InvalidInput((source_.file.empty() ? source_.at : source_.file.string()) + ": " + problem);
}

void HeightSequence::openFiles() {
    const std::string extension = extensionOf(source_.file);
    if (extension == ".npy" && !source_.array.empty())
        throw InvalidInput(source_.at + "/array: is only for .npz and .exr files");
    if ((extension == ".npy" || extension == ".npz") && !namesSequence(source_.file)) {
        files_ = {source_.file};
        array_ = extension == ".npy" ? openNumpy(openBytes(source_.file), source_.file.string())
                                     : openZipArray(source_.file, source_.array);
        const auto& shape = array_->shape;
        if (shape.size() < 2 || shape.size() > 3)
            throw InvalidInput(array_->what + ": " + describe(*array_) +
                               " is not [rows, columns] or [frames, rows, "
                               "columns]");
        for (const std::uint64_t side : shape)
            if (side < 1 || side > kMaxFrames)
                throw InvalidInput(array_->what + ": " + describe(*array_) + " has an axis of length " +
                                   std::to_string(side));
        frames_ = shape.size() == 3 ? std::size_t(shape[0]) : 1;
        grid_.rows = int(shape[shape.size() - 2]);
        grid_.columns = int(shape.back());
        return;
    }
    files_ = framesOf(source_.file);
    frames_ = files_.size();
    if (!source_.array.empty() && extensionOf(files_.front()) != ".exr")
        throw InvalidInput(source_.at + "/array: is only for .npz and .exr files");
    const Numbers first = numbersOf(files_.front(), source_.array);
    grid_.rows = first.rows;
    grid_.columns = first.columns;
}

void HeightSequence::readFrame(std::size_t frame, std::span<float> heights) const {
    std::string name = array_ ? array_->what : files_[frame].string();
    std::vector<double> values;
    if (array_) {
        values = readNumbers(*array_, frame * grid_.size(), grid_.size());
        if (frames_ > 1) name += ": frame " + std::to_string(frame);
    } else {
        Numbers numbers = numbersOf(files_[frame], source_.array);
        if (numbers.rows != grid_.rows || numbers.columns != grid_.columns)
            throw InvalidInput(name + ": has " + std::to_string(numbers.rows) + " x " +
                               std::to_string(numbers.columns) + " heights, and " + files_.front().string() + " has " +
                               std::to_string(grid_.rows) + " x " + std::to_string(grid_.columns));
        values = std::move(numbers.values);
    }
    for (std::size_t i = 0; i < values.size(); ++i) {
        const auto where = [&] {
            return name + ": row " + std::to_string(i / std::size_t(grid_.columns)) + ", column " +
                   std::to_string(i % std::size_t(grid_.columns));
        };
        double height = source_.offset + source_.scale * values[i];
        if (!std::isfinite(values[i]) || (source_.no_data && values[i] == *source_.no_data)) {
            if (!source_.fill) throw InvalidInput(where() + ": has no height; \"fill\" gives one");
            height = *source_.fill;
        }
        if (!(std::abs(height) <= double(kMaxElevation)))
            throw InvalidInput(where() + ": the height is " + std::to_string(height) + " m, more than 1e7");
        heights[i] = float(height);
    }
}

void HeightSequence::read(double seconds, std::span<float> heights) const {
    if (analytic_.empty()) {
        const double at = std::nearbyint(seconds * source_.fps);
        const auto frame = std::size_t(std::fmod(std::max(at, 0.0), double(frames_)));
        return readFrame(std::min(frame, frames_ - 1), heights);
    }
    constexpr int kRows = 16;  // rows that a thread takes at once
    parallelFor(std::size_t((grid_.rows + kRows - 1) / kRows), 0, [&](std::size_t piece) {
        const int first = int(piece) * kRows, end = std::min(first + kRows, grid_.rows);
        const auto columns = std::size_t(grid_.columns);
        analyticHeights(analytic_, grid_, seconds, first, end, heights);
        for (float& z : heights.subspan(std::size_t(first) * columns, std::size_t(end - first) * columns)) {
            z = float(source_.offset + source_.scale * double(z));
            if (!(std::abs(z) <= kMaxElevation)) throw InvalidInput(source_.at + "/analytic: a height is beyond 1e7 m");
        }
    });
}

}  // namespace penumbra
