#pragma once
// The visibility whose logarithm netLog() (sh/cast/cap_visibility.h) has summed: exp(f) in the algebra of truncated SH
// products.
//
// Problem: exp(f) = 1 + f + f f / 2 + ... has SH products in it, and their number decides how long a receiver takes.
//
// Naive: the power series. Logarithms have a norm m of up to 15, where it needs tens of products.
//
// Here: exp(f) = exp(f / 2^p)^(2^p). A short series does for the small f / 2^p, and squaring it p times takes p
// products. The constant part f_0 of f is an ordinary exponential; it goes in before the squarings, so that nothing
// gets larger than about 1 on the way. f^ is f without that part, and m = |f^| (docs/formulas.md, section 10).
#include <span>
#include <vector>

#include "sh/cast/cap_visibility.h"
#include "sh/cast/repeated_product.h"

namespace penumbra {

enum class ExpMethod {
    kHybPs2,  // a short power series, then squarings
    kHybOl,   // the linear form of kOl, then squarings
    kPs,      // the power series alone; diverges near the body
    kOl,      // e^(f_0 / sqrt 4pi) (a(m) + b(m) f^), with the a and b that are right for a single cap; good for m < 1
};

struct ExpOptions {
    ExpMethod method = ExpMethod::kHybPs2;
    // kHybPs2: the series ends with x^3/6 and |x| <= 1/2, so that V changes by less than .001 (RMS over the sphere)
    // where p does. Otherwise it ends with x^2/2 and |x| <= 1, which golden files use. That takes two products less,
    // but V steps by up to .03, which shows.
    bool smooth = true;
    int terms = 9;  // kPs: the last power, >= 0
};

// The curves a(m) and b(m) of ExpMethod::kOl, to be interpolated linearly. They end where m of a single cap is largest
// and stay constant from there on.
struct LinearCurves {
    std::vector<double> norm, a, b;  // norm ascends from 0
};

template <class T>
struct BasicExpTables {
    int order = 0;
    const BasicRepeatedProduct<T>* product = nullptr;
    LinearCurves curves;
};
using ExpTables = BasicExpTables<float>;
using ExpTablesD = BasicExpTables<double>;

// Made once for each order from kMinLogOrder to kMaxLogOrder, and kept.
const ExpTables& expTables(int order);
const ExpTablesD& expTablesD(int order);

// Returns how often the method squares for a logarithm of norm m; 8 times at most.
int squaringCount(const ExpOptions& options, double norm);

// Writes exp(log); both have coefficientCount(tables.order) elements and may be the same. Allocates nothing.
void expOfLog(const ExpTables& tables, const ExpOptions& options, std::span<const float> log, std::span<float> out);
void expOfLog(const ExpTablesD& tables, const ExpOptions& options, std::span<const double> log, std::span<double> out);

// Multiplies the visibilities past single caps, the largest cap first: truncated products are not associative. This is
// the reference that exponentials are compared with. 1 <= order <= kMaxOrder; out.size() == coefficientCount(order).
void productChain(int order, std::span<const Cap> caps, std::span<double> out);

}  // namespace penumbra
