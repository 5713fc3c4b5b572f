#include "formats/fp16.h"
