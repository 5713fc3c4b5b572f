#include "sh/visibility_convention.h"
