#include "formats/command_line.h"
