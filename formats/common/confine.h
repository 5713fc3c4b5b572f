#pragma once
// Takes from this process and all that it starts what a program that reads files of strangers has no use for.
#include <string>

namespace penumbra {

struct Confinement {
    bool network = false;  // it has no network
    bool folders = false;  // it can write into one folder alone
};

// Confines this process for good, as far as the kernel and the system's rules allow: user, network and mount
// namespaces (unshare(2)) where every mount but `folder` is read-only, else Landlock. Call it in a child that has one
// thread. Namespaces of mounts begin to count with the next chdir(). `folder` is absolute. Never fails: what it could
// not take it tells.
Confinement confineTo(const std::string& folder) noexcept;

// "no network, one folder to write into", or what of it is missing.
std::string textOf(Confinement confinement);

}  // namespace penumbra
