#include "bake/visibility/bake_journal.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cassert>
#include <cerrno>
#include <cstring>
#include <nlohmann/json.hpp>

#include "formats/common/errors.h"
#include "formats/common/fp16.h"
#include "formats/common/json_depth.h"
#include "formats/common/write_file.h"

namespace penumbra {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kMagic = "PNBJRNL1";
constexpr std::uint64_t kMaxKeyBytes = std::uint64_t(64) << 20;

// Tells a record that was written to its end from one that was not. It is no protection against forgery.
std::uint64_t checksum(std::uint64_t seed, std::span<const std::byte> bytes) {
    std::uint64_t sum = seed ^ (bytes.size() * 0x9e3779b97f4a7c15u);
    for (std::size_t i = 0; i < bytes.size(); i += 8) {
        std::uint64_t word = 0;
        std::memcpy(&word, bytes.data() + i, std::min<std::size_t>(8, bytes.size() - i));
        sum = (sum ^ word) * 0x9e3779b97f4a7c15u;
        sum ^= sum >> 32;
    }
    return sum;
}

// Makes the text that two bakes share when one can go on from the other's frames.
std::string keyOf(const VisibilityHeader& header, std::size_t frame_bytes) {
    nlohmann::ordered_json key;
    key["provenance"] = nlohmann::ordered_json::parse(toJson(header.provenance));
    key["frames"] = header.frames.frameCount();
    key["frame_bytes"] = frame_bytes;
    return key.dump();
}

// Reads all bytes of `out`. Returns false at the end of the file and after an error.
bool readAll(int file, std::uint64_t offset, std::span<std::byte> out) {
    while (!out.empty()) {
        const ssize_t count = ::pread(file, out.data(), out.size(), off_t(offset));
        if (count < 0 && errno == EINTR) continue;
        if (count <= 0) return false;
        offset += std::uint64_t(count);
        out = out.subspan(std::size_t(count));
    }
    return true;
}

// Writes all bytes. Returns false after an error, such as a full disk.
bool writeAll(int file, std::uint64_t offset, std::span<const std::byte> bytes) {
    while (!bytes.empty()) {
        const ssize_t count = ::pwrite(file, bytes.data(), bytes.size(), off_t(offset));
        if (count < 0 && errno == EINTR) continue;
        if (count < 0) return false;
        offset += std::uint64_t(count);
        bytes = bytes.subspan(std::size_t(count));
    }
    return true;
}

}  // namespace

BakeJournal::BakeJournal(const fs::path& output, const VisibilityHeader& header, Precision precision, Journal use)
    : path_(pathBeside(output, ".journal")), precision_(precision), keep_(use == Journal::kResume) {
    frame_bytes_ =
        header.mesh.vertexCount() * header.coefficientsOfVertex() * (precision == Precision::kFloat16 ? 2u : 4u) +
        (header.hasBounces() ? 2 * sizeof(float) : 0);
    open(use);
    if (file_ < 0) return;
    if (!keep_) removeOnStop(path_);
    const std::string key = keyOf(header, frame_bytes_);
    std::error_code error;
    if (use == Journal::kFresh) {
        if (fs::file_size(path_, error) > 0)
            note_ = path_.string() + ": discarded; a bake that resumes goes on from what a killed one left";
        start(key);
        return;
    }
    const std::string problem = adopt(key);
    if (!problem.empty()) note_ = path_.string() + ": " + problem + ": all frames are traced anew";
    frames_ = kept_;
    if (kept_ == 0) start(key);
}

// Opens and locks the file. Tries again when the file's owner removes it at just that moment.
void BakeJournal::open(Journal use) {
    for (int attempt = 0; attempt < 100; ++attempt) {
        file_ = ::open(path_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0666);
        if (file_ < 0) throw IoError(path_.string() + ": cannot write: " + std::strerror(errno));
        if (::flock(file_, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) {
            ::close(file_);
            file_ = -1;
            if (use == Journal::kResume) throw IoError(path_.string() + ": another bake is writing this output");
            note_ = path_.string() + ": another bake is writing this output; whoever ends last replaces it";
            return;
        }
        struct stat open_file {
        }, named{};
        if (::fstat(file_, &open_file) == 0 && ::stat(path_.c_str(), &named) == 0 && open_file.st_ino == named.st_ino &&
            open_file.st_dev == named.st_dev) {
            if (S_ISREG(open_file.st_mode)) return;
            ::close(file_);
            file_ = -1;
            throw IoError(path_.string() + ": not a regular file");
        }
        ::close(file_);  // its owner removed it between the two calls
        file_ = -1;
    }
    throw IoError(path_.string() + ": cannot write");
}

namespace {

// Tells why a journal with the key `found` belongs to another bake.
std::string whyForeign(const std::string& found, const std::string& key) try {
    if (nestedTooDeep(found)) return "of another bake";
    const auto parse = [](const std::string& text) {
        return provenanceFromJson(nlohmann::ordered_json::parse(text).at("provenance").dump());
    };
    std::string text = "of another bake";
    for (const std::string& difference : differencesOf(parse(found), parse(key), {}))
        text += (text.ends_with("bake") ? " (" : ", ") + difference;
    return text.ends_with("bake") ? text : text + ")";
} catch (const std::exception&) {
    return "of another bake";
}

}  // namespace

// Counts the whole frames of the file into kept_. Returns what speaks against going on from them, or "".
std::string BakeJournal::adopt(const std::string& key) {
    std::vector<std::byte> head(kMagic.size() + 8);
    if (!readAll(file_, 0, head)) return "";  // the file is new, or its bake was killed in its first moments
    std::uint64_t key_bytes = 0, sum = 0;
    std::memcpy(&key_bytes, head.data() + kMagic.size(), 8);
    struct stat status {};
    if (::fstat(file_, &status) != 0 || std::memcmp(head.data(), kMagic.data(), kMagic.size()) != 0 ||
        key_bytes > kMaxKeyBytes || key_bytes > std::uint64_t(status.st_size))
        return "is no journal of a bake";
    std::vector<std::byte> found(key_bytes + 8);
    if (!readAll(file_, head.size(), found)) return "";
    std::memcpy(&sum, found.data() + key_bytes, 8);
    const std::span<const std::byte> bytes = std::span(found).first(key_bytes);
    if (sum != checksum(0, bytes)) return "";
    const std::string text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    if (text != key) return whyForeign(text, key);
    records_begin_ = head.size() + found.size();
    const std::size_t most = nlohmann::json::parse(key)["frames"];
    while (kept_ < most && readRecord(kept_, record_)) ++kept_;
    return "";
}

// Reads one frame with its checksum. Returns false unless the frame is whole.
bool BakeJournal::readRecord(std::size_t frame, std::vector<std::byte>& record) const {
    record.resize(frame_bytes_ + 8);
    if (!readAll(file_, records_begin_ + frame * record.size(), record)) return false;
    std::uint64_t sum = 0;
    std::memcpy(&sum, record.data() + frame_bytes_, 8);
    return sum == checksum(frame + 1, std::span(record).first(frame_bytes_));
}

// Empties the file and writes the head of a new journal.
void BakeJournal::start(const std::string& key) {
    kept_ = frames_ = 0;
    std::vector<std::byte> head(kMagic.size() + 8 + key.size() + 8);
    const std::uint64_t key_bytes = key.size(), sum = checksum(0, std::as_bytes(std::span(key)));
    std::memcpy(head.data(), kMagic.data(), kMagic.size());
    std::memcpy(head.data() + kMagic.size(), &key_bytes, 8);
    std::memcpy(head.data() + kMagic.size() + 8, key.data(), key.size());
    std::memcpy(head.data() + head.size() - 8, &sum, 8);
    records_begin_ = head.size();
    if (::ftruncate(file_, 0) != 0 || !writeAll(file_, 0, head)) full_ = true;
}

namespace {

// Takes values from the front of a record. Returns the rest of the record.
std::span<const std::byte> takeFloats(std::span<const std::byte> record, Precision precision, std::span<float> values) {
    if (values.empty()) return record;
    if (precision == Precision::kFloat32) {
        std::memcpy(values.data(), record.data(), values.size_bytes());
        return record.subspan(values.size_bytes());
    }
    std::vector<std::uint16_t> halves(values.size());
    std::memcpy(halves.data(), record.data(), 2 * halves.size());
    halfToFloat(halves, values);
    return record.subspan(2 * halves.size());
}

// Puts values at the front of a record. Returns the rest of the record.
std::span<std::byte> putFloats(std::span<const float> values, Precision precision, std::span<std::byte> record) {
    if (values.empty()) return record;
    if (precision == Precision::kFloat32) {
        std::memcpy(record.data(), values.data(), values.size_bytes());
        return record.subspan(values.size_bytes());
    }
    std::vector<std::uint16_t> halves(values.size());
    floatToHalf(values, halves);
    std::memcpy(record.data(), halves.data(), 2 * halves.size());
    return record.subspan(2 * halves.size());
}

}  // namespace

void BakeJournal::read(std::size_t frame, VisibilityFrame& out) const {
    assert(frame < kept_);
    std::vector<std::byte> record;
    if (!readRecord(frame, record)) throw IoError(path_.string() + ": changed while it was read");
    std::span<const std::byte> rest = takeFloats(record, precision_, out.coefficients);
    rest = takeFloats(rest, precision_, out.local_coefficients);
    rest = takeFloats(rest, precision_, out.indirect);
    takeFloats(rest, Precision::kFloat32, out.hit_shares);
}

void BakeJournal::append(const VisibilityFrame& frame) {
    if (file_ < 0 || full_) return;
    record_.resize(frame_bytes_ + 8);
    std::span<std::byte> rest = putFloats(frame.coefficients, precision_, record_);
    rest = putFloats(frame.local_coefficients, precision_, rest);
    rest = putFloats(frame.indirect, precision_, rest);
    putFloats(frame.hit_shares, Precision::kFloat32, rest);
    const std::uint64_t sum = checksum(frames_ + 1, std::span(record_).first(frame_bytes_));
    std::memcpy(record_.data() + frame_bytes_, &sum, 8);
    if (writeAll(file_, records_begin_ + frames_ * record_.size(), record_)) {
        ++frames_;
        return;
    }
    full_ = true;
    if (!keep_) drop();  // leaves the room on the disk to the output
}

void BakeJournal::finish() {
    keep_ = false;
    drop();
}

// Lets go of the file: removes it unless it is to be kept and holds a frame.
void BakeJournal::drop() noexcept {
    if (file_ < 0) return;
    if (!keep_ || frames_ == 0) ::unlink(path_.c_str());
    keepOnStop(path_);
    ::close(file_);
    file_ = -1;
}

BakeJournal::~BakeJournal() { drop(); }

}  // namespace penumbra
