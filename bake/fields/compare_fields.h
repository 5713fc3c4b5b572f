#pragma once
// Holds the fields that a bake has made to rays, at the skin of the character in poses of its clips.
#include <memory>
#include <vector>

#include "bake/source/bake_source.h"
#include "formats/common/far_by_rays.h"
#include "formats/common/part_fields.h"
#include "formats/common/part_table.h"

namespace penumbra {

// Where fields are compared. Everything is empty for a mesh without joints, whose part no skin of its own meets.
struct FieldReceivers {
    struct Pose {
        std::vector<Affine> bones;             // [J]
        std::vector<Vec3> positions, normals;  // the compared vertices only
    };
    std::vector<Pose> poses;
    std::vector<std::uint16_t> part;                    // part of each of these vertices
    std::vector<std::vector<std::uint16_t>> far_parts;  // [P] that a vertex of each part sees, farParts()
    std::shared_ptr<const PartRays> rays;
};
// Takes vertices and frames that are spread evenly; the rest pose where there is no clip. Parts are far as in a bake
// with the default steps.
FieldReceivers fieldReceivers(const BakeSource& source, const PartTable& table);

// rms V between fields and rays over receivers of which a part is a far one.
struct FieldErrors {
    std::vector<double> part;  // one for each part of the fields
    double product = 0;        // over all far parts together; a shard counts only the far parts that it has
};
// The fields are those of the parts from `first_part` on. The result is the same for any number of threads.
FieldErrors compareFields(const FieldReceivers& receivers, const PartFields& fields, std::size_t first_part,
                          int threads);

}  // namespace penumbra
