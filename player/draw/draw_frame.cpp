#include "player/draw/draw_frame.h"

#include <cassert>

#include "player/draw/shader_source.h"

namespace penumbra {

namespace {

// In value.vert.
constexpr GLuint kNormalLocation = 2, kLobesLocation = 4, kSightLocation = 5, kPlacesLocation = 6, kTermsLocation = 7;

// Returns the bytes of values [V] and of their copies, in `out` [V + E].
template <class T>
std::span<const std::byte> withCopies(std::span<const T> values, std::span<const std::uint32_t> of,
                                      std::vector<T>& out) {
    std::copy(values.begin(), values.end(), out.begin());
    for (std::size_t e = 0; e < of.size(); ++e) out[values.size() + e] = values[of[e]];
    return std::as_bytes(std::span<const T>(out));
}

std::string fading(Sides sides, std::string source) {
    return sides == Sides::kFading ? source.insert(source.find("#define"), "#define FADING\n") : source;
}

}  // namespace

ValuePainter::ValuePainter(std::span<const std::uint32_t> triangles, Channel channel, Sides sides, BrdfModels sunlit)
    : ValuePainter(triangles, channel, sides, sunlit, PicturedMesh()) {}

ValuePainter::ValuePainter(std::span<const std::uint32_t> triangles, Channel channel, Sides sides, BrdfModels sunlit,
                           const PicturedMesh& pictures)
    : program_(makeProgram(fading(sides, valueVertexSource(channel, sunlit, pictures.shader())),
                           fading(sides, channelFragmentSource(channel, sunlit, pictures.shader())))),
      vertex_array_(makeVertexArray()),
      view_(viewUniforms(program_)),
      sides_(sides),
      index_count_(GLsizei(triangles.size())),
      pictures_(pictures) {
    gl::BindVertexArray(vertex_array_.id());
    GLuint location = 0;
    for (GlObject* buffer : {&positions_, &values_}) {
        *buffer = makeBuffer(GL_ARRAY_BUFFER, std::span<const std::byte>{});
        gl::VertexAttribPointer(location, 3, GL_FLOAT, GL_FALSE, 0, nullptr);
        gl::EnableVertexAttribArray(location++);
    }
    if (sunlit) {
        sunlight_ = sunlightUniforms(program_);
        for (GlObject& buffer : surface_) {
            buffer = makeBuffer(GL_ARRAY_BUFFER, std::span<const std::byte>{});
            if (location == kLobesLocation)
                gl::VertexAttribIPointer(location, 1, GL_UNSIGNED_INT, 0, nullptr);
            else
                gl::VertexAttribPointer(location, location == kSightLocation ? 1 : 3, GL_FLOAT, GL_FALSE, 0, nullptr);
            if (location != kSightLocation) gl::EnableVertexAttribArray(location);
            ++location;
        }
    }
    if (pictures_.surface) addTextures();
    if (sides == Sides::kSeen) surfaces_ = findClosedSurfaces(triangles);
    triangles_ = makeBuffer(GL_ELEMENT_ARRAY_BUFFER,
                            sides == Sides::kSeen ? std::span<const std::uint32_t>(surfaces_.triangles) : triangles);
    checkGl("uploading the mesh");
}

namespace {

PicturedMesh picturesFor(const PicturedMesh& pictures, Channel channel) {
    return channel == Channel::kShaded ? pictures : PicturedMesh();
}

// A textured mesh is drawn slot by slot, from both sides where its own triangles do not tell.
Sides sidesOf(const MeshView& mesh, Sides sides, const PicturedMesh& pictures) {
    if (mesh.cull_backs) return Sides::kFront;
    return pictures.surface && sides == Sides::kSeen ? Sides::kBoth : sides;
}

std::span<const std::uint32_t> trianglesOf(const MeshView& mesh, const PicturedMesh& pictures) {
    return pictures.surface ? pictures.surface->triangles() : mesh.triangles;
}

}  // namespace

ValuePainter::ValuePainter(const MeshView& mesh, Channel channel, Sides sides, BrdfModels sunlit,
                           const PicturedMesh& pictures)
    : ValuePainter(trianglesOf(mesh, picturesFor(pictures, channel)), channel,
                   sidesOf(mesh, sides, picturesFor(pictures, channel)), sunlit, picturesFor(pictures, channel)) {}

void ValuePainter::addTextures() {
    const SurfaceShader shader = pictures_.shader();
    surface_uniforms_ = surfaceUniforms(program_);
    if (shader.slopes > 0 && !sunlight_) {
        surface_[0] = makeBuffer(GL_ARRAY_BUFFER, std::span<const std::byte>{});
        gl::VertexAttribPointer(kNormalLocation, 3, GL_FLOAT, GL_FALSE, 0, nullptr);
        gl::EnableVertexAttribArray(kNormalLocation);
    }
    gl::BindBuffer(GL_ARRAY_BUFFER, pictures_.surface->places().id());
    gl::VertexAttribPointer(kPlacesLocation, 4, GL_FLOAT, GL_FALSE, 0, nullptr);
    gl::EnableVertexAttribArray(kPlacesLocation);
    for (std::size_t term = 0; term < shader.terms(); ++term) {
        terms_.push_back(makeBuffer(GL_ARRAY_BUFFER, std::span<const std::byte>{}));
        const GLuint location = kTermsLocation + GLuint(term);
        gl::VertexAttribPointer(location, 3, GL_FLOAT, GL_FALSE, 0, nullptr);
        gl::EnableVertexAttribArray(location);
    }
    drawn_.resize(pictures_.surface->drawnVertices());
}

// Replaces the values of vertices, and of their copies at seams.
void ValuePainter::replaceDrawn(const GlObject& buffer, std::span<const Vec3> values) {
    if (!pictures_.surface) return replaceBuffer(GL_ARRAY_BUFFER, buffer, std::as_bytes(values));
    replaceBuffer(GL_ARRAY_BUFFER, buffer, withCopies(values, pictures_.surface->seamVertices(), drawn_));
}

void ValuePainter::uploadSurface(const SunlitSurface& surface) {
    replaceDrawn(surface_[0], surface.normals);
    replaceDrawn(surface_[1], surface.tangents);
    if (pictures_.surface) {
        const std::span<const std::uint32_t> seams = pictures_.surface->seamVertices();
        drawn_lobes_.resize(drawn_.size());
        drawn_sight_.resize(surface.sight.empty() ? 0 : drawn_.size());
        replaceBuffer(GL_ARRAY_BUFFER, surface_[2], withCopies(surface.lobes, seams, drawn_lobes_));
        replaceBuffer(
            GL_ARRAY_BUFFER, surface_[3],
            surface.sight.empty() ? std::span<const std::byte>() : withCopies(surface.sight, seams, drawn_sight_));
    } else {
        replaceBuffer(GL_ARRAY_BUFFER, surface_[2], std::as_bytes(surface.lobes));
        replaceBuffer(GL_ARRAY_BUFFER, surface_[3], std::as_bytes(surface.sight));
    }
    if (!surface.sight.empty()) gl::EnableVertexAttribArray(kSightLocation);
}

void ValuePainter::upload(std::span<const Vec3> positions, std::span<const Vec3> values, const SunlitSurface& surface) {
    gl::BindVertexArray(vertex_array_.id());
    replaceDrawn(positions_, positions);
    replaceDrawn(values_, values.first(positions.size()));
    for (std::size_t term = 0; term < terms_.size(); ++term)
        replaceDrawn(terms_[term], values.subspan((term + 1) * positions.size(), positions.size()));
    if (sunlight_)
        uploadSurface(surface);
    else if (pictures_.shader().slopes > 0)
        replaceDrawn(surface_[0], surface.normals);
    outward_ = allOutward(surfaces_, positions);
}

void ValuePainter::setTriangles(std::span<const std::uint32_t> triangles) {
    assert(sides_ != Sides::kSeen);
    gl::BindVertexArray(vertex_array_.id());
    replaceBuffer(GL_ELEMENT_ARRAY_BUFFER, triangles_, std::as_bytes(triangles));
    index_count_ = GLsizei(triangles.size());
}

void ValuePainter::draw(const FrameView& view, const Sunlight* suns) const {
    assert(!sunlight_ || suns);
    gl::BindVertexArray(vertex_array_.id());
    setView(program_, view_, view);
    if (sunlight_) suns->bind(*sunlight_, view);
    if (pictures_.surface) {
        if (sides_ == Sides::kFront) gl::Enable(GL_CULL_FACE);
        pictures_.surface->draw(surface_uniforms_, pictures_.shading);
        if (sides_ == Sides::kFront) gl::Disable(GL_CULL_FACE);
        return checkGl("drawing");
    }
    if (sides_ == Sides::kFading) {
        gl::Enable(GL_BLEND);
        gl::BlendFunc(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA);
    }
    const GLsizei closed = outward_ ? GLsizei(surfaces_.closedIndices()) : 0;
    const GLsizei one_sided = sides_ == Sides::kFront ? index_count_ : closed;
    if (one_sided > 0) {
        gl::Enable(GL_CULL_FACE);
        gl::DrawElements(GL_TRIANGLES, one_sided, GL_UNSIGNED_INT, nullptr);
        gl::Disable(GL_CULL_FACE);
    }
    if (one_sided < index_count_)
        gl::DrawElements(GL_TRIANGLES, index_count_ - one_sided, GL_UNSIGNED_INT,
                         reinterpret_cast<const void*>(sizeof(std::uint32_t) * std::size_t(one_sided)));
    if (sides_ == Sides::kFading) gl::Disable(GL_BLEND);
    checkGl("drawing");
}

void ValuePainter::draw(const FrameView& view, std::span<const Vec3> positions, std::span<const Vec3> values) {
    upload(positions, values);
    draw(view);
}

}  // namespace penumbra
