#include "sh/sh_basis.h"
