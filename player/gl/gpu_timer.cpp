#include "player/gl/gpu_timer.h"

namespace penumbra {

namespace {

GlObject makeQuery() {
    GLuint id = 0;
    gl::GenQueries(1, &id);
    return GlObject(id, [](GLuint q) { gl::DeleteQueries(1, &q); });
}

GLuint64 nanoseconds(const GlObject& query) {
    GLuint64 time = 0;
    gl::GetQueryObjectui64v(query.id(), GL_QUERY_RESULT, &time);
    return time;
}

}  // namespace

GpuTimer::GpuTimer() {
    for (Pair& pair : pairs_) {
        pair.begin = makeQuery();
        pair.end = makeQuery();
    }
}

// Uses the oldest pair again. While that has no answer yet, nothing is measured.
void GpuTimer::begin() {
    Pair& pair = pairs_[next_];
    if (pair.asked) {
        GLint available = 0;
        gl::GetQueryObjectiv(pair.end.id(), GL_QUERY_RESULT_AVAILABLE, &available);
        if (!available) return;
        milliseconds_ = 1e-6 * double(nanoseconds(pair.end) - nanoseconds(pair.begin));
        pair.asked = false;
    }
    gl::QueryCounter(pair.begin.id(), GL_TIMESTAMP);
    running_ = true;
}

void GpuTimer::end() {
    if (!running_) return;
    gl::QueryCounter(pairs_[next_].end.id(), GL_TIMESTAMP);
    pairs_[next_].asked = true;
    next_ = (next_ + 1) % kPairs;
    running_ = false;
}

}  // namespace penumbra
