// Reads BVH, the plain format of motion capture (Biovision): a hierarchy of joints with offsets, then a line of channel
// values for each frame. Meredith and Maddock, "Motion Capture File Formats Explained" (2001), describe it.
//
// - The rotations of a joint are applied in the order of its channels, the first one outermost: R = R1 R2 R3.
// - A position channel replaces that axis of the joint's OFFSET. MotionBuilder and Blender write such files; at a root
//   with OFFSET 0 other readers agree.
// - BVH states no unit and no axes. Lengths are read as they are. addClips() multiplies them by the ratio of the two
//   skeletons' sizes, so that a unit has no effect, and finds the axes by the bones (rig_axes.h).
// - Between frames rotations turn the short way at an even speed, and positions are linear.
#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <fstream>
#include <utility>

#include "formats/common/check_readable.h"
#include "formats/common/errors.h"
#include "formats/rig/rig_build.h"
#include "sh/angles.h"

namespace penumbra {

namespace {

constexpr std::size_t kMaxBvhJoints = 65535;
constexpr std::size_t kMaxBvhValues = std::size_t(1) << 27;  // 500 MB of channel values
constexpr std::uintmax_t kMaxBvhBytes = std::uintmax_t(1) << 31;

// A channel is an axis (0 to 2) of a position or a rotation.
struct BvhChannel {
    int joint = 0;
    bool rotates = false;
    std::size_t axis = 0;
};

class BvhReader {
public:
    BvhReader(const std::filesystem::path& path, std::string text) : text_(std::move(text)) {
        source_.file = path;
        source_.axes = SourceAxes::kUnstated;
        source_.files_read = {path};
    }

    RigSource read() {
        if (text_.rfind("\xef\xbb\xbf", 0) == 0) at_ = 3;
        expect("hierarchy");
        do readRoot();
        while (peek() == "root");
        expect("motion");
        readMotion();
        return std::move(source_);
    }

private:
    RigSource source_;
    std::string text_;
    std::size_t at_ = 0;
    std::vector<BvhChannel> channels_;

    [[noreturn]] void fail(const std::string& problem) const {
        const auto line = 1 + std::count(text_.begin(), text_.begin() + std::ptrdiff_t(at_), '\n');
        failAtFile(source_.file, "line " + std::to_string(line) + ": " + problem);
    }

    static bool isSpace(char c) { return c == ' ' || (c >= '\t' && c <= '\r'); }

    // Returns where the word ends that begins here. A brace is a word of its own.
    std::size_t wordEnd() const {
        const auto is_brace = [&](std::size_t i) { return text_[i] == '{' || text_[i] == '}'; };
        if (at_ < text_.size() && is_brace(at_)) return at_ + 1;
        std::size_t end = at_;
        while (end < text_.size() && !isSpace(text_[end]) && !is_brace(end)) ++end;
        return end;
    }

    // Goes to the next word and returns its first 64 letters, as small ones. At the end it returns "".
    std::string peek() {
        while (at_ < text_.size() && isSpace(text_[at_])) ++at_;
        std::string word = text_.substr(at_, std::min<std::size_t>(wordEnd() - at_, 64));
        for (char& c : word) c = char(std::tolower(static_cast<unsigned char>(c)));
        return word;
    }

    std::string take() {
        std::string word = peek();
        if (word.empty()) fail("the file ends too early");
        at_ = wordEnd();
        return word;
    }

    void expect(const std::string& word) {
        const std::string found = peek();
        if (found != word && found != word + ":")
            fail(found.empty() ? "the file ends where '" + word + "' should stand"
                               : "'" + found + "' stands where '" + word + "' should");
        take();
        if (found == word && peek() == ":") take();
    }

    double number() {
        peek();  // to the number
        double value = 0;
        const char *first = text_.data() + at_, *end = text_.data() + text_.size();
        if (first != end && *first == '+') ++first;
        const auto [last, error] = std::from_chars(first, end, value);
        if (error != std::errc() || (last != end && !isSpace(*last))) fail("'" + peek() + "' is not a number");
        if (!(std::abs(value) < 1e30)) fail("a number is not finite");
        at_ = std::size_t(last - text_.data());
        return value;
    }

    // Returns the rest of the line up to a brace, which is a joint's name and may have blanks.
    std::string name() {
        const std::size_t end = std::min(text_.find_first_of("{\r\n", at_), text_.size());
        std::string text = text_.substr(at_, end - at_);
        at_ = end;
        const auto from = std::find_if_not(text.begin(), text.end(), isSpace);
        text.erase(text.begin(), from);
        while (!text.empty() && isSpace(text.back())) text.pop_back();
        return text.empty() ? "node" + std::to_string(source_.nodes.size()) : cleanText(text);
    }

    int addNode(const std::string& name, int parent) {
        if (source_.nodes.size() >= kMaxBvhJoints) throw Unsupported(source_.file.string() + ": too many joints");
        Node node;
        node.name = name;
        node.parent = parent;
        source_.nodes.push_back(std::move(node));
        return int(source_.nodes.size()) - 1;
    }

    void readOffset(int joint) {
        for (double& v : source_.nodes[std::size_t(joint)].translation) v = number();
    }

    void readChannels(int joint) {
        const double count = number();
        if (!(count >= 0 && count <= 6) || count != std::floor(count)) fail("a joint has 0 to 6 channels");
        bool taken[2][3] = {};
        for (int i = 0; i < int(count); ++i) {
            const std::string word = take();
            const std::size_t axis = std::string("xyz").find(word[0]);
            const std::string kind = word.substr(1);
            if (axis == std::string::npos || (kind != "position" && kind != "rotation"))
                fail("'" + word + "' is not a channel");
            const bool rotates = kind == "rotation";
            if (std::exchange(taken[rotates][axis], true)) fail("channel '" + word + "' occurs twice");
            channels_.push_back({joint, rotates, axis});
        }
    }

    void readRoot() {
        expect("root");
        std::vector<int> open{addNode(name(), -1)};
        expect("{");
        while (!open.empty()) {
            const std::string word = take();
            if (word == "offset") {
                readOffset(open.back());
            } else if (word == "channels") {
                readChannels(open.back());
            } else if (word == "joint") {
                open.push_back(addNode(name(), open.back()));
                expect("{");
            } else if (word == "end") {
                name();  // "Site"
                open.push_back(addNode(source_.nodes[std::size_t(open.back())].name + "_end", open.back()));
                expect("{");
            } else if (word == "}") {
                open.pop_back();
            } else {
                fail("'" + word + "' is not known here");
            }
        }
    }

    void readMotion() {
        expect("frames");
        const double frames = number();
        if (!(frames >= 1 && frames <= 1e9) || frames != std::floor(frames)) fail("the number of frames is wrong");
        expect("frame");
        expect("time");
        const double frame_time = number();
        if (!(frame_time > 0) && frames > 1) fail("the frame time is not above 0");
        if (channels_.empty()) fail("no joint has a channel");
        if (frames * double(channels_.size()) > double(kMaxBvhValues))
            throw Unsupported(source_.file.string() + ": too many frames");
        makeClip(std::size_t(frames), std::max(frame_time, 0.0));
        if (!peek().empty()) fail("values follow the last frame");
    }

    void makeClip(std::size_t frames, double frame_time) {
        Clip clip;
        clip.name = cleanText(source_.file.stem().string());
        clip.duration = double(frames - 1) * frame_time;
        std::vector<std::array<int, 2>> channel_of(source_.nodes.size(), {-1, -1});
        for (const BvhChannel& c : channels_) {
            int& channel = channel_of[std::size_t(c.joint)][c.rotates];
            if (channel >= 0) continue;
            channel = int(clip.channels.size());
            clip.channels.push_back({c.joint,
                                     c.rotates ? Channel::Path::kRotation : Channel::Path::kTranslation,
                                     Interpolation::kLinear,
                                     {},
                                     {}});
        }
        for (Channel& channel : clip.channels)
            for (std::size_t f = 0; f < frames; ++f) channel.times.push_back(double(f) * frame_time);
        for (std::size_t f = 0; f < frames; ++f) readFrame(f, frames, channel_of, clip);
        source_.clips.push_back(std::move(clip));
    }

    void readFrame(std::size_t frame, std::size_t frames, const std::vector<std::array<int, 2>>& channel_of,
                   Clip& clip) {
        std::vector<std::array<double, 3>> positions;
        std::vector<Quaternion> rotations(source_.nodes.size(), {0, 0, 0, 1});
        for (const Node& node : source_.nodes) positions.push_back(node.translation);
        for (const BvhChannel& c : channels_) {
            if (peek().empty())
                fail("the file ends in frame " + std::to_string(frame + 1) + " of " + std::to_string(frames));
            const double value = number();
            const std::size_t joint = std::size_t(c.joint);
            if (c.rotates) {
                Quaternion turn{0, 0, 0, std::cos(radians(value) / 2)};
                turn[c.axis] = std::sin(radians(value) / 2);
                rotations[joint] = multiply(rotations[joint], turn);
            } else {
                positions[joint][c.axis] = value;
            }
        }
        for (std::size_t n = 0; n < source_.nodes.size(); ++n) {
            const auto append = [&](int channel, const auto& numbers) {
                if (channel < 0) return;
                std::vector<float>& values = clip.channels[std::size_t(channel)].values;
                for (const double v : numbers) values.push_back(float(v));
            };
            append(channel_of[n][0], positions[n]);
            append(channel_of[n][1], rotations[n]);
        }
    }
};

}  // namespace

RigSource readBvh(const std::filesystem::path& path) {
    checkReadable(path);
    std::error_code error;
    const std::uintmax_t size = std::filesystem::file_size(path, error);
    if (!error && size == 0) failAtFile(path, "is empty");
    if (!error && size > kMaxBvhBytes) throw Unsupported(path.string() + ": is larger than any BVH file");
    std::ifstream in(path, std::ios::binary);
    std::string text((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
    if (in.bad()) throw IoError("cannot read " + path.string());
    return BvhReader(path, std::move(text)).read();
}

}  // namespace penumbra
