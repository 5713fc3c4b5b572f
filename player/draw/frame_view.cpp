#include "player/draw/frame_view.h"

namespace penumbra {

ViewUniforms viewUniforms(const GlObject& program) {
    return {gl::GetUniformLocation(program.id(), "clip_from_model"), gl::GetUniformLocation(program.id(), "eye"),
            gl::GetUniformLocation(program.id(), "error_max"),       gl::GetUniformLocation(program.id(), "exposure"),
            gl::GetUniformLocation(program.id(), "tone_map"),        gl::GetUniformLocation(program.id(), "rim")};
}

void setView(const GlObject& program, const ViewUniforms& at, const FrameView& view) {
    gl::UseProgram(program.id());
    gl::UniformMatrix4fv(at.clip_from_model, 1, GL_FALSE, view.clip_from_model.data());
    gl::Uniform3f(at.eye, view.eye.x, view.eye.y, view.eye.z);
    gl::Uniform1f(at.error_max, view.error_max);
    gl::Uniform1f(at.exposure, view.display ? view.display->exposure : view.scale);
    gl::Uniform4fv(at.rim, 1, view.rim.data());
    gl::Uniform1i(at.tone_map, view.display ? int(view.display->tone_map) : -1);
}

}  // namespace penumbra
