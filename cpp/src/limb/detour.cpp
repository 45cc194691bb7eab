#include "softlimb/limb/detour.hpp"

#include <algorithm>
#include <cmath>

#include "softlimb/limb/attempt.hpp"
#include "softlimb/limb/path.hpp"
#include "softlimb/limb/start.hpp"

namespace softlimb::limb {
namespace {

/// The scene with every rod at a share of the way from its softened stiffness (0) to its own (1), in proportion.
Scene stiffened(const Scene& scene, double share) {
    Scene part = scene;
    for (std::size_t i = 0; i < scene.rods.size(); ++i) {
        const Section soft = softened(scene.rods[i]);
        Section& section = part.rods[i].section;
        const double axial = std::pow(soft.axial / section.axial, 1.0 - share);
        section.shear *= std::pow(soft.shear / section.shear, 1.0 - share);
        section.axial *= axial;
        // The axial law over the same strains at smaller forces.
        section.axial_law.centre *= axial, section.axial_law.half_range *= axial;
        for (double& c : section.axial_law.coefficient) c /= axial;
    }
    return part;
}

}  // namespace

Scene with_moments(const Scene& scene, double share) {
    Scene part = scene;
    for (Vector6& w : part.wrenches) {
        w.tail<3>() *= share;
        if (scene.following) w.head<3>() *= share;
    }
    for (RodAtPressure& rod : part.rods) rod.line_load.moment = share * rod.line_load.moment;
    return part;
}

std::optional<Shape> grow_moments(const Geometry& geometry, const Scene& scene, const SolveOptions& options,
                                  const Shape& unmoved, solve::Work& work, int& iterations, double& farthest) {
    const SolveOptions rough = loosened(options, 1e-6);  // only the last step has to be exact
    PathSettings settings;
    settings.tolerance = rough.tolerance;
    settings.first_step = 0.1, settings.largest_step = 1.0;
    settings.locate = false;
    const Scene bare = with_moments(scene, 0.0);
    Shape rest = unmoved;
    constexpr int valleys = 4;
    for (int valley = 0; valley < valleys; ++valley) {
        const Path path =
            follow(geometry, [&](double share) { return with_moments(scene, share); }, rest, settings, work);
        for (const PathPoint& point : path.points) {
            iterations += point.report.iterations;
            farthest = std::max(farthest, point.parameter);
        }
        if (path.end == PathEnd::stop) return path.points.back().shape;
        if (path.end != PathEnd::start) break;
        // A fold sent the path back to the bare scene, to the ridge between this valley and another, from which the
        // full loads may be reached: solutions of such scenes come and go in pairs, and one is left over.
        Ridge ridge = Descent(geometry, bare, work).sides_of(path.points.back().shape);
        std::optional<Attempt> beyond;
        for (std::optional<Shape>* side : {&ridge.taken, &ridge.other}) {
            if (*side) beyond = stable_below(geometry, bare, rough, work, **side);
            if (beyond && distance(geometry, beyond->shape, rest) > 0.01) break;
            beyond.reset();
        }
        if (!beyond) break;  // both sides lead home: no other valley to start from
        rest = std::move(beyond->shape);
    }
    return std::nullopt;
}

std::optional<Shape> stiffen(const Geometry& geometry, const Scene& scene, const SolveOptions& options,
                             const Shape& descended, solve::Work& work, int& iterations) {
    const bool softer = std::any_of(scene.rods.begin(), scene.rods.end(), [](const RodAtPressure& rod) {
        return softened(rod).axial < rod.section.axial || softened(rod).shear < rod.section.shear;
    });
    if (!softer) return std::nullopt;
    const SolveOptions rough = loosened(options, 1e-6);
    const std::optional<Attempt> soft = stable_below(geometry, stiffened(scene, 0.0), rough, work, descended);
    if (!soft) return std::nullopt;
    PathSettings settings;
    settings.tolerance = rough.tolerance;
    settings.largest_step = 0.3;
    settings.locate = false;
    const Path path =
        follow(geometry, [&](double share) { return stiffened(scene, share); }, soft->shape, settings, work);
    for (const PathPoint& point : path.points) iterations += point.report.iterations;
    if (path.end != PathEnd::stop) return std::nullopt;
    return path.points.back().shape;
}

}  // namespace softlimb::limb
