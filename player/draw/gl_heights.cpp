#include "player/draw/gl_heights.h"

#include "player/draw/heights_glsl.h"
#include "player/draw/shader_source.h"
#include "runtime/cast/field_shadow.h"

namespace penumbra {

namespace {

constexpr GLuint kHeightsBinding = 0, kTapsBinding = 1, kRowsBinding = 2, kAwakeBinding = 3, kPointsBinding = 2,
                 kHiddenBinding = 3, kFinerBinding = 6, kSharesBinding = 7;
constexpr int kPyramidGroup = 8;  // points of a level, both ways

GlObject makeTaps(const HeightField& field, const HeightTables& tables) {
    return makeBuffer(GL_SHADER_STORAGE_BUFFER, std::span<const std::uint32_t>(heightTapWords(field, tables)));
}

GLint at(const GlObject& program, const char* uniform) { return gl::GetUniformLocation(program.id(), uniform); }

std::size_t numberCount(const HeightField& field) {
    const HeightLevel& last = field.levels().back();
    return last.first + std::size_t(last.rows) * std::size_t(last.columns);
}

}  // namespace

GlHeights::GlHeights(const HeightField& field, int order, int step, float tolerance, Vec3 corner)
    : field_(&field),
      tables_(field, order, order),
      above_(field, kAboveFieldOrder, kFieldOrder),
      receivers_(field.grid(), step),
      tolerance_(step > 1 ? tolerance : 0),
      corner_(corner),
      taps_(makeTaps(field, tables_)),
      above_taps_(makeTaps(field, above_)) {
    const HeightsRecipe recipe{.heights = heightsGlsl(field, tables_, corner, HeightReceiver::kOnField),
                               .order = order,
                               .spacing = step,
                               .rows = receivers_.rows(),
                               .columns = receivers_.columns(),
                               .tolerance = tolerance_};
    const std::size_t numbers = numberCount(field) * sizeof(float),
                      rows = receivers_.count() * heightRowQuads(order) * 4 * sizeof(float);
    checkStorageBlock("the ground's heights", numbers);
    checkStorageBlock("the visibility of the ground", rows);
    numbers_ = makeStorage(numbers);
    rows_ = makeStorage(rows);
    awake_list_ = makeStorage(receivers_.count() * sizeof(std::uint32_t));
    pyramid_ = makeComputeProgram(heightsPyramidSource());
    horizons_ = makeComputeProgram(heightsHorizonsSource(recipe));
    if (tolerance_ > 0) {
        const std::size_t finer = field.grid().size() * heightRowQuads(order) * 4 * sizeof(float);
        checkStorageBlock("the refined visibility of the ground", finer);
        finer_ = makeStorage(finer);
        shares_ = makeStorage(receivers_.count() * heightCellShares(step) * sizeof(float));
        looking_list_ = makeStorage(receivers_.count() * sizeof(std::uint32_t));
        cell_shares_ = makeComputeProgram(heightsSharesSource(recipe));
        look_finer_ = makeComputeProgram(heightsFinerSource(recipe));
    }
    cast_ = makeComputeProgram(heightsAboveSource(heightsGlsl(field, above_, corner, HeightReceiver::kAbove)));
    checkGl("uploading the ground's heights");
}

void GlHeights::update(std::span<const TexelBox> changed) {
    work_ = {};
    TexelBox box = changed.empty() ? TexelBox{} : changed[0];
    if (is_new_) box = {0, 0, field_->grid().rows, field_->grid().columns};
    if (!is_new_) receivers_.wake(*field_, tables_.taps(), changed);
    is_new_ = false;
    if (box.empty()) return;
    makePyramid(box);
    receivers_.takeAwake(awake_);
    receivers_.takeLooking(looking_);
    work_.receivers = awake_.size();
    bind();
    if (!awake_.empty()) lookForHorizons();
    if (tolerance_ > 0 && !looking_.empty()) lookFiner();
}

void GlHeights::lookForHorizons() {
    gl::BindBuffer(GL_SHADER_STORAGE_BUFFER, awake_list_.id());
    gl::BufferSubData(GL_SHADER_STORAGE_BUFFER, 0, GLsizeiptr(awake_.size() * sizeof(std::uint32_t)), awake_.data());
    gl::BindBufferBase(GL_SHADER_STORAGE_BUFFER, kAwakeBinding, awake_list_.id());
    gl::UseProgram(horizons_.id());
    gl::Uniform1ui(at(horizons_, "awake_count"), GLuint(awake_.size()));
    dispatchItems(awake_.size(), kWorkGroup);
    gl::MemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
    checkGl("looking for horizons");
}

// Cells of `size` points need what the corners of the larger ones have seen, so that every size is a pass of its own.
void GlHeights::lookFiner() {
    gl::BindBuffer(GL_SHADER_STORAGE_BUFFER, looking_list_.id());
    gl::BufferSubData(GL_SHADER_STORAGE_BUFFER, 0, GLsizeiptr(looking_.size() * sizeof(std::uint32_t)),
                      looking_.data());
    gl::BindBufferBase(GL_SHADER_STORAGE_BUFFER, kAwakeBinding, looking_list_.id());
    const int step = receivers_.step();
    for (int size = step; size > 1; size /= 2) {
        const auto run = [&](const GlObject& program, int side) {
            const std::size_t items = looking_.size() * std::size_t(side) * std::size_t(side);
            gl::UseProgram(program.id());
            gl::Uniform1i(at(program, "size"), size);
            gl::Uniform1ui(at(program, "item_count"), GLuint(items));
            dispatchItems(items, kWorkGroup);
            gl::MemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
        };
        run(cell_shares_, step / size);
        run(look_finer_, 2 * step / size + 1);
    }
    checkGl("looking for finer horizons");
}

void GlHeights::makePyramid(TexelBox box) {
    const std::span<const HeightLevel> levels = field_->levels();
    const auto columns = std::size_t(levels[0].columns);
    gl::BindBuffer(GL_SHADER_STORAGE_BUFFER, numbers_.id());
    const std::size_t width = std::size_t(box.end_column - box.first_column);
    for (int r = box.first_row; r < box.end_row; ++r) {
        const std::size_t first = std::size_t(r) * columns + std::size_t(box.first_column);
        // Whole rows go at once.
        const std::size_t count = width == columns ? width * std::size_t(box.end_row - r) : width;
        gl::BufferSubData(GL_SHADER_STORAGE_BUFFER, GLintptr(first * sizeof(float)), GLsizeiptr(count * sizeof(float)),
                          field_->heights().data() + first);
        work_.heights += count;
        if (width == columns) break;
    }
    gl::UseProgram(pyramid_.id());
    gl::BindBufferBase(GL_SHADER_STORAGE_BUFFER, kHeightsBinding, numbers_.id());
    for (std::size_t l = 1; l < levels.size(); ++l) {
        box = {box.first_row / 2, box.first_column / 2, (box.end_row + 1) / 2, (box.end_column + 1) / 2};
        const int rows = box.end_row - box.first_row, across = box.end_column - box.first_column;
        gl::Uniform2i(at(pyramid_, "first"), box.first_row, box.first_column);
        gl::Uniform2i(at(pyramid_, "count"), rows, across);
        gl::Uniform2i(at(pyramid_, "below"), levels[l - 1].rows, levels[l - 1].columns);
        gl::Uniform2i(at(pyramid_, "begins"), GLint(levels[l].first), GLint(levels[l - 1].first));
        gl::Uniform1i(at(pyramid_, "columns"), levels[l].columns);
        gl::DispatchCompute(GLuint((across + kPyramidGroup - 1) / kPyramidGroup),
                            GLuint((rows + kPyramidGroup - 1) / kPyramidGroup), 1);
        gl::MemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
        work_.maxima += std::size_t(rows) * std::size_t(across);
    }
    checkGl("making the pyramid of heights");
}

void GlHeights::bind() const {
    gl::BindBufferBase(GL_SHADER_STORAGE_BUFFER, kHeightsBinding, numbers_.id());
    gl::BindBufferBase(GL_SHADER_STORAGE_BUFFER, kTapsBinding, taps_.id());
    gl::BindBufferBase(GL_SHADER_STORAGE_BUFFER, kRowsBinding, rows_.id());
    if (tolerance_ <= 0) return;
    gl::BindBufferBase(GL_SHADER_STORAGE_BUFFER, kFinerBinding, finer_.id());
    gl::BindBufferBase(GL_SHADER_STORAGE_BUFFER, kSharesBinding, shares_.id());
}

void GlHeights::castOn(const GlObject& receivers, const GlObject& casts, std::size_t count) const {
    gl::BindBufferBase(GL_SHADER_STORAGE_BUFFER, kHeightsBinding, numbers_.id());
    gl::BindBufferBase(GL_SHADER_STORAGE_BUFFER, kTapsBinding, above_taps_.id());
    gl::BindBufferBase(GL_SHADER_STORAGE_BUFFER, kPointsBinding, receivers.id());
    gl::BindBufferBase(GL_SHADER_STORAGE_BUFFER, kHiddenBinding, casts.id());
    gl::UseProgram(cast_.id());
    gl::Uniform1ui(at(cast_, "receiver_count"), GLuint(count));
    dispatchItems(count, kWorkGroup);
}

}  // namespace penumbra
