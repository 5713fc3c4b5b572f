#include "sh/zonal.h"
