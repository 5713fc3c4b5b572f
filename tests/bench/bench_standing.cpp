// bench_standing RIG CLIP [FPS]: how well feet stand on dunes while a clip walks over them, for several ways to choose
// the height of the body. It prints the gap between the ground and the lowest vertex of each foot that is planted,
// which is one that the clip itself has at most 3 cm above its floor, and how the body moves up and down.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>

#include "formats/common/errors.h"
#include "formats/source/source_readers.h"
#include "sh/bounding_box.h"
#include "sh/height/analytic_heights.h"
#include "sh/height/field_in_scene.h"

namespace {

using namespace penumbra;

constexpr double kPlanted = 0.03;  // metres

struct Walk {
    std::vector<std::vector<Vec3>> poses;
    std::vector<std::vector<std::uint32_t>> feet;  // vertices of each
    double fps = 0;
};

// Splits the vertices that are lowest in the first pose into those of the left and those of the right foot, by the
// nearer one of two middles.
std::vector<std::vector<std::uint32_t>> feetOf(std::span<const Vec3> pose) {
    std::vector<std::uint32_t> low;
    const float lowest = std::ranges::min_element(pose, {}, &Vec3::y)->y;
    for (std::uint32_t v = 0; v < pose.size(); ++v)
        if (pose[v].y < lowest + 0.09f) low.push_back(v);
    const auto [left, right] = std::ranges::minmax(low, {}, [&](std::uint32_t v) { return pose[v].x; });
    Vec3 middle[2] = {pose[left], pose[right]};
    std::vector<std::vector<std::uint32_t>> feet;
    for (int round = 0; round < 20; ++round) {
        feet.assign(2, {});
        for (const std::uint32_t v : low)
            feet[length(pose[v] - middle[1]) < length(pose[v] - middle[0]) ? 1 : 0].push_back(v);
        for (std::size_t f = 0; f < 2; ++f) {
            Vec3 sum;
            for (const std::uint32_t v : feet[f]) sum += pose[v];
            middle[f] = sum / float(std::max<std::size_t>(1, feet[f].size()));
        }
    }
    return feet;
}

Walk walkOf(const Rig& rig, const std::string& name, double fps) {
    const FrameList frames = sampleFrames(rig, {}, fps);
    Walk walk;
    walk.fps = fps;
    std::vector<Vec3> normals;
    for (std::size_t f = 0; f < frames.frameCount(); ++f) {
        if (frames.clip_names[frames.clip[f]] != name) continue;
        const RigPose pose = evaluatePose(rig, int(frames.clip[f]), frames.time[f]);
        skinVertices(rig.mesh, rig.skin, rig.rest_normals, pose.bones, walk.poses.emplace_back(), normals);
    }
    if (walk.poses.size() < 3) throw UsageError(name + ": no clip of three frames or more");
    walk.feet = feetOf(walk.poses.front());
    return walk;
}

struct Ground {
    const char* name;
    HeightField field;
    Vec3d corner;
};

Ground groundOf(const char* name, const char* dunes) {
    constexpr int kSide = 512;
    constexpr float kCell = 0.05f;
    const HeightGrid grid{kSide, kSide, kCell, kCell};
    std::vector<float> heights(grid.size());
    analyticHeights(parseAnalyticHeights(dunes), grid, 0, 0, kSide, heights);
    const double half = -0.5 * (kSide - 1) * double(kCell);
    return {name, HeightField(grid, heights), {half, 0, half}};
}

// Returns the lowest vertices of the feet that are planted.
std::vector<Vec3d> plantedSoles(const Walk& walk, std::size_t frame) {
    std::vector<Vec3d> soles;
    for (const std::vector<std::uint32_t>& foot : walk.feet) {
        const auto height = [&](std::uint32_t v) { return walk.poses[frame][v].y; };
        const Vec3d sole = toDouble(walk.poses[frame][*std::ranges::min_element(foot, {}, height)]);
        if (sole.y <= kPlanted) soles.push_back(sole);
    }
    return soles;
}

double below(const Ground& ground, Vec3d p) { return heightOfField(ground.field, ground.corner, p.x, p.z); }

// The least that a body which is moved as a whole can have: in the middle between the grounds under its planted feet.
double middleOfSoles(const Walk& walk, std::size_t frame, const Ground& ground) {
    for (std::size_t f = frame + 1; f-- > 0;) {
        const std::vector<Vec3d> soles = plantedSoles(walk, f);
        if (!soles.empty()) return 0.5 * (below(ground, soles.front()) + below(ground, soles.back()));
    }
    return below(ground, toDouble(walk.poses[frame].front()));
}

// Returns the larger of the two, or NaN if either is.
double largerOrNan(double a, double b) { return a > b || std::isnan(a) ? a : b; }

using Way = std::function<double(const Walk&, std::size_t, const Ground&)>;

void printWay(const char* name, const Walk& walk, const Ground& ground, const Way& way) {
    std::vector<double> y;
    double sum = 0, most = 0, sunk = 0;
    std::size_t planted = 0;
    for (std::size_t f = 0; f < walk.poses.size(); ++f) {
        y.push_back(way(walk, f, ground));
        for (const Vec3d sole : plantedSoles(walk, f)) {
            const double gap = y.back() - below(ground, sole);
            sum += gap * gap;
            most = largerOrNan(most, std::abs(gap));
            sunk = largerOrNan(sunk, -gap);
            ++planted;
        }
    }
    double speed = 0, change = 0;
    for (std::size_t f = 1; f < y.size(); ++f) speed = largerOrNan(speed, std::abs(y[f] - y[f - 1]) * walk.fps);
    for (std::size_t f = 2; f < y.size(); ++f)
        change += std::pow((y[f] - 2 * y[f - 1] + y[f - 2]) * walk.fps * walk.fps, 2);
    std::printf("%-8s %-26s %8zu %8.1f %8.1f %8.1f %10.2f %12.1f\n", ground.name, name, planted,
                100 * std::sqrt(sum / double(std::max<std::size_t>(1, planted))), 100 * most, 100 * sunk, speed,
                std::sqrt(change / double(y.size() - 2)));
}

}  // namespace

int main(int argc, char** argv) try {
    if (argc < 3) throw UsageError("usage: bench_standing RIG CLIP [FPS]");
    const Walk walk = walkOf(readRig({argv[1]}), argv[2], argc > 3 ? std::stod(argv[3]) : 30);
    const std::pair<const char*, Way> ways[] = {
        {"below its first place",
         [&](const Walk& w, std::size_t, const Ground& g) {
             const BoundingBox box = boundsOf(w.poses.front());
             return below(g, toDouble(box.low + box.high) * 0.5);
         }},
        {"below its centroid",
         [&](const Walk& w, std::size_t f, const Ground& g) {
             Vec3 sum;
             for (const Vec3 p : w.poses[f]) sum += p;
             return below(g, toDouble(sum) / double(w.poses[f].size()));
         }},
        {"below what is lowest", [](const Walk& w, std::size_t f,
                                    const Ground& g) { return groundUnderPose(g.field, g.corner, w.poses[f], {}); }},
        {"the least there is", middleOfSoles}};
    std::printf("%s, clip %s, %zu frames\n%-8s %-26s %8s %8s %8s %8s %10s %12s\n", argv[1], argv[2], walk.poses.size(),
                "ground", "the body's height", "planted", "rms cm", "most cm", "sunk cm", "most m/s", "rms m/s^2");
    for (const Ground& ground : {groundOf("along", "dunes:height=0.8,length=4,angle=90"),
                                 groundOf("across", "dunes:height=0.8,length=4,angle=0")})
        for (const auto& [name, way] : ways) printWay(name, walk, ground, way);
    return kExitOk;
} catch (const std::exception& error) {
    return reportFailure("bench_standing", error);
}
