#pragma once
// Tells what the controls of the panels do. The panels, many keys and the tests all read this one table.
#include <span>
#include <string>
#include <string_view>
#include <variant>

#include "player/view/view_scene.h"

namespace penumbra {

// One of several: a panel lists them, and a key goes through them.
struct Menu {
    std::vector<std::string> (*names)(const Scene& scene, const ViewState& state);
    std::size_t (*chosen)(const ViewState& state);
    void (*choose)(ViewState& state, const Scene& scene, std::size_t choice);
    bool (*has)(const Scene& scene, std::size_t choice) = nullptr;  // null: each of them can be chosen
    bool offers(const Scene& scene, std::size_t choice) const { return !has || has(scene, choice); }
};
extern const Menu kClipMenu, kMaterialMenu, kSlotMenu, kLightMenu, kLightFormMenu, kReflectanceMenu, kBounceMenu,
    kToneMapMenu, kChannelMenu, kCompareMenu, kShadowMenu, kCastModeMenu;
// Chooses the next one that there is, or the one before, round the ends.
void chooseNext(const Menu& menu, ViewState& state, const Scene& scene, int step);
// Tells whether shadows of others can join in this way.
bool hasCastMode(const Scene& scene, CastMode mode);

struct Switch {
    const char* name;
    bool& (*of)(ViewState& state);
};

struct SliderRange {
    double least, most;
    const char* format;
    bool logarithmic = false;
    std::string_view name = {};  // stands before the number
};
struct Slider {
    double (*get)(const Scene& scene, const ViewState& state);
    void (*set)(ViewState& state, const Scene& scene, double value);
    SliderRange fixed;
    SliderRange (*range)(const Scene& scene, const ViewState& state) = nullptr;  // null: it is fixed
    SliderRange rangeOf(const Scene& scene, const ViewState& state) const {
        return range ? range(scene, state) : fixed;
    }
};

enum class ControlPanel { kLook, kShow, kTime };
struct Control {
    ControlPanel panel;
    const char* id;
    const char* name;  // stands beside it; a switch has its own
    const char* tip;   // says what it does while the pointer rests on it
    std::variant<const Menu*, Switch, Slider> does;
    bool (*exists)(const Scene& scene, const ViewState& state) = nullptr;          // null: always
    std::string (*problem)(const Scene& scene, const ViewState& state) = nullptr;  // says why something is not shown
    const char* heading = nullptr;                                                 // written above it
    bool same_line = false;
    bool (*works)(const Scene& scene, const ViewState& state) = nullptr;  // otherwise it is grey; null: always
};
std::span<const Control> controls();

}  // namespace penumbra
