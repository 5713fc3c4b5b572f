#include "fit/report/residual_report.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "formats/common/errors.h"
#include "formats/common/warning.h"

namespace penumbra {

double grossResidual(const PinholeCamera& camera) {
    return 2 * std::max(1.0, std::hypot(camera.width, camera.height) / 1000);
}

void judgeResidual(const std::string& of, double residual, const PinholeCamera& camera) {
    constexpr double kDoubtful = 0.5;  // pixels
    if (!(residual > kDoubtful)) return;
    char text[32];
    std::snprintf(text, sizeof text, " off by %.2f pixels", residual);
    const std::string all = of + text +
                            " and more: the camera's f, cx, cy, k1 or k2, or the tag's side, are not those of these "
                            "pictures";
    if (residual > grossResidual(camera)) throw InvalidInput(all);
    reportWarning("penumbra-fit", all);
}

}  // namespace penumbra
