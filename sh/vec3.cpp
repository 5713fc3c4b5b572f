#include "sh/vec3.h"
