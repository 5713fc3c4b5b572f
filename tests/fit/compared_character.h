#pragma once
// A synthetic character as the measurements of a comparison see it. The clip "clip1" is held out.
#include "fit/papers/compare/compare_character.h"
#include "tests/fit/synthetic_character.h"

namespace penumbra {

struct ComparedCharacter {
    synthetic::TemporaryFile file;
    VisibilityReader reader;
    PoseTable poses;
    CompareInput input;
    CompareOptions options;
    CompareCharacter character;

    ComparedCharacter(const std::string& name, const char* convention)
        : file(name), reader(written(file.path)), poses(readPoses(reader, {.threads = 2})), input{reader, poses, name} {
        options.clusters = {4};
        options.conventions = {parseConvention(convention)};
        options.output_variances = {0.95};
        options.holdout = {"clip1"};
        options.threads = 2;
        character = prepareCharacter(input, options);
    }
    static const std::filesystem::path& written(const std::filesystem::path& path) {
        synthetic::writeCharacter(path, {});
        return path;
    }
};

}  // namespace penumbra
