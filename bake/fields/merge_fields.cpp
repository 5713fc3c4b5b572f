#include "bake/fields/merge_fields.h"

#include <algorithm>
#include <iterator>
#include <nlohmann/json.hpp>
#include <numeric>

#include "formats/common/errors.h"
#include "formats/common/joined.h"
#include "formats/stage/stage_file_kind.h"

namespace penumbra {

namespace {

constexpr const char* kFieldsTool = "penumbra-bake fields";

struct Piece {
    std::string name;
    FieldFile file;

    std::size_t firstPart() const { return file.shard ? file.shard->first_part : 0; }
    std::size_t endPart() const { return firstPart() + file.fields.parts.size(); }
};

// Lists how a shard differs from the first one. Equal provenance implies equal values, unless somebody edited a file.
std::vector<std::string> differencesBetween(const FieldFile& other, const FieldFile& expected) {
    std::vector<std::string> out = differencesOf(other.provenance, expected.provenance, {"parts"});
    if (!out.empty()) return out;
    const bool same = other.partCount() == expected.partCount() && other.joint_names == expected.joint_names &&
                      other.part_of_joint == expected.part_of_joint && other.steps == expected.steps &&
                      other.vertex_count == expected.vertex_count && other.mesh_sha256 == expected.mesh_sha256 &&
                      other.rays == expected.rays && other.fields.fade == expected.fields.fade;
    if (!same) out.emplace_back("another character");
    return out;
}

std::string rangeText(std::size_t begin, std::size_t end) { return std::to_string(begin) + ":" + std::to_string(end); }

// Lists why the shards, in the order of their parts, do not make a whole.
std::vector<std::string> problemsOf(const std::vector<Piece>& shards) {
    std::vector<std::string> problems;
    const FieldFile& first = shards.front().file;
    std::size_t next = 0;
    const Piece* before = nullptr;
    for (const Piece& shard : shards) {
        if (shard.file.provenance.tool != kFieldsTool)
            problems.push_back(shard.name + ": made by " + shard.file.provenance.tool + ", not by " + kFieldsTool);
        for (const std::string& difference : differencesBetween(shard.file, first))
            problems.push_back(shard.name + ": " + difference + " in " + shards.front().name);
        if (shard.firstPart() > next) problems.push_back("missing parts: " + rangeText(next, shard.firstPart()));
        if (shard.firstPart() < next)
            problems.push_back(
                "parts that occur twice: " + rangeText(shard.firstPart(), std::min(next, shard.endPart())) + " in " +
                before->name + " and " + shard.name);
        if (shard.endPart() >= next) before = &shard;
        next = std::max(next, shard.endPart());
    }
    if (next < first.partCount()) problems.push_back("missing parts: " + rangeText(next, first.partCount()));
    return problems;
}

template <class T>
void moveTo(std::vector<T>& from, std::vector<T>& to) {
    std::move(from.begin(), from.end(), std::back_inserter(to));
}

}  // namespace

bool anyHoldsFields(const std::vector<std::filesystem::path>& paths) {
    return std::any_of(paths.begin(), paths.end(), [](const std::filesystem::path& path) {
        try {
            return stageFileKind(path) == "penumbra.fields";
        } catch (const IoError&) {  // the merge reports it
            return false;
        } catch (const InvalidInput&) {
            return false;
        }
    });
}

FieldFile mergeFields(const std::vector<std::filesystem::path>& paths) {
    std::vector<Piece> shards;
    for (const std::filesystem::path& path : paths) shards.push_back({path.string(), readFieldShard(path)});
    std::stable_sort(shards.begin(), shards.end(),
                     [](const Piece& a, const Piece& b) { return a.firstPart() < b.firstPart(); });
    if (const std::vector<std::string> problems = problemsOf(shards); !problems.empty())
        throw InvalidInput("cannot merge: " + joined(problems));
    FieldFile whole = std::move(shards.front().file);
    for (std::size_t s = 1; s < shards.size(); ++s) {
        PartFields& more = shards[s].file.fields;
        moveTo(more.parts, whole.fields.parts);
        moveTo(more.values, whole.fields.values);
        moveTo(more.distances, whole.fields.distances);
    }
    whole.shard.reset();
    auto options = nlohmann::ordered_json::parse(whole.provenance.options_json);
    options.erase("parts");
    whole.provenance.options_json = options.dump();
    return whole;
}

}  // namespace penumbra
