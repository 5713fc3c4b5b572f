#include "player/gpu_timer.h"

namespace penumbra {

GpuTimer::GpuTimer() {
    for (GlObject& query : queries_) {
        GLuint id = 0;
        gl::GenQueries(1, &id);
        query = GlObject(id, [](GLuint q) { gl::DeleteQueries(1, &q); });
    }
}

// The oldest query is used again; while it has no answer yet, nothing is measured.
void GpuTimer::begin() {
    const GLuint query = queries_[next_].id();
    if (asked_[next_]) {
        GLint available = 0;
        gl::GetQueryObjectiv(query, GL_QUERY_RESULT_AVAILABLE, &available);
        if (!available) return;
        GLuint64 nanoseconds = 0;
        gl::GetQueryObjectui64v(query, GL_QUERY_RESULT, &nanoseconds);
        milliseconds_ = 1e-6 * double(nanoseconds);
        asked_[next_] = false;
    }
    gl::BeginQuery(GL_TIME_ELAPSED, query);
    running_ = true;
}

void GpuTimer::end() {
    if (!running_) return;
    gl::EndQuery(GL_TIME_ELAPSED);
    asked_[next_] = true;
    next_ = (next_ + 1) % kQueries;
    running_ = false;
}

}  // namespace penumbra
