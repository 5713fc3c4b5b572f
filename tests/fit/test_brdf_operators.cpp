// Operators M^b of paper 000 three ways, on the scenes of the accuracy table.
#include <gtest/gtest.h>

#include <chrono>
#include <cstdio>

#include "fit/brdf_operators.h"
#include "fit/fit_brdf.h"

namespace penumbra {
namespace {

TEST(Dev, Print) {
    for (const char* text : {"lambert","phong:exponent=10","phong:exponent=50","ward-gmd:ax=0.2,ay=0.5","ward:ax=0.2,ay=0.5","ashikhmin-shirley:nu=10,nv=50,rs=0.5,rd=0.3","ggx:alpha=0.3,f0=0.9"}) {
        const RgbBrdf brdf = rgbBrdf(parseBrdf(text));
        const auto now = [] { return std::chrono::steady_clock::now(); };
        auto t0 = now();
        const auto ms = [&] { auto t = now(); double d = std::chrono::duration<double>(t - t0).count() * 1e3; t0 = t; return d; };
        BrdfFile file = fitBrdf(brdf, {}, 2);
        std::printf("%-20s fit %4.0f ms ", text, ms());
        for (auto from : {OperatorSource::kLiteral, OperatorSource::kTable, OperatorSource::kSlices}) {
            file.operators = fitOperators(brdf, file, from, 8, 2);
            double a = ms();
            measureShading(brdf, file, 2);
            double b = ms();
            std::printf("| %s k=%d %.4f d5 %.4f %4.0f ms + %4.0f ms ", nameOf(from), file.operators.count, file.errors["shading_operators"], file.errors["shading_operators_d5"], a, b);
        }
        std::printf("| a4 %.4f d5 %.4f\n", file.errors["shading_a4"], file.errors["shading_d5"]);
    }
}

}  // namespace
}  // namespace penumbra
