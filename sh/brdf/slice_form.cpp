#include "sh/brdf/slice_form.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace penumbra {

const char* nameOf(SliceForm form) {
    switch (form) {
        case SliceForm::kGeneral:
            return "general";
        case SliceForm::kOrthotropic:
            return "orthotropic";
        case SliceForm::kIsotropic:
            return "isotropic";
    }
    return "";
}

namespace {

// Tells whether the entry that pairs m of the incident direction with M of the view may be other than zero.
bool pairs(SliceForm form, int m, int view_m) {
    switch (form) {
        case SliceForm::kGeneral:
            return true;
        case SliceForm::kOrthotropic:
            return (m < 0) == (view_m < 0) && (m - view_m) % 2 == 0;
        case SliceForm::kIsotropic:
            return m == view_m;
    }
    return false;
}

// Returns m of y_lm; index = l (l + 1) + m with |m| <= l.
int orderOf(int index) {
    const int l = int(std::sqrt(double(index)));
    return index - l * (l + 1);
}

}  // namespace

std::vector<int> entryPositions(SliceForm form, int slice_order, int view_order) {
    const std::vector<int> even = evenIndices(view_order);
    const int rows = coefficientCount(slice_order), columns = int(even.size());
    const bool isotropic = form == SliceForm::kIsotropic;
    std::vector<int> positions(std::size_t(rows * columns), -1);
    int next = 0;
    // 1. Number the entries that are kept.
    for (int i = 0; i < rows; ++i)
        for (int e = 0; e < columns; ++e)
            if (pairs(form, orderOf(i), orderOf(even[std::size_t(e)])) && !(isotropic && orderOf(i) < 0))
                positions[std::size_t(i * columns + e)] = next++;
    // 2. Isotropic: the entries of -m share the values of m. For m < 0, (l, -m) lies 2 |m| rows below (l, m), and |m|
    //    columns to the right, as every second M is there.
    for (int i = 0; i < rows; ++i)
        for (int e = 0, m = orderOf(i); e < columns && isotropic && m < 0; ++e)
            if (orderOf(even[std::size_t(e)]) == m)
                positions[std::size_t(i * columns + e)] = positions[std::size_t((i - 2 * m) * columns + e - m)];
    return positions;
}

std::size_t entryCount(SliceForm form, int slice_order, int view_order) {
    const std::vector<int> positions = entryPositions(form, slice_order, view_order);
    return std::size_t(*std::max_element(positions.begin(), positions.end()) + 1);
}

std::vector<float> compactSlices(SliceForm form, int slice_order, int view_order, std::span<const float> slices) {
    const std::vector<int> positions = entryPositions(form, slice_order, view_order);
    const std::size_t count = entryCount(form, slice_order, view_order);
    assert(slices.size() % positions.size() == 0);
    std::vector<float> entries;
    for (std::size_t first = 0; first < slices.size(); first += positions.size()) {
        std::vector<double> sum(count, 0.0);
        std::vector<int> terms(count, 0);
        for (std::size_t i = 0; i < positions.size(); ++i)
            if (positions[i] >= 0) {
                sum[std::size_t(positions[i])] += slices[first + i];
                ++terms[std::size_t(positions[i])];
            }
        for (std::size_t e = 0; e < count; ++e) entries.push_back(float(sum[e] / terms[e]));
    }
    return entries;
}

std::vector<float> expandSlices(SliceForm form, int slice_order, int view_order, std::span<const float> entries) {
    const std::vector<int> positions = entryPositions(form, slice_order, view_order);
    const std::size_t count = entryCount(form, slice_order, view_order);
    assert(entries.size() % count == 0);
    std::vector<float> slices;
    slices.reserve(entries.size() / count * positions.size());
    for (std::size_t first = 0; first < entries.size(); first += count)
        for (const int position : positions)
            slices.push_back(position < 0 ? 0.0f : entries[first + std::size_t(position)]);
    return slices;
}

SliceForm mostCompactForm(int slice_order, int view_order, std::span<const float> slices) {
    float largest = 0;
    for (const float value : slices) largest = std::max(largest, std::abs(value));
    for (const SliceForm form : {SliceForm::kIsotropic, SliceForm::kOrthotropic}) {
        const std::vector<float> entries = compactSlices(form, slice_order, view_order, slices);
        const std::vector<float> same = expandSlices(form, slice_order, view_order, entries);
        bool holds = true;
        for (std::size_t i = 0; i < slices.size(); ++i)
            holds &= std::abs(slices[i] - same[i]) <= kFormTolerance * largest;
        if (holds) return form;
    }
    return SliceForm::kGeneral;
}

}  // namespace penumbra
