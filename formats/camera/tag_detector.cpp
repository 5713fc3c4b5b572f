#include "formats/camera/tag_detector.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "formats/camera/tag_family.h"
#include "formats/common/errors.h"

namespace penumbra {

namespace {

constexpr const char* kFamilyNames[] = {"36h11", "25h9", "16h5", "4x4_50"};
constexpr int kFixedBits = 1;        // that may be misread; more of them find tags where there are none
constexpr double kPaperLevel = 200;  // of 255: what the paper of a tag is brought to
constexpr float kGains[] = {1, 4, 16};

using DetectorPointer = std::unique_ptr<apriltag_detector_t, void (*)(apriltag_detector_t*)>;

struct Found {
    DetectedTag tag;
    float paper = 0;  // luminance of the white around it
};

// A part of a picture.
struct Window {
    int x = 0, y = 0, width = 0, height = 0;
};

// The part that holds these tags and half of their size around them.
Window windowAround(const std::vector<Found>& found, const LinearLuminance& light) {
    double low_x = light.width, low_y = light.height, high_x = 0, high_y = 0;
    for (const Found& one : found) {
        const auto& c = one.tag.corners;
        const double size =
            std::max(std::hypot(c[2].x - c[0].x, c[2].y - c[0].y), std::hypot(c[3].x - c[1].x, c[3].y - c[1].y));
        for (const PixelPoint& p : c) {
            low_x = std::min(low_x, p.x - size / 2), high_x = std::max(high_x, p.x + size / 2);
            low_y = std::min(low_y, p.y - size / 2), high_y = std::max(high_y, p.y + size / 2);
        }
    }
    const int x = std::max(0, int(low_x)), y = std::max(0, int(low_y));
    return {x, y, std::min(light.width, int(high_x) + 1) - x, std::min(light.height, int(high_y) + 1) - y};
}

// The place in the picture of a point in libapriltag's frame of a tag, whose black square is [-1, 1]^2, y down.
PixelPoint placeOf(const apriltag_detection_t& found, const Window& in, double x, double y) {
    const double* h = found.H->data;
    const double w = h[6] * x + h[7] * y + h[8];
    return {(h[0] * x + h[1] * y + h[2]) / w - 0.5 + in.x, (h[3] * x + h[4] * y + h[5]) / w - 0.5 + in.y};
}

// Calls back with the pixel of places in the middle of the white ring around the black square.
void alongPaper(const apriltag_detection_t& found, const Window& in, auto visit) {
    const double ring = 1 + 1.0 / found.family->width_at_border;
    for (double along = -0.9; along < 1; along += 0.2)
        for (int side = 0; side < 4; ++side) {
            const double across = side % 2 ? ring : -ring;
            const PixelPoint at = side < 2 ? placeOf(found, in, along, across) : placeOf(found, in, across, along);
            visit(int(std::lround(at.x)), int(std::lround(at.y)));
        }
}

float median(std::vector<float> values) {
    if (values.empty()) return 0;
    const auto middle = values.begin() + std::ptrdiff_t(values.size() / 2);
    std::ranges::nth_element(values, middle);
    return *middle;
}

// libapriltag names the corners from the lower left, counter-clockwise, of a tag as its own pictures show it. OpenCV
// prints AprilTags turned by half a turn against these pictures, and scripts/ar/make_tags does as OpenCV; so the upper
// right corner of theirs is the lower left one of ours.
void storeCorners(const apriltag_detection_t& found, const Window& in, DetectedTag& out) {
    const std::size_t first = out.family == TagFamily::k4x4_50 ? 0 : 2;
    for (std::size_t i = 0; i < 4; ++i) {
        const double* p = found.p[(first + i) % 4];
        out.corners[i] = {p[0] - 0.5 + in.x, p[1] - 0.5 + in.y};  // libapriltag's pixel centers are at .5
    }
}

bool sameTag(const DetectedTag& a, const DetectedTag& b) {
    if (a.family != b.family || a.id != b.id) return false;
    const double size = std::hypot(a.corners[2].x - a.corners[0].x, a.corners[2].y - a.corners[0].y);
    return std::hypot(a.corners[0].x - b.corners[0].x, a.corners[0].y - b.corners[0].y) < 0.25 * size;
}

}  // namespace

const char* nameOf(TagFamily family) { return kFamilyNames[int(family)]; }

std::optional<TagFamily> findTagFamily(std::string_view name) {
    for (int i = 0; i < int(std::size(kFamilyNames)); ++i)
        if (name == kFamilyNames[i]) return TagFamily(i);
    return std::nullopt;
}

TagChoice parseTag(const std::string& text) {
    const auto fail = [&](const std::string& what) -> TagChoice {
        throw BadOption("tag", "\"" + text + "\" " + what + "; a tag is FAMILY:ID:SIDE, as 36h11:3:0.7");
    };
    const std::size_t first = text.find(':'), second = text.find(':', first + 1);
    if (first == std::string::npos || second == std::string::npos) return fail("has no three parts");
    const std::optional<TagFamily> family = findTagFamily(std::string_view(text).substr(0, first));
    if (!family) return fail("has no family of 36h11, 25h9, 16h5 and 4x4_50");
    try {
        std::size_t id_end = 0, side_end = 0;
        const std::string id = text.substr(first + 1, second - first - 1), side = text.substr(second + 1);
        TagChoice out{*family, std::stoi(id, &id_end), std::stod(side, &side_end)};
        const FamilyPointer known = makeFamily(*family);
        if (id_end != id.size() || side_end != side.size()) return fail("has no numbers");
        if (out.id < 0 || out.id >= int(known->ncodes))
            return fail("has an id that is not in 0.." + std::to_string(known->ncodes - 1));
        if (!(out.side > 0 && out.side <= 1000)) return fail("has a side that is not above 0 and at most 1000 metres");
        return out;
    } catch (const std::logic_error&) {  // of stoi and stod
        return fail("has no numbers");
    }
}

LinearLuminance linearLuminance(const TexturePicture& picture, const CameraResponse& response) {
    constexpr float kWeights[] = {0.2126f, 0.7152f, 0.0722f};  // Rec.709
    std::array<std::array<float, 256>, 3> table{};
    for (std::size_t c = 0; c < 3; ++c)
        for (std::size_t code = 0; code < 256; ++code)
            table[c][code] = kWeights[c] * response.exposure[c][code] / response.exposure[c][255];
    LinearLuminance out{picture.width, picture.height, {}};
    out.values.resize(picture.rgb.size() / 3);
    for (std::size_t i = 0; i < out.values.size(); ++i) {
        const std::uint8_t* rgb = &picture.rgb[3 * i];
        out.values[i] = table[0][rgb[0]] + table[1][rgb[1]] + table[2][rgb[2]];
    }
    return out;
}

struct TagDetector::Impl {
    std::vector<TagFamily> kinds;
    std::vector<FamilyPointer> families;  // outlive the detector, which has pointers to them
    DetectorPointer detector{apriltag_detector_create(), apriltag_detector_destroy};
    std::vector<std::uint8_t> gray;

    // Brings a luminance of 1 to 255 `gain`, and returns what is found in a part of the picture.
    std::vector<Found> findAt(float gain, const Window& in, const LinearLuminance& light,
                              const TexturePicture& picture);
    Found read(const apriltag_detection_t& found, const Window& in, const LinearLuminance& light,
               const TexturePicture& picture) const;
};

Found TagDetector::Impl::read(const apriltag_detection_t& found, const Window& in, const LinearLuminance& light,
                              const TexturePicture& picture) const {
    const auto at = std::ranges::find_if(families, [&](const FamilyPointer& f) { return f.get() == found.family; });
    Found out;
    out.tag.family = kinds[std::size_t(at - families.begin())];
    out.tag.id = found.id;
    out.tag.decision_margin = double(found.decision_margin);
    out.tag.flipped_bits = found.hamming;
    storeCorners(found, in, out.tag);
    std::vector<float> paper, codes;
    alongPaper(found, in, [&](int x, int y) {
        if (x < 0 || y < 0 || x >= light.width || y >= light.height) return;
        const std::size_t pixel = std::size_t(y) * std::size_t(light.width) + std::size_t(x);
        const std::uint8_t* rgb = &picture.rgb[3 * pixel];
        paper.push_back(light.values[pixel]);
        codes.push_back(float(std::max({rgb[0], rgb[1], rgb[2]})));
    });
    out.paper = median(std::move(paper));
    out.tag.paper_code = median(std::move(codes));
    return out;
}

std::vector<Found> TagDetector::Impl::findAt(float gain, const Window& in, const LinearLuminance& light,
                                             const TexturePicture& picture) {
    gray.resize(std::size_t(in.width) * std::size_t(in.height));
    for (int y = 0; y < in.height; ++y) {
        const float* row = &light.values[std::size_t(in.y + y) * std::size_t(light.width) + std::size_t(in.x)];
        std::uint8_t* out = &gray[std::size_t(y) * std::size_t(in.width)];
        for (int x = 0; x < in.width; ++x) out[x] = std::uint8_t(std::min(255 * gain * row[x] + 0.5f, 255.0f));
    }
    image_u8_t image{in.width, in.height, in.width, gray.data()};  // Debian hides image_u8_create()
    zarray_t* const all = apriltag_detector_detect(detector.get(), &image);
    std::vector<Found> out;
    for (int i = 0; i < zarray_size(all); ++i) {
        apriltag_detection_t* one = nullptr;
        zarray_get(all, i, &one);
        out.push_back(read(*one, in, light, picture));
    }
    apriltag_detections_destroy(all);
    return out;
}

TagDetector::TagDetector(std::span<const TagFamily> families, int threads) : impl_(std::make_unique<Impl>()) {
    if (families.empty()) throw std::invalid_argument("no family of tags");
    for (const TagFamily family : families) {
        if (std::ranges::find(impl_->kinds, family) != impl_->kinds.end()) continue;
        impl_->kinds.push_back(family);
        impl_->families.push_back(makeFamily(family));
        apriltag_detector_add_family_bits(impl_->detector.get(), impl_->families.back().get(), kFixedBits);
    }
    impl_->detector->nthreads = threads;
    impl_->detector->quad_decimate = 1;
    impl_->detector->refine_edges = true;
}

TagDetector::~TagDetector() = default;

std::vector<DetectedTag> TagDetector::detect(const TexturePicture& picture, const CameraResponse& response) {
    const LinearLuminance light = linearLuminance(picture, response);
    std::vector<Found> found;
    for (const float gain : kGains) {
        found = impl_->findAt(gain, {0, 0, light.width, light.height}, light, picture);
        if (!found.empty()) break;
    }
    // Eight bits are most exact where the paper of the tag is bright and not clipped.
    float brightest = 0;
    for (const Found& one : found) brightest = std::max(brightest, one.paper);
    if (brightest > 0)
        for (Found& again :
             impl_->findAt(float(kPaperLevel / 255) / brightest, windowAround(found, light), light, picture))
            for (Found& one : found)
                if (sameTag(one.tag, again.tag) && again.tag.decision_margin > one.tag.decision_margin) one = again;
    std::vector<DetectedTag> out;
    for (const Found& one : found) out.push_back(one.tag);
    std::ranges::sort(out, {}, [](const DetectedTag& tag) { return std::pair(tag.family, tag.id); });
    return out;
}

}  // namespace penumbra
