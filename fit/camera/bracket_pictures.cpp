#include "fit/camera/bracket_pictures.h"

#include "formats/common/errors.h"

namespace penumbra {

namespace {

std::string sizeText(int width, int height) { return std::to_string(width) + "x" + std::to_string(height); }

}  // namespace

BracketPictures readPictures(const BracketFile& bracket) {
    BracketPictures out;
    out.name = bracket.name;
    for (const ExposedPicture& one : bracket.pictures) {
        out.exposures.push_back(one.exposure);
        const TexturePicture& read = out.pictures.emplace_back(readTexture(one.file, one.file.string()));
        const std::string size = sizeText(read.width, read.height);
        const TexturePicture& first = out.pictures.front();
        if (read.width != first.width || read.height != first.height)
            throw InvalidInput(one.file.string() + ": is " + size + ", and " + bracket.pictures.front().file.string() +
                               " of the same bracket is " + sizeText(first.width, first.height));
        if (bracket.camera && (read.width != bracket.camera->width || read.height != bracket.camera->height))
            throw InvalidInput(one.file.string() + ": is " + size + ", and the camera of " + bracket.name + " has " +
                               sizeText(bracket.camera->width, bracket.camera->height));
    }
    return out;
}

}  // namespace penumbra
