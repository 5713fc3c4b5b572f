#include "formats/common/warning.h"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <ctime>

namespace penumbra {

void reportWarning(const char* program, const std::string& message) {
    std::fprintf(stderr, "%s: warning: %s\n", program, oneLine(message).c_str());
}

void logLine(const std::string& program, const std::string& message) {
    const auto now = std::chrono::system_clock::now();
    const std::time_t seconds = std::chrono::system_clock::to_time_t(now);
    const auto milliseconds =
        std::chrono::duration_cast<std::chrono::milliseconds>(now.time_since_epoch()).count() % 1000;
    std::tm utc{};
    ::gmtime_r(&seconds, &utc);
    char stamp[32];
    std::strftime(stamp, sizeof stamp, "%Y-%m-%dT%H:%M:%S", &utc);
    std::fprintf(stderr, "%s.%03dZ %s: %s\n", stamp, int(milliseconds), program.c_str(), oneLine(message).c_str());
}

std::string oneLine(std::string text) {
    std::replace_if(
        text.begin(), text.end(), [](char c) { return static_cast<unsigned char>(c) < ' ' || c == 127; }, ' ');
    return text;
}

}  // namespace penumbra
