#include "sh/sh_project.h"
