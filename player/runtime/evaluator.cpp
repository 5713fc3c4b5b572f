#include "player/runtime/evaluator.h"
