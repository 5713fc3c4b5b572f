// Vectors are passed by reference, because passing 32-byte vectors by value has no fixed ABI without AVX.
#include "fit/models/net_kernels.h"

namespace penumbra {

namespace {

typedef double Lanes __attribute__((vector_size(8 * kNetLanes), aligned(8), may_alias));
typedef long long LaneBits __attribute__((vector_size(8 * kNetLanes), aligned(8), may_alias));

#ifdef __AVX2__
constexpr std::size_t kTileVectors = 2;  // 4 x 2 sums, 2 factors and a broadcast fit into 16 registers
#else
constexpr std::size_t kTileVectors = 1;  // a vector takes two registers
#endif

// Adds to a tile of `out`, Rows rows by Vectors vectors of frames. Its sums stay in registers over the whole inner sum.
template <std::size_t Rows, std::size_t Vectors>
inline void productTile(std::size_t inner, std::size_t stride, const double* a, std::size_t a_stride, const double* b,
                        double* out) {
    Lanes sum[Rows][Vectors];
    for (std::size_t r = 0; r < Rows; ++r)
        for (std::size_t v = 0; v < Vectors; ++v)
            sum[r][v] = *reinterpret_cast<const Lanes*>(out + r * stride + v * kNetLanes);
    for (std::size_t i = 0; i < inner; ++i) {
        Lanes right[Vectors];
        for (std::size_t v = 0; v < Vectors; ++v)
            right[v] = *reinterpret_cast<const Lanes*>(b + i * stride + v * kNetLanes);
        for (std::size_t r = 0; r < Rows; ++r)
            for (std::size_t v = 0; v < Vectors; ++v) sum[r][v] += a[r * a_stride + i] * right[v];
    }
    for (std::size_t r = 0; r < Rows; ++r)
        for (std::size_t v = 0; v < Vectors; ++v)
            *reinterpret_cast<Lanes*>(out + r * stride + v * kNetLanes) = sum[r][v];
}

// Adds the product for Rows rows: as many wide tiles as fit, then narrow ones.
template <std::size_t Rows>
inline void productRows(std::size_t inner, std::size_t stride, const double* a, std::size_t a_stride, const double* b,
                        double* out) {
    std::size_t f = 0;
    for (; f + kTileVectors * kNetLanes <= stride; f += kTileVectors * kNetLanes)
        productTile<Rows, kTileVectors>(inner, stride, a, a_stride, b + f, out + f);
    for (; f < stride; f += kNetLanes) productTile<Rows, 1>(inner, stride, a, a_stride, b + f, out + f);
}

// NetKernels::addProduct: four rows at a time, then one.
void addProductLanes(std::size_t rows, std::size_t inner, std::size_t stride, const double* a, std::size_t a_stride,
                     const double* b, double* out) {
    std::size_t r = 0;
    for (; r + 4 <= rows; r += 4) productRows<4>(inner, stride, a + r * a_stride, a_stride, b, out + r * stride);
    for (; r < rows; ++r) productRows<1>(inner, stride, a + r * a_stride, a_stride, b, out + r * stride);
}

// Computes Rows x Columns inner products together, so that each vector that is loaded serves several of them.
template <std::size_t Rows, std::size_t Columns>
inline void innerTile(std::size_t stride, const double* a, const double* b, double* out, std::size_t out_stride) {
    Lanes sum[Rows][Columns] = {};
    for (std::size_t f = 0; f < stride; f += kNetLanes) {
        Lanes right[Columns];
        for (std::size_t c = 0; c < Columns; ++c) right[c] = *reinterpret_cast<const Lanes*>(b + c * stride + f);
        for (std::size_t r = 0; r < Rows; ++r) {
            const Lanes left = *reinterpret_cast<const Lanes*>(a + r * stride + f);
            for (std::size_t c = 0; c < Columns; ++c) sum[r][c] += left * right[c];
        }
    }
    for (std::size_t r = 0; r < Rows; ++r)
        for (std::size_t c = 0; c < Columns; ++c) {
            const Lanes& s = sum[r][c];
            out[r * out_stride + c] = (s[0] + s[1]) + (s[2] + s[3]);
        }
}

// Computes the inner products of Rows rows: three columns at a time, then one.
template <std::size_t Rows>
inline void innerRows(std::size_t columns, std::size_t stride, const double* a, const double* b, double* out,
                      std::size_t out_stride) {
    std::size_t c = 0;
    for (; c + 3 <= columns; c += 3) innerTile<Rows, 3>(stride, a, b + c * stride, out + c, out_stride);
    for (; c < columns; ++c) innerTile<Rows, 1>(stride, a, b + c * stride, out + c, out_stride);
}

// NetKernels::innerProducts: four rows at a time, then one.
void innerProductsLanes(std::size_t rows, std::size_t columns, std::size_t stride, const double* a, const double* b,
                        double* out, std::size_t out_stride) {
    std::size_t r = 0;
    for (; r + 4 <= rows; r += 4) innerRows<4>(columns, stride, a + r * stride, b, out + r * out_stride, out_stride);
    for (; r < rows; ++r) innerRows<1>(columns, stride, a + r * stride, b, out + r * out_stride, out_stride);
}

// NetKernels::tanhAndSlope. tanh z = sign(z) (1 - e) / (1 + e) with e = exp(-2 |z|). The exponential is exp(x) = 2^n
// exp(r), where n is the integer nearest to x / ln 2, so that |r| <= ln 2 / 2. There a Taylor polynomial of degree 13
// leaves an error of 2e-16. |z| is limited to 20, which loses nothing: beyond it e is below 5e-18.
void tanhAndSlopeLanes(std::size_t count, double* z, double* slope) {
    constexpr double kRound = 6755399441055744.0;  // 1.5 * 2^52: adding it rounds to an integer in the low bits
    constexpr double kLog2E = 1.4426950408889634, kLn2High = 0.693147180369123816490, kLn2Low = 1.90821492927058770e-10;
    constexpr double kInverse[] = {
        1.0,        1.0,         1.0 / 2,      1.0 / 6,       1.0 / 24,       1.0 / 120,       1.0 / 720,
        1.0 / 5040, 1.0 / 40320, 1.0 / 362880, 1.0 / 3628800, 1.0 / 39916800, 1.0 / 479001600, 1.0 / 6227020800.0};
    for (std::size_t i = 0; i < count; i += kNetLanes) {
        // 1. x = -2 |z|.
        const Lanes value = *reinterpret_cast<const Lanes*>(z + i);
        const Lanes size = value < 0.0 ? -value : value;
        const Lanes x = -2.0 * (size < 20.0 ? size : size * 0.0 + 20.0);
        // 2. Split x into n ln 2 + r. ln 2 stands in two parts, so that n times the high part is exact.
        const Lanes shifted = x * kLog2E + kRound;
        const Lanes n = shifted - kRound;
        const Lanes r = (x - n * kLn2High) - n * kLn2Low;
        // 3. exp(r) by Horner's rule.
        Lanes e = r * 0.0 + kInverse[13];
        for (int k = 12; k >= 0; --k) e = e * r + kInverse[k];
        // 4. Multiply by 2^n, made by moving n into the exponent bits.
        const LaneBits power = (reinterpret_cast<const LaneBits&>(shifted) << 52) + (1023LL << 52);
        e *= reinterpret_cast<const Lanes&>(power);
        // 5. tanh and its slope.
        const Lanes h = (1.0 - e) / (1.0 + e);
        const Lanes result = value < 0.0 ? -h : h;
        *reinterpret_cast<Lanes*>(z + i) = result;
        *reinterpret_cast<Lanes*>(slope + i) = 1.0 - result * result;
    }
}

}  // namespace

const NetKernels NetKernels::PENUMBRA_TARGET{PENUMBRA_TARGET_NAME, addProductLanes, innerProductsLanes,
                                             tanhAndSlopeLanes};

}  // namespace penumbra
