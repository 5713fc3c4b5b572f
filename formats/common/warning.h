#pragma once
// What a user should know although the work can be done.
#include <string>

namespace penumbra {

// One line on stderr, "program: warning: message". Only verbs call it; -q does not silence it.
void reportWarning(const char* program, const std::string& message);

// Line breaks and other control characters as blanks.
std::string oneLine(std::string text);

// "2026-11-21T22:18:03.123Z program: message" on stderr: for -v.
void logLine(const std::string& program, const std::string& message);

}  // namespace penumbra
