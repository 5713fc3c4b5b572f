#pragma once
// The seven BRDFs of the accuracy table in docs/formulas.md section 3.
namespace penumbra {

inline constexpr const char* kReferenceBrdfs[] = {"lambert",
                                                  "phong:exponent=10",
                                                  "phong:exponent=50",
                                                  "ward-gmd:ax=0.2,ay=0.5",
                                                  "ward:ax=0.2,ay=0.5",
                                                  "ashikhmin-shirley:nu=10,nv=50,rs=0.5,rd=0.3",
                                                  "ggx:alpha=0.3,f0=0.9"};

}  // namespace penumbra
