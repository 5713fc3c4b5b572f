#pragma once
// Makes sure that a name that exists is a whole file. Outputs are written under a temporary name beside the target,
// flushed, fsynced and renamed. A failure, an exception or a signal leaves neither a partial file nor a changed old
// one.
#include <cstddef>
#include <filesystem>
#include <span>
#include <string_view>

namespace penumbra {

class PartialFile {
public:
    // Makes "TARGET.partPID" beside the target (locked and empty), and removes those that killed writers left. A long
    // name is shortened for it. Where the target is a symbolic link, the file that it leads to is the target, whether
    // that exists yet or not. Throws IoError when the folder cannot be written or the target is no regular file.
    explicit PartialFile(std::filesystem::path target);
    ~PartialFile();  // removes the partial file unless commit() was called
    PartialFile(const PartialFile&) = delete;
    PartialFile& operator=(const PartialFile&) = delete;

    const std::filesystem::path& path() const { return partial_; }  // write here
    // fsync, rename over the target, fsync of the folder; throws IoError. The file takes over the permissions of the
    // one that it replaces, and its owner and group as far as the system allows.
    void commit();

private:
    std::filesystem::path target_, partial_;
    int lock_ = -1;  // descriptor of the partial file while it is ours
    void discard() noexcept;
};

// Returns the path beside `target` whose name is the target's with `ending` behind it. Where that, and `room` bytes
// more, would be longer than the 255 bytes that a name may have, most of the target's name and a hash of all of it
// stand for it.
std::filesystem::path pathBeside(const std::filesystem::path& target, std::string_view ending, std::size_t room = 0);

// Returns the target of a partial file of this process that is being written, for messages; any other path as it is.
std::filesystem::path targetOfPartial(const std::filesystem::path& partial);

void writeWholeFile(const std::filesystem::path& target, std::span<const std::byte> bytes);
void writeWholeFile(const std::filesystem::path& target, std::string_view text);

// From now on SIGINT and SIGTERM only set a flag. Loops call throwIfInterrupted() at least a few times a second,
// which throws Interrupted, so that destructors remove partial files. Where nothing calls it for 0.5 s (a long
// library call), the handler removes the partial files and the process exits with kExitFailed. SIGXFSZ and SIGPIPE
// become errors of write().
void catchSignals(const char* program);  // the name starts the message in the second case
bool interrupted() noexcept;
// Adds another file that is removed in the second case, or takes it off that list.
void removeOnStop(const std::filesystem::path& file);
void keepOnStop(const std::filesystem::path& file);
void throwIfInterrupted();

}  // namespace penumbra
