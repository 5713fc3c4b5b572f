#include "sh/brdf.h"
