#include "formats/camera/colmap_model.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <string_view>

#include "formats/common/errors.h"
#include "formats/common/natural_order.h"
#include "sh/quaternion.h"

namespace penumbra {

namespace {

constexpr std::size_t kMaxImages = 1000000, kMaxNameLength = 4096;
constexpr double kFarthest = 1e6, kLargestSide = 32768, kUnequalFocal = 0.002;

// A text, line by line. Lines that begin with # are comments.
class Lines {
public:
    Lines(std::string_view text, std::string file) : rest_(text), file_(std::move(file)) {}

    // Returns the next line that is no comment, without its end; none behind the last one.
    std::optional<std::string_view> next() {
        while (!rest_.empty()) {
            ++number_;
            const std::size_t end = std::min(rest_.find('\n'), rest_.size());
            std::string_view line = rest_.substr(0, end);
            rest_.remove_prefix(std::min(end + 1, rest_.size()));
            if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
            if (line.empty() || line.front() != '#') return line;
        }
        return std::nullopt;
    }
    [[noreturn]] void fail(const std::string& what) const { throw InvalidInput(place() + what); }
    std::string place() const { return file_ + ": line " + std::to_string(number_) + ": "; }

private:
    std::string_view rest_;
    std::string file_;
    std::size_t number_ = 0;
};

bool isBlank(std::string_view line) { return line.find_first_not_of(" \t") == std::string_view::npos; }

// Takes the next word off a line; empty where there is none.
std::string_view takeWord(std::string_view& line) {
    const std::size_t start = std::min(line.find_first_not_of(" \t"), line.size());
    line.remove_prefix(start);
    const std::size_t end = std::min(line.find_first_of(" \t"), line.size());
    const std::string_view word = line.substr(0, end);
    line.remove_prefix(end);
    return word;
}

std::string shown(std::string_view word) {
    std::string out(word.substr(0, 40));
    for (char& c : out)
        if (static_cast<unsigned char>(c) < 0x20) c = '?';
    return out;
}

double takeNumber(const Lines& lines, std::string_view& line, const char* what, double range) {
    const std::string_view word = takeWord(line);
    double out = 0;
    const auto [stop, error] = std::from_chars(word.data(), word.data() + word.size(), out);
    if (word.empty() || error != std::errc() || stop != word.data() + word.size() || !(std::abs(out) <= range))
        lines.fail(std::string(what) + " must be a number up to " + std::to_string(long(range)) + ", not '" +
                   shown(word) + "'");
    return out;
}

long takeWhole(const Lines& lines, std::string_view& line, const char* what, double range) {
    const double out = takeNumber(lines, line, what, range);
    if (out < 0 || out != std::floor(out)) lines.fail(std::string(what) + " must be a whole number");
    return long(out);
}

PinholeCamera takeCamera(const Lines& lines, std::string_view line) {
    const std::string model(takeWord(line));
    PinholeCamera out;
    out.width = int(takeWhole(lines, line, "WIDTH", kLargestSide));
    out.height = int(takeWhole(lines, line, "HEIGHT", kLargestSide));
    if (model != "SIMPLE_PINHOLE" && model != "PINHOLE" && model != "SIMPLE_RADIAL" && model != "RADIAL")
        throw Unsupported(lines.place() + "the camera model " + shown(model) +
                          " is not read; SIMPLE_PINHOLE, PINHOLE, SIMPLE_RADIAL and RADIAL are");
    out.f = takeNumber(lines, line, "f", kFarthest);
    if (model == "PINHOLE") {
        const double fy = takeNumber(lines, line, "fy", kFarthest);
        if (!(std::abs(fy - out.f) <= kUnequalFocal * std::abs(out.f)))
            throw Unsupported(lines.place() + "fx " + std::to_string(out.f) + " and fy " + std::to_string(fy) +
                              " differ: pixels must be square");
        out.f = (out.f + fy) / 2;
    }
    out.cx = takeNumber(lines, line, "cx", kFarthest) - 0.5;
    out.cy = takeNumber(lines, line, "cy", kFarthest) - 0.5;
    if (model == "SIMPLE_RADIAL" || model == "RADIAL") out.k1 = takeNumber(lines, line, "k1", kFarthest);
    if (model == "RADIAL") out.k2 = takeNumber(lines, line, "k2", kFarthest);
    if (!isBlank(line)) lines.fail("more numbers than " + model + " has");
    if (const std::string problem = findProblem(out); !problem.empty()) lines.fail("the camera " + problem);
    return out;
}

// A camera is read only when an image needs it, so that others may be of any model.
std::map<long, std::pair<Lines, std::string_view>> cameraLines(const std::string& text, const std::string& file) {
    std::map<long, std::pair<Lines, std::string_view>> out;
    Lines lines(text, file);
    while (std::optional<std::string_view> line = lines.next()) {
        if (isBlank(*line)) continue;
        const long id = takeWhole(lines, *line, "CAMERA_ID", 1e9);
        if (!out.try_emplace(id, lines, *line).second) lines.fail("camera " + std::to_string(id) + " occurs twice");
    }
    return out;
}

struct ColmapImage {
    TrackFrame frame;
    long camera = 0;
};

ColmapImage takeImage(const Lines& lines, std::string_view line) {
    ColmapImage out;
    takeWhole(lines, line, "IMAGE_ID", 1e12);
    Quaternion q{};
    const char* names[] = {"QW", "QX", "QY", "QZ"};
    for (std::size_t i = 0; i < 4; ++i) q[(i + 3) % 4] = takeNumber(lines, line, names[i], 2);
    const std::optional<Quaternion> unit = normalized(q);
    if (!unit) lines.fail("QW QX QY QZ are all 0");
    CameraPose pose{matrixOf(*unit), {}};
    pose.translation.x = takeNumber(lines, line, "TX", kFarthest);
    pose.translation.y = takeNumber(lines, line, "TY", kFarthest);
    pose.translation.z = takeNumber(lines, line, "TZ", kFarthest);
    out.camera = takeWhole(lines, line, "CAMERA_ID", 1e9);
    const std::size_t start = std::min(line.find_first_not_of(" \t"), line.size());
    const std::string_view name = line.substr(start);  // the name may have blanks
    if (name.empty() || name.size() > kMaxNameLength) lines.fail("has no NAME");
    if (std::ranges::any_of(name, [](unsigned char c) { return c < 0x20; })) lines.fail("NAME has a control character");
    out.frame.file = std::string(name);
    out.frame.pose = pose;
    return out;
}

}  // namespace

CameraTrack parseColmapModel(const std::string& cameras, const std::string& images, const std::string& folder) {
    const std::string cameras_file = folder + "/cameras.txt", images_file = folder + "/images.txt";
    const auto all = cameraLines(cameras, cameras_file);
    CameraTrack out;
    std::optional<long> camera;
    std::set<std::string> names;
    Lines lines(images, images_file);
    while (const std::optional<std::string_view> line = lines.next()) {
        if (isBlank(*line)) continue;
        ColmapImage image = takeImage(lines, *line);
        if (camera && *camera != image.camera)
            throw Unsupported(lines.place() + "is of camera " + std::to_string(image.camera) +
                              ", and those before of " + std::to_string(*camera) +
                              ": a track has one camera (--ImageReader.single_camera 1)");
        camera = image.camera;
        if (!names.insert(image.frame.file).second) lines.fail("'" + shown(image.frame.file) + "' occurs twice");
        out.frames.push_back(std::move(image.frame));
        if (out.frames.size() > kMaxImages) lines.fail("more than a million images");
        (void)lines.next();  // the points of the image, of which there may be none
    }
    if (!camera) throw InvalidInput(images_file + ": has no images");
    const auto found = all.find(*camera);
    if (found == all.end()) throw InvalidInput(cameras_file + ": has no camera " + std::to_string(*camera));
    out.camera = takeCamera(found->second.first, found->second.second);
    std::ranges::sort(out.frames, naturallyBefore, &TrackFrame::file);
    return out;
}

CameraTrack readColmapModel(const std::filesystem::path& folder) {
    return parseColmapModel(readJsonText(folder / "cameras.txt"), readJsonText(folder / "images.txt"), folder.string());
}

}  // namespace penumbra
