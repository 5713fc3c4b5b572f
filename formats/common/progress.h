#pragma once
// Prints progress on stderr, or in the dialect that the caller's farm reads.
#include <chrono>
#include <string>

namespace penumbra {

enum class ProgressStyle {
    kNone,
    kBar,     // one line that is rewritten: percent, rate, time left
    kOpenJd,  // "openjd_progress: 42.0" and "openjd_status: ..." on stdout, as Open Job Description asks
    kAlf,     // "ALF_PROGRESS 42%" on stdout (Tractor)
};

class Progress {
public:
    // `unit` names what is counted ("frames"); `total` > 0. Prints at most 4 times a second.
    Progress(ProgressStyle style, std::string what, std::string unit, double total);
    ~Progress();  // ends the line
    void update(double done);

private:
    ProgressStyle style_;
    std::string what_, unit_;
    double total_;
    std::chrono::steady_clock::time_point start_, last_;
    bool printed_ = false;
};

}  // namespace penumbra
