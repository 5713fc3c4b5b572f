#include "fit/visibility/compose_fields.h"

#include <algorithm>

#include "fit/clusters/deforming_pose.h"
#include "formats/common/errors.h"
#include "formats/common/part_table.h"

namespace penumbra {

namespace {

constexpr std::uint8_t kNoWay = 255;  // steps between parts that no skeleton connects

// A character's own fields have its joints; occluders have none.
bool isOccluder(const FieldFile& fields) { return fields.joint_names.empty(); }

// The files' names stand in their provenance; the first input is what the fields are of.
std::string nameOf(const FieldFile& fields) {
    return fields.provenance.inputs.empty() ? std::string("?") : fields.provenance.inputs.front().name;
}

void checkCharacter(const VisibilityHeader& header, const std::string& file, const FieldFile& fields) {
    if (!header.skin) throw InvalidInput(nameOf(fields) + ": the fields have joints, but " + file + " has none");
    const PartTable table = partsOf(header.mesh, *header.skin, header.drawn);
    const Mesh& drawn = header.drawn ? header.drawn->mesh : header.mesh;
    bool same = fields.joint_names == header.skin->joint_names && fields.mesh_sha256 == meshSha256(drawn) &&
                fields.part_of_joint == table.part_of_joint && fields.fields.parts.size() == table.partCount();
    for (std::size_t p = 0; same && p < table.partCount(); ++p)
        same = fields.fields.parts[p].joint == table.joint_of_part[p];
    if (!same) throw InvalidInput(nameOf(fields) + ": the fields are of another character than " + file);
    // The bake has traced the parts within some steps, so both must count them alike.
    if (fields.steps != table.steps)
        throw InvalidInput(nameOf(fields) +
                           ": the steps between parts are counted in another way than today; make the fields and " +
                           file + " anew");
}

// The bake names its occluders by their content.
void checkOccluder(const VisibilityHeader& header, const std::string& file, const FieldFile& fields) {
    const std::string name = nameOf(fields);
    const std::vector<ProvenanceInput>& baked = header.provenance.inputs;
    const bool known =
        !fields.provenance.inputs.empty() && std::any_of(baked.begin(), baked.end(), [&](const ProvenanceInput& input) {
            return input.sha256 == fields.provenance.inputs.front().sha256;
        });
    if (!known) throw InvalidInput(name + ": is not an occluder that " + file + " was baked with");
    if (fields.motion.moves)
        throw BadOption("fields", name + " moves; its fields need inputs with a point that it moves with");
    if (fields.motion.follows.empty()) return;
    const std::vector<std::string> points = inputJointNames(header.input_names, inputJoints(header.input_names, 0));
    if (std::find(points.begin(), points.end(), fields.motion.follows) == points.end())
        throw InvalidInput(name + ": moves with the input '" + fields.motion.follows + "', which " + file +
                           " does not have");
}

// Returns the joint of an occluder, and moves its field to where it is while that joint rests.
std::uint32_t placeOccluder(const Model& model, const OccluderMotion& motion, PartField& part) {
    if (motion.follows.empty()) return kStillJoint;
    const std::vector<std::string> names = inputJointNames(model.input_names, model.input_joints);
    const auto found = std::find(names.begin(), names.end(), motion.follows);
    const std::uint32_t joint = model.input_joints[std::size_t(found - names.begin())].joint;
    const Vec3 way = model.joint_centers[joint] - motion.origin;
    part.center += way;
    for (FieldBox& box : part.boxes) {
        box.low += way;
        box.high += way;
    }
    return joint;
}

}  // namespace

void checkFields(const VisibilityHeader& header, const std::string& file, std::span<const FieldFile> fields) {
    std::size_t characters = 0;
    for (const FieldFile& one : fields) {
        if (isOccluder(one)) {
            checkOccluder(header, file, one);
            continue;
        }
        checkCharacter(header, file, one);
        if (++characters > 1) throw BadOption("fields", "two files are of one character");
    }
    if (header.skin && characters == 0)
        throw BadOption("fields", "none of the files is that of the character in " + file);
}

Composition compositionOf(const Model& model, std::span<const FieldFile> fields, const VisibilityHeader& header) {
    Composition composition;
    composition.local_steps = header.local->steps;
    composition.floor = header.ground_y.has_value();
    PartFields& parts = composition.fields;
    std::vector<std::uint8_t> own_steps;
    const auto append = [&](const FieldFile& file) {
        parts.parts.insert(parts.parts.end(), file.fields.parts.begin(), file.fields.parts.end());
        parts.values.insert(parts.values.end(), file.fields.values.begin(), file.fields.values.end());
        parts.distances.insert(parts.distances.end(), file.fields.distances.begin(), file.fields.distances.end());
        parts.fade = std::max(parts.fade, file.fields.fade);
    };
    // 1. The character's own parts.
    composition.part_of_vertex.assign(model.mesh.vertexCount(), 0);
    std::size_t own = 0;
    for (const FieldFile& file : fields) {
        if (isOccluder(file)) continue;
        append(file);
        const PartTable table = partsOf(model.mesh, model.skin, model.drawn);
        composition.part_of_vertex = table.part_of_vertex;
        own_steps = table.steps;
        own = table.partCount();
    }
    // 2. The occluders.
    for (const FieldFile& file : fields) {
        if (!isOccluder(file)) continue;
        append(file);
        parts.parts.back().joint = placeOccluder(model, file.motion, parts.parts.back());
    }
    const std::size_t count = parts.parts.size();
    composition.steps.assign(count * count, kNoWay);
    for (std::size_t a = 0; a < own; ++a)
        for (std::size_t b = 0; b < own; ++b) composition.steps[a * count + b] = own_steps[a * own + b];
    return composition;
}

std::vector<bool> composedInputs(const Model& model) {
    std::vector<bool> composed(model.skin.jointCount());
    for (const PartField& part : model.composition->fields.parts)
        for (const InputJoint& input : model.input_joints)
            if (input.joint == part.joint) composed[input.joint] = true;
    return composed;
}

}  // namespace penumbra
