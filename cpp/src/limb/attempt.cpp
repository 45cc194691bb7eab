#include "softlimb/limb/attempt.hpp"

#include <algorithm>
#include <limits>

#include "softlimb/largest.hpp"
#include "softlimb/limb/start.hpp"

namespace softlimb::limb {

using solve::SolveStatus;

double distance(const Geometry& geometry, const Shape& a, const Shape& b) {
    double largest = 0.0;
    for (int j = 0; j < geometry.plates(); ++j) {
        const Vector6 gap = rod::pose_gap(a.plates[j], b.plates[j]);
        grow(largest, gap.head<3>().norm() / geometry.length);
        grow(largest, gap.tail<3>().norm());
    }
    return largest;
}

DescentReport descend(const Geometry& geometry, const Scene& scene, solve::Work& work, Shape& shape, int& iterations) {
    DescentReport report;
    std::optional<Ridge> ridge;
    for (int refinement = 0; refinement < 8; ++refinement) {
        Descent descent(geometry, scene, work);
        DescentSettings settings;
        // One element a rod is a start for two and no more, and from two Newton mostly finds the way; what comes to
        // finer meshes has shown that it needs to start near.
        const double elements = shape.rods.front().elements();
        settings.hand_over = std::max(settings.small_step, 0.2 / (elements * elements));
        report = descent.run(shape, settings);
        iterations += report.iterations;
        if (report.ridge && !ridge) ridge = std::move(report.ridge);
        if (!report.needs_refinement || work.exhausted()) break;
        // An element of so fine a mesh that still bends too far belongs to no posture that a descent will find.
        constexpr int finest = 128;
        if (shape.rods.front().elements() >= finest) break;
        for (RodShape& rod : shape.rods) split_elements(rod, 2);
    }
    report.ridge = std::move(ridge);
    return report;
}

Attempt refine(const Scene& scene, const SolveOptions& options, solve::Work& work, Equilibrium& equilibrium,
               Shape shape, int& iterations, double largest_piece) {
    Attempt attempt;
    NewtonSettings settings;
    settings.tolerance = options.tolerance;
    settings.max_iterations = options.max_iterations;
    choose_mesh(scene, options.tolerance, shape, largest_piece);
    attempt.shape = std::move(shape);
    // Pieces that were found to be too long are not joined again: the mesh settles.
    constexpr int rounds = 4;
    for (int round = 1;; ++round) {
        attempt.report = equilibrium.solve(attempt.shape, settings, work);
        iterations += attempt.report.iterations;
        if (!attempt.converged() || mesh_suffices(scene, options.tolerance, attempt.shape)) break;
        if (round == rounds) {
            attempt.report.status = SolveStatus::no_progress;
            break;
        }
        choose_mesh(scene, options.tolerance, attempt.shape, largest_piece, Joining::none);
    }
    return attempt;
}

SolveOptions loosened(SolveOptions options, double tolerance) {
    options.tolerance = std::max(options.tolerance, tolerance);
    return options;
}

MeshAttempt attempt_on_mesh(const Scene& scene, const SolveOptions& options, solve::Work& work,
                            Equilibrium& equilibrium, int parts, Shape& shape, int& descent_iterations,
                            int& newton_iterations) {
    const Geometry& geometry = equilibrium.geometry();
    MeshAttempt tried;
    for (RodShape& rod : shape.rods) split_elements(rod, std::max(1, parts / rod.elements()));
    tried.descent = descend(geometry, scene, work, shape, descent_iterations);
    Shape warm = shape;
    set_geodesic_wrenches(scene, warm, Stiffness::softened);
    // The coarsest mesh is tried with few pieces; where that fails, more of them make Newton's basin wider.
    const double largest_piece = parts <= 2 ? warm_piece : newton_piece;
    tried.attempt = refine(scene, options, work, equilibrium, std::move(warm), newton_iterations, largest_piece);
    tried.stayed = tried.attempt.converged() && distance(geometry, tried.attempt.shape, shape) < 3.0 / parts;
    return tried;
}

std::optional<Attempt> stable_below(const Geometry& geometry, const Scene& scene, const SolveOptions& options,
                                    solve::Work& work, Shape shape) {
    Equilibrium equilibrium(geometry, scene);
    int ignored = 0;
    for (const int parts : {4, 16}) {
        MeshAttempt tried = attempt_on_mesh(scene, options, work, equilibrium, parts, shape, ignored, ignored);
        if (tried.stayed && tried.attempt.stable()) return std::move(tried.attempt);
        if (work.exhausted()) break;
    }
    return std::nullopt;
}

std::optional<Attempt> left_along_mode(const Scene& scene, const SolveOptions& options, solve::Work& work,
                                       Equilibrium& equilibrium, const Shape& unstable, int& iterations) {
    Shape ridge = unstable;
    int modes = std::numeric_limits<int>::max();
    // Where several modes are lost at once, each push leaves one of them behind; rods that have buckled before may turn
    // about their axes at no cost, which leads nowhere.
    constexpr int pushes = 8, most = 6;
    for (int push = 0; push < pushes; ++push) {
        std::optional<Attempt> lower;
        const auto leave = [&](const Moves& mode) {
            // The stiffer the rods against stretching, the smaller what buckles just past the load.
            for (const double amplitude : {0.3, -0.3, 0.03, -0.03, 0.003, -0.003}) {
                Shape pushed = ridge;
                apply(equilibrium.geometry(), mode, amplitude, pushed);
                Attempt beside = refine(scene, options, work, equilibrium, std::move(pushed), iterations);
                if (!beside.converged() || beside.report.modes() >= modes) continue;
                modes = beside.report.modes();
                lower = std::move(beside);
                if (modes == 0) break;
            }
        };
        const int rods = static_cast<int>(scene.rods.size());
        for (const Moves& mode : equilibrium.softest_moves(ridge, std::min(most, 1 + rods))) {
            leave(mode);
            if (lower) break;
        }
        if (!lower) break;
        if (modes == 0) return lower;
        ridge = std::move(lower->shape);
    }
    return std::nullopt;
}

}  // namespace softlimb::limb
