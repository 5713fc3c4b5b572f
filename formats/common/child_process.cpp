// Runs work that may crash in a process of its own: a library that reads files of strangers may abort, write beyond its
// arrays, or never return. Then the program goes on and says which file it was.
//
// Our own code runs after fork() without exec, so no helper program has to be installed and found. The child works on a
// copy of this process' memory, writes its result into a pipe and ends with _exit(), which runs no destructor and
// flushes no stream of the parent. A process with threads may do so, because the child needs no other thread: `work`
// starts none, takes no lock of ours, and glibc makes its own (those of malloc and of streams) usable in the child.
// Other programs are started from such a child, once it has confined itself.
#include "formats/common/child_process.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <new>
#include <span>
#include <string>
#include <type_traits>
#include <utility>

#include "formats/common/errors.h"
#include "formats/common/write_file.h"

namespace penumbra {

namespace {

// The child first writes a header. As many bytes as it says follow: the result, or the text of an error.
enum class Answer : std::uint64_t { kResult, kUsageError, kIoError, kInvalidInput, kUnsupported, kOtherError };
struct Header {
    Answer kind;
    std::uint64_t size;
};
static_assert(std::has_unique_object_representations_v<Header>);  // no padding, which would be written unset

constexpr int kOutOfMemory = 99;  // exit status of the child

// --- The child ------------------------------------------------------------------------------------------------------

void writeAll(int pipe, std::span<const std::byte> bytes) {
    while (!bytes.empty()) {
        const ssize_t written = ::write(pipe, bytes.data(), bytes.size());
        if (written < 0 && errno == EINTR) continue;
        if (written < 0) ::_exit(1);  // the parent is gone
        bytes = bytes.subspan(std::size_t(written));
    }
}

void answer(int pipe, Answer kind, std::span<const std::byte> bytes) {
    const Header header{kind, bytes.size()};
    writeAll(pipe, std::as_bytes(std::span(&header, 1)));
    writeAll(pipe, bytes);
}

void answer(int pipe, Answer kind, const std::exception& error) {
    answer(pipe, kind, std::as_bytes(std::span(error.what(), std::strlen(error.what()))));
}

void lower(decltype(RLIMIT_AS) which, rlim_t most) {
    rlimit limit{};
    ::getrlimit(which, &limit);
    limit.rlim_cur = std::min(most, limit.rlim_max);
    ::setrlimit(which, &limit);
}

// Returns the bytes of address space that this process has now, 0 where the system does not tell. Sanitizers take
// terabytes of it.
std::uint64_t addressSpace() {
    std::uint64_t pages = 0;
    std::ifstream("/proc/self/statm") >> pages;
    return pages * std::uint64_t(::sysconf(_SC_PAGESIZE));
}

void setLimits(const ChildLimits& limits) {
    if (const std::uint64_t now = addressSpace(); now > 0) lower(RLIMIT_AS, now + limits.bytes);
    lower(RLIMIT_CPU, rlim_t(std::ceil(limits.seconds)) + 1);  // the parent's clock comes first, unless it is gone
    lower(RLIMIT_CORE, 0);
    ::prctl(PR_SET_DUMPABLE, 0);  // no core either where the system hands cores to a program
    std::set_new_handler([] { ::_exit(kOutOfMemory); });
}

// The parent alone answers signals that stop the program: it kills the child. It ends with the parent in any case.
void leaveSignalsToParent(pid_t parent) {
    for (const int number : {SIGINT, SIGTERM}) ::signal(number, SIG_IGN);
    for (const int number : {SIGALRM, SIGPIPE, SIGXFSZ, SIGXCPU}) ::signal(number, SIG_DFL);
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (::getppid() != parent) ::_exit(1);
}

void printNothing() {
    const int nowhere = ::open("/dev/null", O_WRONLY | O_CLOEXEC);
    for (const int stream : {STDOUT_FILENO, STDERR_FILENO}) ::dup2(nowhere, stream);
}

// An exception of another kind than these aborts the child, as noexcept has it.
[[noreturn]] void runChild(int pipe, pid_t parent, const std::function<std::vector<std::byte>()>& work,
                           const ChildLimits& limits) noexcept {
    leaveSignalsToParent(parent);
    printNothing();
    setLimits(limits);
    try {
        answer(pipe, Answer::kResult, work());
    } catch (const UsageError& error) {
        answer(pipe, Answer::kUsageError, error);
    } catch (const IoError& error) {
        answer(pipe, Answer::kIoError, error);
    } catch (const InvalidInput& error) {
        answer(pipe, Answer::kInvalidInput, error);
    } catch (const Unsupported& error) {
        answer(pipe, Answer::kUnsupported, error);
    } catch (const std::bad_alloc&) {
        ::_exit(kOutOfMemory);
    } catch (const std::exception& error) {
        answer(pipe, Answer::kOtherError, error);
    }
    ::_exit(0);
}

// --- The parent -----------------------------------------------------------------------------------------------------

using Clock = std::chrono::steady_clock;

// The child, with the end of the pipe that we read. It is killed and reaped in any case.
class Child {
public:
    Child(pid_t process, int pipe) : process_(process), pipe_(pipe) {}
    ~Child() { end(); }
    Child(const Child&) = delete;
    Child& operator=(const Child&) = delete;

    // Kills the child, and its group of processes if it leads one, where they still run. Returns the child's status,
    // as waitpid() has it.
    int end() {
        if (pipe_ < 0) return status_;
        ::close(pipe_);
        pipe_ = -1;
        ::kill(-process_, SIGKILL);
        ::kill(process_, SIGKILL);  // does nothing to a child that is ending: its status is set before its pipe closes
        while (::waitpid(process_, &status_, 0) < 0 && errno == EINTR) {
        }
        return status_;
    }

    // Same as end(), but a child that has closed its pipe may end by itself until the deadline.
    int endItself(Clock::time_point deadline) {
        siginfo_t ended{};
        while (Clock::now() < deadline) {
            throwIfInterrupted();
            ended.si_pid = 0;
            if (::waitid(P_PID, id_t(process_), &ended, WEXITED | WNOHANG | WNOWAIT) != 0 || ended.si_pid != 0) break;
            ::poll(nullptr, 0, 2);
        }
        return end();
    }

    // Reads until `out` is full, the child closes the pipe or the deadline passes. Returns how many bytes came.
    std::size_t read(std::span<std::byte> out, Clock::time_point deadline) {
        std::size_t count = 0;
        while (count < out.size()) {
            throwIfInterrupted();
            const auto left = std::chrono::ceil<std::chrono::milliseconds>(deadline - Clock::now()).count();
            if (left <= 0) break;
            pollfd waiting{pipe_, POLLIN, 0};
            if (::poll(&waiting, 1, int(std::min<long long>(left, 100))) <= 0) continue;
            const ssize_t got = ::read(pipe_, out.data() + count, out.size() - count);
            if (got < 0 && errno == EINTR) continue;
            if (got <= 0) break;
            count += std::size_t(got);
        }
        return count;
    }

private:
    pid_t process_;
    int pipe_, status_ = 0;
};

// `body` runs in the child with the end of the pipe that it writes and the parent's number. It does not return.
Child start(const std::function<void(int pipe, pid_t parent)>& body) {
    std::array<int, 2> pipe{};
    if (::pipe2(pipe.data(), O_CLOEXEC) != 0) throw std::runtime_error(std::string("pipe: ") + std::strerror(errno));
    const auto fail = [&](const char* what) {
        const int reason = errno;
        for (const int end : pipe) ::close(end);
        throw std::runtime_error(std::string(what) + ": " + std::strerror(reason));
    };
    // Where this program's standard streams are closed, the pipe got their numbers, which printNothing() takes over.
    for (int& end : pipe) {
        if (end > STDERR_FILENO) continue;
        const int moved = ::fcntl(end, F_DUPFD_CLOEXEC, STDERR_FILENO + 1);
        if (moved < 0) fail("pipe");
        ::close(end);
        end = moved;
    }
    const pid_t parent = ::getpid(), process = ::fork();
    if (process < 0) fail("fork");
    if (process == 0) {
        ::close(pipe[0]);
        body(pipe[1], parent);
        ::_exit(1);
    }
    ::close(pipe[1]);
    return Child(process, pipe[0]);
}

// Tells why there is no whole answer.
[[noreturn]] void failChild(Child& child, const ChildLimits& limits, Clock::time_point deadline) {
    const bool late = Clock::now() >= deadline;
    const int status = child.end();
    if (late || (WIFSIGNALED(status) && WTERMSIG(status) == SIGXCPU))
        throw ChildFailed("out of time: more than " + std::to_string(std::lround(limits.seconds)) + " s");
    if (WIFEXITED(status) && WEXITSTATUS(status) == kOutOfMemory)
        throw ChildFailed("out of memory: more than " + std::to_string(limits.bytes >> 20) + " MiB");
    if (!WIFSIGNALED(status)) throw ChildFailed("it ended without a result");
    const int number = WTERMSIG(status);
    throw ChildFailed("signal " + std::to_string(number) + " (" + ::strsignal(number) + ")");
}

// Throws what the child caught, with its kind.
[[noreturn]] void throwAgain(Answer kind, std::span<const std::byte> bytes) {
    const std::string text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    switch (kind) {
        case Answer::kUsageError:
            throw UsageError(text);
        case Answer::kIoError:
            throw IoError(text);
        case Answer::kInvalidInput:
            throw InvalidInput(text);
        case Answer::kUnsupported:
            throw Unsupported(text);
        default:
            throw std::runtime_error(text);
    }
}

}  // namespace

// --- Programs of others ---------------------------------------------------------------------------------------------

namespace {

constexpr std::size_t kMaxOutput = std::size_t(1) << 20;
constexpr rlim_t kLargestFile = rlim_t(4) << 30;  // limit for a .glb

std::vector<std::string> environmentOf(const ProgramCall& call) {
    std::vector<std::string> lines = {"HOME=" + call.folder.string(), "TMPDIR=" + call.folder.string()};
    for (const char* name : {"PATH", "LD_LIBRARY_PATH"})
        if (const char* value = std::getenv(name)) lines.push_back(std::string(name) + "=" + value);
    return lines;
}

std::vector<char*> pointersTo(std::vector<std::string>& texts) {
    std::vector<char*> pointers;
    for (std::string& text : texts) pointers.push_back(text.data());
    pointers.push_back(nullptr);
    return pointers;
}

// The first bytes that a child writes before it becomes the program. Where it does not, the error number follows.
struct Start {
    std::uint8_t network, folders;
};
struct Failure {
    std::int32_t error;
};

// Becomes the program, whose output goes to `pipe`.
[[noreturn]] void becomeProgram(int pipe, int failures, pid_t parent, const ProgramCall& call) noexcept {
    ::setpgid(0, 0);
    leaveSignalsToParent(parent);
    std::vector<std::string> command = call.command, environment = environmentOf(call);
    lower(RLIMIT_AS, call.limits.bytes);
    lower(RLIMIT_CPU, rlim_t(std::ceil(call.limits.seconds)) + 1);
    lower(RLIMIT_CORE, 0);
    lower(RLIMIT_FSIZE, kLargestFile);
    const Confinement confinement = confineTo(call.folder.string());
    const Start header{confinement.network, confinement.folders};
    writeAll(pipe, std::as_bytes(std::span(&header, 1)));
    const int nothing = ::open("/dev/null", O_RDONLY | O_CLOEXEC);
    ::dup2(nothing, STDIN_FILENO);
    for (const int stream : {STDOUT_FILENO, STDERR_FILENO}) ::dup2(pipe, stream);
    if (::chdir((call.working_folder.empty() ? call.folder : call.working_folder).c_str()) == 0)
        ::execve(command.front().c_str(), pointersTo(command).data(), pointersTo(environment).data());
    const Failure failure{errno};
    writeAll(failures, std::as_bytes(std::span(&failure, 1)));
    ::_exit(127);
}

// Reads what the program writes, to the end, and keeps the first MiB of it.
std::string readOutput(Child& child, Clock::time_point deadline) {
    std::string output;
    std::array<std::byte, 4096> block;
    for (std::size_t count = block.size(); count == block.size();) {
        count = child.read(block, deadline);
        const auto* text = reinterpret_cast<const char*>(block.data());
        output.append(text, std::min(count, kMaxOutput - output.size()));
    }
    return output;
}

// A pipe that exec closes.
struct Pipe {
    std::array<int, 2> ends{-1, -1};

    Pipe() {
        if (::pipe2(ends.data(), O_CLOEXEC) != 0)
            throw std::runtime_error(std::string("pipe: ") + std::strerror(errno));
    }
    Pipe(const Pipe&) = delete;
    Pipe& operator=(const Pipe&) = delete;
    ~Pipe() {
        for (const int end : ends) ::close(end);
    }
    // Returns the error that the child could not start with, 0 where it could. Call it when the child is gone.
    int failure() {
        ::close(std::exchange(ends[1], -1));
        Failure failure{0};
        return ::read(ends[0], &failure, sizeof failure) == ssize_t(sizeof failure) ? failure.error : 0;
    }
};

}  // namespace

ProgramResult runProgram(const ProgramCall& call) {
    const Clock::time_point deadline =
        Clock::now() + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(call.limits.seconds));
    Pipe failures;
    Child child = start([&](int pipe, pid_t parent) { becomeProgram(pipe, failures.ends[1], parent, call); });
    Start header{};
    if (child.read(std::as_writable_bytes(std::span(&header, 1)), deadline) < sizeof header)
        failChild(child, call.limits, deadline);
    ProgramResult result;
    result.confinement = {header.network != 0, header.folders != 0};
    result.output = readOutput(child, deadline);
    if (Clock::now() >= deadline) failChild(child, call.limits, deadline);
    const int status = child.endItself(deadline);
    if (Clock::now() >= deadline) failChild(child, call.limits, deadline);
    if (const int error = failures.failure(); error != 0)
        throw ChildFailed("cannot be started: " + std::string(std::strerror(error)));
    if (!WIFEXITED(status)) failChild(child, call.limits, deadline);
    result.status = WEXITSTATUS(status);
    return result;
}

std::vector<std::byte> runInChild(const std::function<std::vector<std::byte>()>& work, const ChildLimits& limits) {
    const Clock::time_point deadline =
        Clock::now() + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(limits.seconds));
    Child child = start([&](int pipe, pid_t parent) { runChild(pipe, parent, work, limits); });
    Header header{};
    if (child.read(std::as_writable_bytes(std::span(&header, 1)), deadline) < sizeof header)
        failChild(child, limits, deadline);
    if (header.kind > Answer::kOtherError || header.size > limits.bytes) throw ChildFailed("it handed back nonsense");
    // The buffer grows with what comes, because the length that the child names may be wrong.
    std::vector<std::byte> bytes;
    while (bytes.size() < header.size) {
        const std::size_t had = bytes.size();
        bytes.resize(std::min<std::uint64_t>(header.size, 2 * had + (std::size_t(1) << 16)));
        if (child.read(std::span(bytes).subspan(had), deadline) < bytes.size() - had)
            failChild(child, limits, deadline);
    }
    if (header.kind != Answer::kResult) throwAgain(header.kind, bytes);
    return bytes;
}

}  // namespace penumbra
