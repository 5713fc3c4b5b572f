#pragma once

namespace penumbra {

struct WindowPlace {
    int width = 1280, height = 800;  // units of 1/96 inch
    int x = -1, y = -1;              // screen coordinates; -1: where the system puts it
};

}  // namespace penumbra
