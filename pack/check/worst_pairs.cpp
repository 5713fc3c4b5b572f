#include "pack/check/worst_pairs.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <map>

namespace penumbra {

namespace {

constexpr std::size_t kCandidates = 1024;  // candidates for each pair that is wanted

bool worse(const PlaceError& a, const PlaceError& b) {
    if (a.size() != b.size()) return a.size() > b.size();
    return a.frame != b.frame ? a.frame < b.frame : a.vertex < b.vertex;
}

}  // namespace

WorstPairs::WorstPairs(const AssetView& asset, const FrameList& frames, const PlaceSpread& spread)
    : frames_(frames),
      spread_(spread),
      rest_(asset.mesh.positions),
      distance_(spread.distance * float(boxDiagonal({rest_.begin(), rest_.end()}))) {
    std::map<std::array<long, 3>, std::uint32_t> cells;
    for (const Vec3 p : rest_) {
        const Vec3 at = distance_ > 0 ? p / distance_ : Vec3{};
        const std::array cell{std::lround(at.x), std::lround(at.y), std::lround(at.z)};
        cell_of_vertex_.push_back(cells.emplace(cell, std::uint32_t(cells.size())).first->second);
    }
    of_cell_.resize(cells.size());
}

void WorstPairs::addFrame(std::size_t frame, std::span<const float> e_model, std::span<const float> e_truth) {
    assert(e_model.size() == e_truth.size() && e_model.size() <= cell_of_vertex_.size());
    std::fill(of_cell_.begin(), of_cell_.end(), PlaceError{});
    for (std::uint32_t v = 0; v < e_model.size(); ++v) {
        const PlaceError pair{frame, v, e_model[v], e_truth[v]};
        PlaceError& worst = of_cell_[cell_of_vertex_[v]];
        if (pair.size() > worst.size()) worst = pair;
    }
    for (const PlaceError& pair : of_cell_)
        if (pair.size() > 0) candidates_.push_back(pair);
    const std::size_t most = kCandidates * spread_.count;
    if (candidates_.size() <= 2 * most) return;
    std::nth_element(candidates_.begin(), candidates_.begin() + std::ptrdiff_t(most), candidates_.end(), worse);
    candidates_.resize(most);
}

bool WorstPairs::nearby(const PlaceError& a, const PlaceError& b) const {
    return length(rest_[a.vertex] - rest_[b.vertex]) <= distance_;
}

std::vector<PlaceError> WorstPairs::chosen() const {
    std::vector<PlaceError> sorted = candidates_, chosen;
    std::sort(sorted.begin(), sorted.end(), worse);
    for (const PlaceError& pair : sorted) {
        if (chosen.size() == spread_.count) break;
        std::size_t close = 0;
        bool same_run = false;
        for (const PlaceError& other : chosen) {
            if (!nearby(pair, other)) continue;
            ++close;
            same_run |= frames_.clip[pair.frame] == frames_.clip[other.frame] &&
                        std::abs(frames_.time[pair.frame] - frames_.time[other.frame]) <= spread_.seconds;
        }
        if (!same_run && close < spread_.per_neighbourhood) chosen.push_back(pair);
    }
    return chosen;
}

}  // namespace penumbra
