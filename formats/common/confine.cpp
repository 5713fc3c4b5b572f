#include "formats/common/confine.h"

#include <fcntl.h>
#include <linux/landlock.h>
#include <sched.h>
#include <sys/mount.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cstdint>

namespace penumbra {

namespace {

bool writeFile(const char* path, const std::string& text) {
    const int file = ::open(path, O_WRONLY | O_CLOEXEC);
    if (file < 0) return false;
    const bool whole = ::write(file, text.data(), text.size()) == ssize_t(text.size());
    ::close(file);
    return whole;
}

// Enters namespaces of its own. An ordinary user needs a user namespace for that, in which it keeps its number.
bool leaveNamespaces() {
    const std::string user = std::to_string(::geteuid()), group = std::to_string(::getegid());
    if (::unshare(CLONE_NEWUSER | CLONE_NEWNET | CLONE_NEWNS | CLONE_NEWIPC) != 0)
        return ::unshare(CLONE_NEWNET | CLONE_NEWNS | CLONE_NEWIPC) == 0;
    writeFile("/proc/self/setgroups", "deny");
    writeFile("/proc/self/uid_map", user + " " + user + " 1");
    writeFile("/proc/self/gid_map", group + " " + group + " 1");
    return true;
}

bool makeMountsReadOnly([[maybe_unused]] const std::string& folder) {
#if defined(MOUNT_ATTR_RDONLY) && defined(SYS_mount_setattr)
    if (::mount(nullptr, "/", nullptr, MS_REC | MS_PRIVATE, nullptr) != 0) return false;
    if (::mount(folder.c_str(), folder.c_str(), nullptr, MS_BIND, nullptr) != 0) return false;
    struct {
        std::uint64_t set, clear, propagation, user_namespace;
    } attributes{MOUNT_ATTR_RDONLY, 0, 0, 0};
    if (::syscall(SYS_mount_setattr, AT_FDCWD, "/", 0x8000 /* AT_RECURSIVE */, &attributes, sizeof attributes) != 0)
        return false;
    attributes = {0, MOUNT_ATTR_RDONLY, 0, 0};
    return ::syscall(SYS_mount_setattr, AT_FDCWD, folder.c_str(), 0, &attributes, sizeof attributes) == 0;
#else
    return false;
#endif
}

#ifdef SYS_landlock_create_ruleset
// Lets `rules` grant `access` to a path and what lies below it.
bool allow(int rules, const char* path, std::uint64_t access) {
    landlock_path_beneath_attr beneath{};
    beneath.allowed_access = access;
    beneath.parent_fd = ::open(path, O_PATH | O_CLOEXEC);
    if (beneath.parent_fd < 0) return false;
    const bool done = ::syscall(SYS_landlock_add_rule, rules, LANDLOCK_RULE_PATH_BENEATH, &beneath, 0) == 0;
    ::close(beneath.parent_fd);
    return done;
}
#endif

bool landlock([[maybe_unused]] const std::string& folder) {
#ifdef SYS_landlock_create_ruleset
    constexpr std::uint64_t kWrites = LANDLOCK_ACCESS_FS_WRITE_FILE | LANDLOCK_ACCESS_FS_REMOVE_DIR |
                                      LANDLOCK_ACCESS_FS_REMOVE_FILE | LANDLOCK_ACCESS_FS_MAKE_CHAR |
                                      LANDLOCK_ACCESS_FS_MAKE_DIR | LANDLOCK_ACCESS_FS_MAKE_REG |
                                      LANDLOCK_ACCESS_FS_MAKE_SOCK | LANDLOCK_ACCESS_FS_MAKE_FIFO |
                                      LANDLOCK_ACCESS_FS_MAKE_BLOCK | LANDLOCK_ACCESS_FS_MAKE_SYM;
    const std::uint64_t handled[1] = {kWrites};  // struct landlock_ruleset_attr as its first version has it
    const int rules = int(::syscall(SYS_landlock_create_ruleset, handled, sizeof handled, 0));
    if (rules < 0) return false;
    // Read-only mounts leave devices alone. Here the one that scripts write into must be named.
    allow(rules, "/dev/null", LANDLOCK_ACCESS_FS_WRITE_FILE);
    const bool done = allow(rules, folder.c_str(), kWrites) && ::syscall(SYS_landlock_restrict_self, rules, 0) == 0;
    ::close(rules);
    return done;
#else
    return false;
#endif
}

}  // namespace

Confinement confineTo(const std::string& folder) noexcept {
    ::prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0);
    Confinement confinement;
    confinement.network = leaveNamespaces();
    confinement.folders = (confinement.network && makeMountsReadOnly(folder)) || landlock(folder);
    return confinement;
}

std::string textOf(Confinement confinement) {
    const std::string network = confinement.network ? "no network" : "with the network, which the kernel leaves it";
    return network +
           (confinement.folders ? ", one folder to write into" : ", all folders that the user can write into");
}

}  // namespace penumbra
