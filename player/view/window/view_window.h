#pragma once
// The window, its GL context and its events. Only view_window.cpp knows GLFW.
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "player/view/view_actions.h"
#include "player/view/window_place.h"

namespace penumbra {

// The events since the last poll.
struct ViewEvents {
    std::vector<KeyPress> keys;                  // presses and repeats that no text field has taken
    std::vector<std::filesystem::path> dropped;  // files
    bool clicked = false;                        // a button of the mouse went down
    bool close = false;                          // the user asked for it
    bool any = false;                            // anything at all, the pointer's way included
};

class ViewWindow {
public:
    // Makes a current GL context with its entry points loaded, and ImGui's. Throws Unsupported without a display or
    // OpenGL 4.3.
    ViewWindow(const std::string& title, const WindowPlace& place);
    ~ViewWindow();
    ViewWindow(const ViewWindow&) = delete;
    ViewWindow& operator=(const ViewWindow&) = delete;

    // Waits up to `seconds` for the first event (0: not at all).
    ViewEvents poll(double seconds);
    bool listOpen() const;  // a list of a control is open
    void setTitle(const std::string& title);
    bool held() const;     // a button of the mouse is down
    bool visible() const;  // has pixels to draw into: it is neither minimised nor of no size
    int width() const;     // width of the framebuffer, pixels
    int height() const;
    float scale() const;      // pixels per unit of 1/96 inch
    float unitScale() const;  // ImGui's coordinates per unit of 1/96 inch
    WindowPlace place() const;
    const std::string& description() const;  // description of the GL
    bool software() const;

    void beginPanels();  // a frame of ImGui
    void drawPanels();
    void present();

private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace penumbra
