#pragma once
// Tells what the keyboard does. The keys, the help of F1 and the tests all read this one table.
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "player/view/view_state.h"

namespace penumbra {

// GLFW's numbers. Printable keys have the code of their capital ASCII character.
enum Key : int {
    kKeyTab = 258,
    kKeyRight = 262,
    kKeyLeft = 263,
    kKeyDown = 264,
    kKeyUp = 265,
    kKeyPageUp = 266,
    kKeyPageDown = 267,
    kKeyHome = 268,
    kKeyBackspace = 259,
    kKeyF1 = 290,
    kKeyF2 = 291,
    kKeyF11 = 300,
    kKeyF12 = 301,
    kKeyEscape = 256,
};
struct KeyPress {
    int key = 0;
    bool shift = false;
};

struct Shortcut {
    int key;
    std::string_view name, shifted;  // name of the key, and what Shift does: "" = the same as without
    std::string_view text;
    void (*apply)(ViewState& state, const Scene& scene, KeyPress press);
    std::string_view needs = {};  // without which it changes nothing
    // Says where the change shows, where the picture that is on does not show it; empty where it does. Null: always.
    std::string_view (*unseen)(const Scene& scene, const ViewState& state) = nullptr;
};
std::span<const Shortcut> shortcuts();

// Shows the files of the folder that the last one came from, beside the picture. Nothing else is listed then.
void browseFiles(ViewState& state);

// Does what the key stands for; returns false when it stands for nothing.
bool applyKey(ViewState& state, const Scene& scene, KeyPress press);
// Says why a key changed nothing: that it stands for nothing, or what it needs. Empty for a key that writes nothing, as
// Shift.
std::string whyNothing(KeyPress press);
// Says why the picture does not show what a key has just changed. Empty where it does.
std::string whyUnseen(const ViewState& state, const Scene& scene, KeyPress press);

}  // namespace penumbra
