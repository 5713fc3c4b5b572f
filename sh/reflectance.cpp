#include "sh/reflectance.h"
