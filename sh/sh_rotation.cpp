#include "sh/sh_rotation.h"
