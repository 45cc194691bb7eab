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

/// Largest ratio of a rod's stiffness against stretch or shear to its softened one: 1 where none was softened.
double hardest(const Scene& scene) {
    double largest = 1.0;
    for (const RodAtPressure& rod : scene.rods) {
        const Section soft = softened(rod);
        largest = std::max({largest, rod.section.axial / soft.axial, rod.section.shear / soft.shear});
    }
    return largest;
}

/// Follows `first`, of the scene stiffened to `share`, towards the scene itself.
Path follow_stiffness(const Geometry& geometry, const Scene& scene, double tolerance, double share, const Shape& first,
                      solve::Work& work, int& iterations) {
    PathSettings settings;
    settings.start = share;
    settings.tolerance = tolerance;
    settings.largest_step = 0.3;
    settings.locate = false;
    Path path = follow(geometry, [&](double to) { return stiffened(scene, to); }, first, settings, work);
    for (const PathPoint& point : path.points) iterations += point.report.iterations;
    return path;
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
    if (hardest(scene) == 1.0) return std::nullopt;
    const SolveOptions rough = loosened(options, 1e-6);
    const std::optional<Attempt> soft = stable_below(geometry, stiffened(scene, 0.0), rough, work, descended);
    if (!soft) return std::nullopt;
    Path path = follow_stiffness(geometry, scene, rough.tolerance, 0.0, soft->shape, work, iterations);
    if (path.end != PathEnd::stop) return std::nullopt;
    return std::move(path.points.back().shape);
}

std::optional<Shape> buckle(const Geometry& geometry, const Scene& scene, const SolveOptions& options,
                            const Shape& unstable, solve::Work& work, int& iterations) {
    const double harder = std::log(hardest(scene));
    if (harder == 0.0) return std::nullopt;
    const SolveOptions rough = loosened(options, 1e-6);
    const auto at = [&](double share, const Shape& start) {
        const Scene part = stiffened(scene, share);
        Equilibrium equilibrium(geometry, part);
        return refine(part, rough, work, equilibrium, start, iterations);
    };
    Attempt here = at(0.0, unstable);
    if (!here.stable()) {
        std::optional<Attempt> below = stable_below(geometry, stiffened(scene, 0.0), rough, work, unstable);
        if (!below) return std::nullopt;
        here = *std::move(below);
    }
    double share = 0.0;
    const std::size_t most = 8 + 4 * scene.rods.size();  // rods buckle one by one, and some again
    for (std::size_t round = 0; round < most && !work.exhausted(); ++round) {
        Path path = follow_stiffness(geometry, scene, rough.tolerance, share, here.shape, work, iterations);
        const auto lost = std::find_if(path.points.begin(), path.points.end(),
                                       [](const PathPoint& point) { return point.modes() > 0; });
        if (lost == path.points.end()) {
            if (path.end != PathEnd::stop) return std::nullopt;
            return std::move(path.points.back().shape);
        }
        if (lost == path.points.begin()) return std::nullopt;
        double stable = std::prev(lost)->parameter;
        share = lost->parameter;
        Shape past = lost->shape;
        std::optional<Attempt> beside;
        // A tenth of the stiffness past the loss a push mostly serves; nearer to it where it does not.
        for (const double near : {0.1, 0.03, 0.01}) {
            while ((share - stable) * harder > near) {
                const double middle = 0.5 * (stable + share);
                Attempt found = at(middle, past);
                if (!found.converged()) return std::nullopt;
                (found.stable() ? stable : share) = middle;
                if (!found.stable()) past = std::move(found.shape);
            }
            const Scene part = stiffened(scene, share);
            Equilibrium equilibrium(geometry, part);
            beside = left_along_mode(part, rough, work, equilibrium, past, iterations);
            if (beside) break;
        }
        if (!beside) return std::nullopt;
        here = *std::move(beside);
        if (share == 1.0) return std::move(here.shape);
    }
    return std::nullopt;
}

}  // namespace softlimb::limb
