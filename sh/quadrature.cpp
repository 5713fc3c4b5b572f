#include "sh/quadrature.h"
