#include "formats/common/write_file.h"

#include <fcntl.h>
#include <signal.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <sys/time.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <map>
#include <mutex>
#include <string>

#include "formats/common/errors.h"
#include "formats/common/sha256.h"

namespace penumbra {
namespace {

namespace fs = std::filesystem;

IoError failed(const char* what, const fs::path& path, int error) {
    return IoError(path.string() + ": " + what + ": " + std::strerror(error));
}

// --- What a signal does ---------------------------------------------------------------------------------------------

// The partial files that exist now. The signal handler below reads them and may call async-signal-safe functions
// only.
struct PartialName {
    std::atomic<bool> used{false}, ready{false};
    std::array<char, 4096> path{};
};
std::array<PartialName, 64> partial_names;
std::atomic<int> caught_signal{0};
std::array<char, 128> stop_message{};

}  // namespace

void removeOnStop(const fs::path& partial) {
    const std::string text = fs::absolute(partial).string();
    if (text.size() >= partial_names[0].path.size()) return;  // then only the destructor removes the file
    for (PartialName& name : partial_names)
        if (!name.used.exchange(true)) {
            std::memcpy(name.path.data(), text.c_str(), text.size() + 1);
            name.ready = true;
            return;
        }
}

void keepOnStop(const fs::path& partial) {
    const std::string text = fs::absolute(partial).string();
    for (PartialName& name : partial_names)
        if (name.ready && text == name.path.data()) {
            name.ready = false;
            name.used = false;
            return;
        }
}

namespace {

// Stops here: the loops had 0.5 s to see the flag and did not (a library call that cannot be interrupted).
void stopAtOnce(int) {
    for (PartialName& name : partial_names)
        if (name.ready) ::unlink(name.path.data());
    [[maybe_unused]] const ssize_t written =
        ::write(STDERR_FILENO, stop_message.data(), std::strlen(stop_message.data()));
    ::_exit(kExitFailed);
}

void onSignal(int signal_number) {
    caught_signal = signal_number;
    const itimerval grace{{0, 0}, {0, 500000}};
    ::setitimer(ITIMER_REAL, &grace, nullptr);
}

}  // namespace

void catchSignals(const char* program) {
    std::snprintf(stop_message.data(), stop_message.size(), "%s: stopped by a signal\n", program);
    struct sigaction action {};
    action.sa_handler = onSignal;
    for (int signal_number : {SIGINT, SIGTERM}) ::sigaction(signal_number, &action, nullptr);
    action.sa_handler = stopAtOnce;
    ::sigaction(SIGALRM, &action, nullptr);
    // A full disk, a file size limit and a closed pipe are errors of write(), which are reported, and no reason to
    // die.
    action.sa_handler = SIG_IGN;
    for (int signal_number : {SIGXFSZ, SIGPIPE}) ::sigaction(signal_number, &action, nullptr);
}

bool interrupted() noexcept { return caught_signal != 0; }

void throwIfInterrupted() {
    if (!interrupted()) return;
    throw Interrupted(caught_signal == SIGTERM ? "stopped by SIGTERM" : "stopped by SIGINT");
}

// --- Files ----------------------------------------------------------------------------------------------------------

namespace {

// Returns the file that a chain of symbolic links leads to, which need not exist.
fs::path followLinks(fs::path path) {
    constexpr int kMaxLinks = 40;  // same limit as Linux
    const fs::path given = path;
    std::error_code error;
    for (int i = 0; fs::is_symlink(path, error); ++i) {
        if (i == kMaxLinks) throw failed("cannot write", given, ELOOP);
        const fs::path next = fs::read_symlink(path, error);
        if (error) throw failed("cannot read the link", path, error.value());
        path = path.parent_path() / next;
    }
    return path;
}

constexpr std::size_t kNumberRoom = 15;  // bytes of a process number, "-" and the attempt

fs::path partialPrefix(const fs::path& target) { return pathBeside(target, ".part", kNumberRoom); }

// Removes "TARGET.partPID" files whose writer was killed: no process has that number, and nobody holds the lock. The
// lock covers writers on other hosts and in other containers, whose process numbers mean nothing here.
void sweepStale(const fs::path& target) {
    const std::string prefix = partialPrefix(target).filename().string();
    std::error_code ignored;
    for (const fs::directory_entry& entry : fs::directory_iterator(target.parent_path(), ignored)) {
        const std::string name = entry.path().filename().string();
        if (name.size() == prefix.size() || !name.starts_with(prefix)) continue;
        char* end = nullptr;
        const long pid = std::strtol(name.c_str() + prefix.size(), &end, 10);
        if ((*end != '\0' && *end != '-') || pid <= 0 || ::kill(pid_t(pid), 0) == 0 || errno != ESRCH) continue;
        const int file = ::open(entry.path().c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK);
        if (file < 0) continue;
        if (::flock(file, LOCK_EX | LOCK_NB) == 0) fs::remove(entry.path(), ignored);
        ::close(file);
    }
}

void checkTarget(const fs::path& target) {
    std::error_code error;
    const fs::file_status status = fs::status(target, error);
    if (error == std::errc::filename_too_long) throw failed("cannot write here", target, ENAMETOOLONG);
    // rename() would replace the device or the folder itself.
    if (fs::exists(status) && !fs::is_regular_file(status)) throw IoError(target.string() + ": not a regular file");
    if (!fs::is_directory(target.parent_path(), error))
        throw IoError(target.string() + ": no folder " + target.parent_path().string());
}

// The targets of the partial files that are being written.
struct OpenPartials {
    std::mutex guard;
    std::map<fs::path, fs::path> target_of;
};
OpenPartials& openPartials() {
    static OpenPartials partials;
    return partials;
}

void forget(const fs::path& partial) {
    OpenPartials& partials = openPartials();
    const std::lock_guard lock(partials.guard);
    partials.target_of.erase(partial);
}

}  // namespace

fs::path pathBeside(const fs::path& target, std::string_view ending, std::size_t room) {
    constexpr std::size_t kLongestName = 255, kHash = 16;  // bytes
    const std::string name = target.filename().string();
    const std::size_t most = kLongestName - room - ending.size();
    if (name.size() <= most) return fs::path(target) += ending;
    std::size_t kept = most - kHash - 1;
    while (kept > 0 && (name[kept] & 0xc0) == 0x80) --kept;  // whole UTF-8 characters
    const std::string hash = sha256Hex(std::as_bytes(std::span(name))).substr(0, kHash);
    return target.parent_path() / ((name.substr(0, kept) + "-" + hash) += ending);
}

fs::path targetOfPartial(const fs::path& partial) {
    OpenPartials& partials = openPartials();
    const std::lock_guard lock(partials.guard);
    const auto found = partials.target_of.find(partial);
    return found == partials.target_of.end() ? partial : found->second;
}

PartialFile::PartialFile(fs::path target) {
    if (target.empty() || !target.has_filename()) throw IoError("\"" + target.string() + "\": not a file name");
    target_ = followLinks(std::move(target));
    if (!target_.has_parent_path()) target_ = "." / target_;
    checkTarget(target_);
    sweepStale(target_);
    // The old file may be closed to others, so the new one is from the start.
    std::error_code missing;
    const mode_t mode = fs::exists(target_, missing) ? 0600 : 0666;
    // A second writer here, or a process with the same number on another host, takes the suffix "-2".
    for (int attempt = 1; attempt <= 100; ++attempt) {
        const std::string suffix = attempt == 1 ? "" : "-" + std::to_string(attempt);
        partial_ = partialPrefix(target_).string() + std::to_string(::getpid()) + suffix;
        lock_ = ::open(partial_.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC | O_NOFOLLOW, mode);
        if (lock_ < 0) throw failed("cannot write here", target_, errno);
        if (::flock(lock_, LOCK_EX | LOCK_NB) == 0 || errno != EWOULDBLOCK) break;
        ::close(lock_);
        lock_ = -1;
    }
    if (lock_ < 0) throw IoError(target_.string() + ": too many writers");
    removeOnStop(partial_);
    {
        const std::lock_guard lock(openPartials().guard);
        openPartials().target_of[partial_] = target_;
    }
    if (::ftruncate(lock_, 0) != 0) {
        const int reason = errno;
        discard();
        throw failed("cannot write", target_, reason);
    }
}

PartialFile::~PartialFile() { discard(); }

void PartialFile::discard() noexcept {
    if (lock_ < 0) return;
    ::unlink(partial_.c_str());
    keepOnStop(partial_);
    forget(partial_);
    ::close(lock_);
    lock_ = -1;
}

namespace {

void syncFolder(const fs::path& folder) {
    const int file = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (file < 0) throw failed("cannot open to flush", folder, errno);
    const int result = ::fsync(file), reason = errno;
    ::close(file);
    // EINVAL means a file system that has no fsync for folders.
    if (result != 0 && reason != EINVAL) throw failed("cannot flush to disk", folder, reason);
}

// Gives an open file the owner, the group and the permissions of the target, if there is one. Only root may give files
// away; where a system refuses, the file stays ours, and a group that it cannot have gets what everybody may do. Where
// it refuses permissions, too, the file keeps those that it was made with, which let in nobody but its owner.
void takeOverStatus(int file, const fs::path& target) {
    struct stat old {
    }, now{};
    if (::stat(target.c_str(), &old) != 0 || ::fstat(file, &now) != 0) return;
    mode_t mode = old.st_mode & 0777;
    if (old.st_uid != now.st_uid) (void)!::fchown(file, old.st_uid, gid_t(-1));
    if (old.st_gid != now.st_gid && ::fchown(file, uid_t(-1), old.st_gid) != 0)
        mode = (mode & ~mode_t(070)) | (mode & (mode << 3) & 070);
    if ((now.st_mode & 0777) == mode || ::fchmod(file, mode) == 0) return;
    if (errno != EPERM && errno != EOPNOTSUPP && errno != ENOSYS)
        throw failed("cannot set the permissions", target, errno);
}

}  // namespace

void PartialFile::commit() {
    takeOverStatus(lock_, target_);
    if (::fsync(lock_) != 0) throw failed("cannot flush to disk", target_, errno);
    if (::rename(partial_.c_str(), target_.c_str()) != 0) throw failed("cannot rename to this name", target_, errno);
    keepOnStop(partial_);
    forget(partial_);
    ::close(lock_);
    lock_ = -1;
    syncFolder(target_.parent_path());
}

void writeWholeFile(const fs::path& target, std::span<const std::byte> bytes) {
    PartialFile partial(target);
    const int file = ::open(partial.path().c_str(), O_WRONLY | O_CLOEXEC);
    if (file < 0) throw failed("cannot write", target, errno);
    while (!bytes.empty()) {
        const ssize_t written = ::write(file, bytes.data(), bytes.size());
        if (written < 0 && errno == EINTR) continue;
        if (written < 0) {
            const int reason = errno;
            ::close(file);
            throw failed("cannot write", target, reason);
        }
        bytes = bytes.subspan(std::size_t(written));
    }
    if (::close(file) != 0) throw failed("cannot write", target, errno);
    partial.commit();
}

void writeWholeFile(const fs::path& target, std::string_view text) {
    writeWholeFile(target, std::as_bytes(std::span(text)));
}

}  // namespace penumbra
