#include "formats/image/picture_rows.h"

#include <algorithm>
#include <cstring>
#include <stdexcept>

#include "formats/common/errors.h"
#include "formats/image/color_space.h"
#include "formats/image/image_codecs.h"
#include "formats/image/picture_kinds.h"

namespace penumbra {

std::span<const std::byte> BufferedBytes::peek(std::size_t wanted) {
    wanted = std::min({wanted, buffer_.size(), std::size_t(left())});
    const bool inside = position_ >= start_ && position_ < start_ + held_;
    if (!inside || start_ + held_ - position_ < wanted) {
        start_ = position_;
        held_ = std::size_t(std::min<std::uint64_t>(buffer_.size(), left()));
        bytes_.read(start_, std::span(buffer_).first(held_));
    }
    return std::span<const std::byte>(buffer_).first(held_).subspan(std::size_t(position_ - start_));
}

void BufferedBytes::read(std::span<std::byte> out) {
    if (out.size() > buffer_.size()) {  // larger than the buffer: straight to where it is wanted
        bytes_.read(position_, out);
        position_ += out.size();
        return;
    }
    if (out.empty()) return;
    std::memcpy(out.data(), peek(out.size()).data(), out.size());
    position_ += out.size();
}

RandomBytes bytesOf(std::span<const std::byte> bytes) {
    return {bytes.size(), [bytes](std::uint64_t offset, std::span<std::byte> out) {
                if (!out.empty()) std::memcpy(out.data(), bytes.data() + offset, out.size());
            }};
}

std::unique_ptr<PictureRows> openPicture(const RandomBytes& bytes, const std::string& name,
                                         const PictureOptions& options) {
    const std::vector<std::byte> start = readBytes(bytes, 0, std::size_t(std::min<std::uint64_t>(64, bytes.size)));
    if (const std::string_view magic = "\x89HDF";
        start.size() >= magic.size() && std::memcmp(start.data(), magic.data(), magic.size()) == 0)
        throw InvalidInput(name + ": is HDF5, as fitted lights are: a picture is needed here");
    const PictureKind* kind = findPictureKind(start);
    if (!kind || !kind->light)
        throw InvalidInput(name + ": " +
                           (kind                   ? "is " + std::string(kind->name) + ", "
                            : looksLikeJpeg(start) ? "is JPEG, "
                                                   : "") +
                           "neither an OpenEXR nor a Radiance HDR picture");
    return kind->light(bytes, name, options);
}

void chooseColors(const std::optional<Primaries>& stated, const PictureOptions& options, const std::string& name,
                  PictureInfo& info) {
    std::optional<Primaries> chosen = stated;
    try {
        if (!options.colorspace.empty()) chosen = primariesOf(options.colorspace);
    } catch (const std::invalid_argument& error) {
        throw BadOption("colorspace", error.what());
    }
    if (!chosen) return;
    if (stated && !samePrimaries(*stated, *chosen))
        info.notes.warnings.push_back("the file states other colours (" + describePrimaries(*stated) + ") than " +
                                      describePrimaries(*chosen) + ", which were asked for and are used");
    try {
        info.to_rec709 = toRec709(*chosen);
    } catch (const std::invalid_argument& error) {
        throw InvalidInput(name + ": chromaticities: " + error.what());
    }
    if (info.to_rec709)
        info.notes.lines.push_back("colours of " + describePrimaries(*chosen) + " become linear Rec.709");
}

}  // namespace penumbra
