#include "formats/image/cube_faces.h"

#include <algorithm>
#include <cctype>

#include "formats/common/errors.h"

namespace penumbra {

namespace {

// A face of the horizontal cross, and whether a picture must be turned by 180 degrees to get there.
struct CrossPlace {
    int column, row;
    bool turned;
};
constexpr std::array<CrossPlace, 6> kOfStrip = {
    {{0, 1, false}, {2, 1, false}, {1, 0, true}, {1, 2, true}, {1, 1, false}, {3, 1, false}}};
constexpr std::array<CrossPlace, 6> kOfFiles = {
    {{2, 1, false}, {0, 1, false}, {1, 0, false}, {1, 2, false}, {1, 1, false}, {3, 1, false}}};

void placeFace(std::span<const Vec3> face, CrossPlace place, int size, Image& cross) {
    for (int y = 0; y < size; ++y)
        for (int x = 0; x < size; ++x) {
            const std::size_t from = std::size_t(y) * std::size_t(size) + std::size_t(x);
            const int column = place.turned ? size - 1 - x : x, row = place.turned ? size - 1 - y : y;
            cross.pixels[std::size_t(place.row * size + row) * std::size_t(cross.width) +
                         std::size_t(place.column * size + column)] = face[from];
        }
}

Image emptyCross(int size) {
    return {4 * size, 3 * size, std::vector<Vec3>(std::size_t(12) * std::size_t(size) * std::size_t(size)), {}};
}

using FaceWords = std::array<const char*, 6>;
constexpr std::array<FaceWords, 4> kFaceWords = {{{"posx", "negx", "posy", "negy", "posz", "negz"},
                                                  {"px", "nx", "py", "ny", "pz", "nz"},
                                                  {"right", "left", "top", "bottom", "front", "back"},
                                                  {"right", "left", "up", "down", "front", "back"}}};

struct FaceName {
    std::size_t words = 0, face = 0;
    std::string before;  // the rest of the name, without its extension
    bool capitals = false;
};

// Finds the word at the end of a name that tells a face; a letter or digit before it makes it another word. `words`
// are the ones to try.
std::optional<FaceName> parseFaceName(const std::string& stem, std::size_t words) {
    std::string small = stem;
    std::ranges::transform(small, small.begin(), [](unsigned char c) { return char(std::tolower(c)); });
    for (std::size_t face = 0; face < 6; ++face) {
        const std::string word = kFaceWords[words][face];
        if (!small.ends_with(word)) continue;
        const std::size_t at = stem.size() - word.size();
        if (at > 0 && std::isalnum(static_cast<unsigned char>(stem[at - 1]))) continue;
        return FaceName{words, face, stem.substr(0, at), std::isupper(static_cast<unsigned char>(stem[at])) != 0};
    }
    return std::nullopt;
}

std::string faceFileName(const FaceName& name, std::size_t face, const std::string& extension) {
    std::string word = kFaceWords[name.words][face];
    if (name.capitals)
        std::ranges::transform(word, word.begin(), [](unsigned char c) { return char(std::toupper(c)); });
    return name.before + word + extension;
}

std::string describeSides(const Image& image) {
    return std::to_string(image.width) + " x " + std::to_string(image.height);
}

}  // namespace

Image crossOfStrip(const Image& strip) {
    const int size = strip.width;
    Image cross = emptyCross(size);
    const std::size_t count = std::size_t(size) * std::size_t(size);
    for (std::size_t face = 0; face < 6; ++face)
        placeFace(std::span(strip.pixels).subspan(face * count, count), kOfStrip[face], size, cross);
    return cross;
}

std::optional<int> faceOfName(const std::filesystem::path& file) {
    for (std::size_t words = 0; words < kFaceWords.size(); ++words)
        if (const auto found = parseFaceName(file.stem().string(), words)) return int(found->face);
    return std::nullopt;
}

std::optional<std::array<std::filesystem::path, 6>> findFaceFiles(const std::filesystem::path& face) {
    for (std::size_t words = 0; words < kFaceWords.size(); ++words) {
        const auto name = parseFaceName(face.stem().string(), words);
        if (!name) continue;
        std::array<std::filesystem::path, 6> files;
        std::error_code error;
        bool all = true;
        for (std::size_t i = 0; i < 6; ++i) {
            files[i] = face.parent_path() / faceFileName(*name, i, face.extension().string());
            all = all && std::filesystem::is_regular_file(files[i], error);
        }
        if (all) return files;
    }
    return std::nullopt;
}

std::array<std::filesystem::path, 6> orderFaceFiles(std::span<const std::filesystem::path> files) {
    std::array<std::filesystem::path, 6> ordered;
    for (const std::filesystem::path& file : files) {
        const std::optional<int> face = faceOfName(file);
        if (!face)
            throw InvalidInput(file.string() +
                               ": the end of its name tells no face of a cube (px nx py ny pz nz, or right left top "
                               "bottom front back)");
        if (!ordered[std::size_t(*face)].empty())
            throw InvalidInput(file.string() + ": is the same face as " + ordered[std::size_t(*face)].string());
        ordered[std::size_t(*face)] = file;
    }
    return ordered;
}

FilePicture readFaces(std::span<const std::filesystem::path, 6> files, const PictureOptions& options) {
    PictureOptions of_face = options;
    of_face.any_shape = true;
    FilePicture cross;
    int size = 0;
    for (std::size_t face = 0; face < 6; ++face) {
        const std::string name = files[face].string();
        const std::unique_ptr<PictureRows> rows = openPicture(openBytes(files[face]), name, of_face);
        FilePicture picture = readFilePicture(*rows, name, of_face);
        if (picture.image.width != picture.image.height)
            throw InvalidInput(name + ": " + describeSides(picture.image) + ": a face of a cube is square");
        if (face == 0) {
            size = picture.image.width;
            cross = {emptyCross(size), picture.info};
        } else if (picture.image.width != size) {
            throw InvalidInput(name + ": " + describeSides(picture.image) + ", other than " + files[0].string());
        } else if (picture.info.to_rec709 != cross.info.to_rec709) {
            throw InvalidInput(name + ": states other colours than " + files[0].string());
        }
        if (face > 0) {
            cross.info.notes.repaired_pixels += picture.info.notes.repaired_pixels;
            cross.info.notes.repaired_share += picture.info.notes.repaired_share;
        }
        placeFace(picture.image.pixels, kOfFiles[face], size, cross.image);
    }
    cross.info.notes.repaired_share /= 6;
    cross.info.width = cross.image.width;
    cross.info.height = cross.image.height;
    cross.info.layout = "cross";
    return cross;
}

FilePicture readLightPicture(std::span<const std::filesystem::path> paths, const PictureOptions& options) {
    const std::string name = paths.front().string();
    if (paths.size() > 1) {
        if (paths.size() != 6)
            throw InvalidInput(name + ": a light is one picture, or six that are the faces of a cube; " +
                               std::to_string(paths.size()) + " are named");
        if (!options.layout.empty() && options.layout != "cube")
            throw BadOption("layout", "six pictures are the faces of a cube, not " + options.layout);
        return readFaces(orderFaceFiles(paths), options);
    }
    if (options.layout == "cube")
        if (const auto faces = findFaceFiles(paths.front())) return readFaces(*faces, options);
    const std::unique_ptr<PictureRows> rows = openPicture(openBytes(paths.front()), name, options);
    return readFilePicture(*rows, name, options);
}

}  // namespace penumbra
