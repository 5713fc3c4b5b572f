#include "sh/camera.h"
