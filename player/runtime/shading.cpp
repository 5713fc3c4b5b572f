#include "player/runtime/shading.h"
