#include "player/composite/picture_stream.h"

#include <algorithm>
#include <cmath>
#include <iostream>

#include "formats/common/errors.h"
#include "player/render/frame_list.h"

namespace penumbra {

namespace {

bool isVideo(const std::filesystem::path& path) { return path == "-" || path.extension() == ".y4m"; }

// Reads the digits between the two parts of a pattern's name.
std::optional<std::size_t> numberIn(const std::string& name, const FramePattern& pattern) {
    std::size_t first = 0;
    while (first < name.size() && !std::isdigit(static_cast<unsigned char>(name[first]))) ++first;
    for (std::size_t begin = first; begin < name.size(); ++begin) {
        if (!std::isdigit(static_cast<unsigned char>(name[begin]))) continue;
        std::size_t end = begin;
        while (end < name.size() && end < begin + 9 && std::isdigit(static_cast<unsigned char>(name[end]))) ++end;
        const std::size_t number = std::stoul(name.substr(begin, end - begin));
        if (pattern.name(number).filename() == name) return number;
    }
    return std::nullopt;
}

}  // namespace

Plate readPlate(const std::filesystem::path& path) {
    Plate plate;
    const std::string extension = path.extension().string();
    if (extension == ".exr" || extension == ".hdr")
        plate.linear = readImage(path);
    else
        plate.codes = readTexture(path, path.string());
    return plate;
}

PlateSource::PlateSource(const std::filesystem::path& path, std::optional<Y4mMatrix> matrix) {
    if (isVideo(path)) {
        if (path != "-") file_.open(path, std::ios::binary);
        if (path != "-" && !file_) throw IoError(path.string() + ": cannot be opened");
        reader_.emplace(path == "-" ? std::cin : static_cast<std::istream&>(file_),
                        path == "-" ? "standard input" : path.string());
        video_ = reader_->header();
        if (matrix) video_.matrix = *matrix;
        return;
    }
    if (!FramePattern::looksLikeOne(path)) {
        files_ = {path};
        return;
    }
    const FramePattern pattern(path);
    const std::filesystem::path folder = path.has_parent_path() ? path.parent_path() : ".";
    std::error_code problem;
    std::vector<std::pair<std::size_t, std::filesystem::path>> found;
    for (const auto& entry : std::filesystem::directory_iterator(folder, problem))
        if (const auto number = numberIn(entry.path().filename().string(), pattern))
            found.emplace_back(*number, entry.path());
    if (problem) throw IoError(folder.string() + ": " + problem.message());
    if (found.empty()) throw IoError(path.string() + ": no file has such a name");
    std::ranges::sort(found);
    for (auto& [number, file] : found) {
        numbers_.push_back(number);
        files_.push_back(std::move(file));
    }
}

std::optional<std::size_t> PlateSource::count() const {
    if (reader_) return std::nullopt;
    return files_.size();
}

bool PlateSource::read(std::size_t i, Plate& plate) {
    if (!reader_) {
        if (i >= files_.size()) return false;
        plate = readPlate(files_[i]);
        return true;
    }
    if (!reader_->next(planes_)) return false;
    plate.linear = {};
    plate.codes.width = video_.width;
    plate.codes.height = video_.height;
    plate.codes.rgb.resize(3 * std::size_t(video_.width) * std::size_t(video_.height));
    rgbFromPlanes(video_, planes_, plate.codes.rgb);
    return true;
}

PictureSink::PictureSink(const std::filesystem::path& path, const Y4mHeader* header, double fps,
                         std::optional<Y4mMatrix> matrix)
    : path_(path), fps_(fps), matrix_(matrix) {
    if (header) header_ = *header;
    if (path == "-") {
        out_ = &std::cout;
    } else if (isVideo(path)) {
        partial_ = std::make_unique<PartialFile>(path);
        file_.open(partial_->path(), std::ios::binary);
        if (!file_) throw IoError(path.string() + ": cannot be written");
        out_ = &file_;
    } else if (path.extension() != ".png" && path.extension() != ".exr") {
        throw BadOption("output", "must end in .png, .exr or .y4m, or be -, not " + path.string());
    }
}

PictureSink::~PictureSink() = default;

bool PictureSink::isLinear() const { return path_.extension() == ".exr"; }

std::filesystem::path PictureSink::fileOf(std::size_t number) const {
    if (isStream()) return {};
    return FramePattern::looksLikeOne(path_) ? FramePattern(path_).name(number) : path_;
}

bool PictureSink::has(std::size_t number, int width, int height) const {
    const std::filesystem::path file = fileOf(number);
    if (file.empty() || !std::filesystem::exists(file)) return false;
    try {
        const Plate there = readPlate(file);
        return there.width() == width && there.height() == height;
    } catch (const std::exception&) {  // cut short by another program: it is made again
        return false;
    }
}

void PictureSink::write(std::size_t number, const TexturePicture& picture) {
    if (!isStream()) return writeTexturePng(fileOf(number), picture);
    if (!begun_) {
        if (!header_) {
            header_.emplace();
            header_->chroma = picture.width % 2 || picture.height % 2 ? Y4mChroma::k444 : Y4mChroma::k420Jpeg;
            header_->matrix = matrix_.value_or(usualMatrix(picture.height));
            header_->rate = std::to_string(std::lround(fps_ * 1000)) + ":1000";
        }
        header_->width = picture.width;
        header_->height = picture.height;
        *out_ << y4mHeaderLine(*header_);
        begun_ = true;
    }
    if (picture.width != header_->width || picture.height != header_->height)
        throw InvalidInput((path_ == "-" ? "standard output" : path_.string()) +
                           ": all pictures of a video have one size, here " + std::to_string(header_->width) + " x " +
                           std::to_string(header_->height));
    planes_.resize(header_->frameBytes());
    planesFromRgb(*header_, picture.rgb, planes_);
    writeY4mFrame(*out_, *header_, planes_);
    out_->flush();
    if (!*out_) throw IoError((path_ == "-" ? "standard output" : path_.string()) + ": cannot be written");
}

void PictureSink::write(std::size_t number, const Image& picture) { writeExr(fileOf(number), picture); }

void PictureSink::finish() {
    if (!partial_) return;
    file_.close();
    if (!file_) throw IoError(path_.string() + ": cannot be written");
    partial_->commit();
}

}  // namespace penumbra
