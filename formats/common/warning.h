#pragma once
// Prints what a user should know although the work can be done.
#include <string>

namespace penumbra {

// Prints one line on stderr, "program: warning: message". Only verbs call it; -q does not silence it.
void reportWarning(const char* program, const std::string& message);

// Replaces line breaks and other control characters by blanks.
std::string oneLine(std::string text);

// Prints "2026-11-21T22:18:03.123Z program: message" on stderr, for -v.
void logLine(const std::string& program, const std::string& message);

}  // namespace penumbra
