#include "sh/sh_product.h"
