#pragma once
// An asset stores the kinds of formats/common/model_kind.h by number. This is the one place that turns one into the
// other.
#include <asset_generated.h>

#include "formats/common/model_kind.h"

namespace penumbra {

static_assert(int(fbs::ModelKind::Linear) == int(ModelKind::kLinear));
static_assert(int(fbs::ModelKind::Quadratic) == int(ModelKind::kQuadratic));
static_assert(int(fbs::ModelKind::Neural) == int(ModelKind::kNeural));
static_assert(int(fbs::ModelKind::Additive) == int(ModelKind::kAdditive));
static_assert(int(fbs::ModelKind::MAX) + 1 == int(kModelKinds.size()));
static_assert(int(fbs::FeatureKind::JointAngles) == int(FeatureKind::kJointAngles));
static_assert(int(fbs::FeatureKind::RelativeBones) == int(FeatureKind::kRelativeBones));
static_assert(int(fbs::FeatureKind::DihedralAngles) == int(FeatureKind::kDihedrals));
static_assert(int(fbs::FeatureKind::MAX) + 1 == int(kFeatureKinds.size()));

inline fbs::ModelKind toStored(ModelKind kind) { return fbs::ModelKind(kind); }
inline fbs::FeatureKind toStored(FeatureKind features) { return fbs::FeatureKind(features); }

// Readers have checked the numbers of a file: each is at most MAX.
inline ModelKind fromStored(fbs::ModelKind kind) { return ModelKind(kind); }
inline FeatureKind fromStored(fbs::FeatureKind features) { return FeatureKind(features); }

}  // namespace penumbra
