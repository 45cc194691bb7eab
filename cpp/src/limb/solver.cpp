#include "softlimb/limb/solver.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>

#include "softlimb/largest.hpp"
#include "softlimb/limb/descent.hpp"
#include "softlimb/limb/start.hpp"

namespace softlimb::limb {
namespace {

using solve::SolveStatus;

/// Largest distance of two shapes' plates: translations relative to the limb, rotations in radians.
double distance(const Geometry& geometry, const Shape& a, const Shape& b) {
    double largest = 0.0;
    for (int j = 0; j < geometry.plates(); ++j) {
        const Vector6 gap = rod::pose_gap(a.plates[j], b.plates[j]);
        grow(largest, gap.head<3>().norm() / geometry.length);
        grow(largest, gap.tail<3>().norm());
    }
    return largest;
}

/// Descends until the mesh is fine enough for its bends and the descent is done.
DescentReport descend(const Geometry& geometry, const Scene& scene, solve::Work& work, Shape& shape, int& iterations) {
    DescentReport report;
    std::optional<Shape> saddle;
    for (int refinement = 0; refinement < 8; ++refinement) {
        Descent descent(geometry, scene, work);
        report = descent.run(shape, {});
        iterations += report.iterations;
        if (report.saddle && !saddle) saddle = std::move(report.saddle);
        if (!report.needs_refinement || work.exhausted()) break;
        // An element of so fine a mesh that still bends too far belongs to no posture that a descent will find.
        constexpr int finest = 128;
        if (shape.rods.front().elements() >= finest) break;
        for (RodShape& rod : shape.rods) split_elements(rod, 2);
    }
    report.saddle = std::move(saddle);
    return report;
}

struct Attempt {
    Shape shape;
    NewtonReport report;
    bool converged() const { return report.status == SolveStatus::converged; }
    bool stable() const { return converged() && report.plate_modes + report.rod_modes == 0; }
};

/// Exact Newton from a shape whose wrenches are set; refines the mesh until no piece is active enough to hide a mode.
Attempt refine(const Scene& scene, const SolveOptions& options, solve::Work& work, Equilibrium& equilibrium,
               Shape shape, int& iterations) {
    Attempt attempt;
    NewtonSettings settings;
    settings.tolerance = options.tolerance;
    settings.max_iterations = options.max_iterations;
    choose_mesh(scene, options.tolerance, shape);
    attempt.shape = std::move(shape);
    for (int round = 0; round < 4; ++round) {
        attempt.report = equilibrium.solve(attempt.shape, settings, work);
        iterations += attempt.report.iterations;
        if (!attempt.converged() || largest_activity(scene, attempt.shape) < 3.0) break;
        choose_mesh(scene, options.tolerance, attempt.shape);
    }
    return attempt;
}

/// Loads grown from nothing to all, Newton from each step's posture: the way for loads without a potential, and for
/// those that wind a rod up so far that no straight start reaches it. Ends early where the path folds.
std::optional<Shape> grow_loads(const Geometry& geometry, const Scene& scene, const SolveOptions& options,
                                const Shape& unloaded, solve::Work& work, int& iterations) {
    constexpr double smallest_step = 1e-3, largest_step = 0.25;
    SolveOptions rough = options;
    rough.tolerance = std::max(options.tolerance, 1e-6);  // only the last step has to be exact
    rough.max_iterations = 12;                            // a step that takes more is too long
    Scene part = scene;
    Equilibrium equilibrium(geometry, part);
    Shape reached = unloaded;
    double done = 0.0, step = 0.1;
    while (done < 1.0) {
        const double share = std::min(1.0, done + step);
        part.gravity = share * scene.gravity;
        for (std::size_t j = 0; j < scene.wrenches.size(); ++j) part.wrenches[j] = share * scene.wrenches[j];
        for (std::size_t i = 0; i < scene.rods.size(); ++i) {
            part.rods[i].line_load.force = share * scene.rods[i].line_load.force;
            part.rods[i].line_load.moment = share * scene.rods[i].line_load.moment;
        }
        Attempt attempt = refine(part, rough, work, equilibrium, reached, iterations);
        if (work.exhausted()) return std::nullopt;
        // A step that jumps has left the path.
        if (attempt.converged() && distance(geometry, attempt.shape, reached) < 1.0) {
            reached = std::move(attempt.shape);
            done = share;
            step = std::min(1.5 * step, largest_step);
            continue;
        }
        step *= 0.4;
        if (step < smallest_step) return std::nullopt;
    }
    return reached;
}

/// The same scene without any load.
Scene unloaded(const Scene& scene) {
    Scene bare = scene;
    bare.gravity.setZero();
    for (Vector6& w : bare.wrenches) w.setZero();
    for (RodAtPressure& rod : bare.rods) rod.line_load = {};
    return bare;
}

/// Real negative eigenvalues of a stiffness that is not symmetric: ways in which the limb diverges without oscillating.
bool diverges(const Eigen::MatrixXd& stiffness) {
    const Eigen::EigenSolver<Eigen::MatrixXd> solver(stiffness, false);
    for (const auto& value : solver.eigenvalues())
        if (value.real() < 0.0 && std::abs(value.imag()) < 1e-12 * std::abs(value.real())) return true;
    return false;
}

void fill(const Scene& scene, const Equilibrium& equilibrium, const Attempt& attempt, Solution& solution) {
    solution.shape = attempt.shape;
    solution.status = attempt.report.status;
    solution.residual = attempt.report.residual;
    solution.error_estimate = attempt.report.error_estimate;
    if (!attempt.converged()) return;
    const int modes = attempt.report.plate_modes + attempt.report.rod_modes;
    solution.stable = modes == 0;
    if (scene.conservative()) {
        solution.unstable_modes = modes;
    } else if (modes > 0 && attempt.report.rod_modes == 0) {
        // A positive definite symmetric part excludes divergence; otherwise the eigenvalues themselves tell.
        solution.stable = !diverges(equilibrium.dense_stiffness());
    }
    solution.base_wrench = equilibrium.base_wrench(solution.shape);
    solution.reactions = equilibrium.reactions(solution.shape);
}

std::string count_of(int modes) { return std::to_string(modes) + (modes == 1 ? " unstable mode" : " unstable modes"); }

}  // namespace

Solution solve(const Geometry& geometry, const Scene& scene, const SolveOptions& options, const Shape* start) {
    Solution solution;
    solution.conservative = scene.conservative();
    // A cold start of the reference limb takes about 2 000 evaluations of its nine rods; a rod wound into five turns
    // takes 40 000.
    solve::Work work(40'000L * (1 + static_cast<long>(scene.rods.size())), options.interrupted);
    solution.reactions.assign(geometry.plates(), Vector6::Zero());  // of a solve that fails: verification reads them
    Equilibrium equilibrium(geometry, scene);
    std::optional<Attempt> unstable;  // found on the way, in case nothing better turns up

    const auto accept = [&](const Attempt& attempt, std::string message) {
        fill(scene, equilibrium, attempt, solution);
        if (!solution.stable && !solution.conservative) message += "; not stable: a small push would grow (divergence)";
        if (attempt.report.neutral_mode)
            message += "; a move of the limb costs nothing here: the posture is one of many equal ones";
        solution.message = std::move(message);
        return solution;
    };
    // A saddle of the mesh is worth a word only if the exact rods have an unstable posture there too.
    const auto is_unstable_posture = [&](Shape shape) {
        for (RodShape& rod : shape.rods) split_elements(rod, std::max(1, 4 / rod.elements()));
        set_geodesic_wrenches(scene, shape, Stiffness::softened);
        Equilibrium other(geometry, scene);
        int ignored = 0;
        const Attempt met = refine(scene, options, work, other, shape, ignored);
        return met.converged() && !met.stable() && distance(geometry, met.shape, shape) < 0.5;
    };
    const auto good_enough = [&](const Attempt& attempt) {
        return attempt.converged() && (attempt.stable() || !options.prefer_stable || !solution.conservative);
    };

    Shape shape;
    if (start != nullptr) {
        shape = *start;
        // A start far from the answer is worth a few steps only: the descent does better from there.
        SolveOptions brief = options;
        if (options.prefer_stable) brief.max_iterations = std::min(options.max_iterations, 15);
        Attempt attempt = refine(scene, brief, work, equilibrium, shape, solution.iterations);
        // A full Newton from a warm start may still run away to another posture: it must stay within reach.
        if (attempt.converged() && (!options.prefer_stable || distance(geometry, attempt.shape, shape) < 2.0)) {
            if (good_enough(attempt)) {
                solution.plan.push_back("started from the given posture: Newton alone");
                return accept(attempt, "converged from the given start");
            }
            unstable = attempt;
            shape = attempt.shape;
        }
    } else {
        shape = geodesic_shape(geometry, scene, constant_curvature_plates(geometry, scene), 1);
        set_geodesic_wrenches(scene, shape, Stiffness::softened);
        if (!options.prefer_stable) {
            Shape fine = shape;
            for (RodShape& rod : fine.rods) split_elements(rod, 4);
            set_geodesic_wrenches(scene, fine, Stiffness::softened);
            Attempt attempt = refine(scene, options, work, equilibrium, fine, solution.iterations);
            if (attempt.converged()) {
                solution.plan.push_back("started from constant curvature: Newton alone, any equilibrium accepted");
                return accept(attempt, attempt.stable() ? "converged" : "converged to an unstable posture, as allowed");
            }
        }
    }

    // Far starts: descend on a coarse mesh, then on finer ones until the exact solution is the descent's own.
    std::optional<Shape> saddle;
    DescentReport coarse = descend(geometry, scene, work, shape, solution.descent_iterations);
    if (coarse.saddle) saddle = std::move(coarse.saddle);
    solution.plan.push_back(start ? "the given start was not enough: descent of the energy from there"
                                  : "no start given: descent of the energy from constant curvature");
    Attempt last;
    constexpr int finest = 64;
    for (int parts = 4; parts <= finest; parts *= 2) {
        if (work.exhausted()) break;
        for (RodShape& rod : shape.rods) split_elements(rod, std::max(1, parts / rod.elements()));
        DescentReport fine = descend(geometry, scene, work, shape, solution.descent_iterations);
        if (fine.saddle && !saddle) saddle = std::move(fine.saddle);
        Shape warm = shape;
        set_geodesic_wrenches(scene, warm, Stiffness::softened);
        // From a mesh that is fine enough Newton takes three to six iterations. One that takes many more is lost, and a
        // finer mesh costs less than to wait for it.
        SolveOptions brief = options;
        if (parts < finest) brief.max_iterations = std::min(options.max_iterations, 12);
        Attempt attempt = refine(scene, brief, work, equilibrium, warm, solution.iterations);
        if (attempt.converged()) {
            const bool same = distance(geometry, attempt.shape, shape) < 3.0 / parts;
            if (same && good_enough(attempt)) {
                std::string message = "converged";
                if (unstable || (saddle && attempt.stable() && is_unstable_posture(*saddle)))
                    message += "; an unstable posture was met first and left along its mode";
                if (!attempt.stable() && solution.conservative)
                    message += " to an unstable posture (" +
                               count_of(attempt.report.plate_modes + attempt.report.rod_modes) + ")";
                return accept(attempt, message);
            }
            if (!unstable || attempt.stable()) unstable = attempt;
        }
        last = std::move(attempt);
        if (parts != 16 || solution.conservative) continue;
        // No potential to descend and no luck near where the work led: the loads themselves are the way.
        SolveOptions bare_options = options;
        bare_options.tolerance = std::max(options.tolerance, 1e-6);
        const Scene bare = unloaded(scene);
        const Solution rest = solve(geometry, bare, bare_options, nullptr);
        solution.iterations += rest.iterations;
        if (rest.status != SolveStatus::converged) continue;
        const std::optional<Shape> grown = grow_loads(geometry, scene, options, rest.shape, work, solution.iterations);
        if (!grown) continue;
        Attempt full = refine(scene, options, work, equilibrium, *grown, solution.iterations);
        if (!full.converged()) continue;
        solution.plan.push_back("the descent did not lead there: loads grown step by step");
        return accept(full, "converged along the growing loads");
    }
    if (unstable) {
        // Re-linearise at that posture, so that compliance and reactions belong to it.
        Attempt again = refine(scene, options, work, equilibrium, unstable->shape, solution.iterations);
        if (again.converged())
            return accept(again, again.stable() || !solution.conservative
                                     ? "converged; not where the descent ended, another posture may exist"
                                     : "converged to an unstable posture: no stable one was found");
    }
    if (last.shape.plates.empty()) {
        // Not even one mesh was tried: the best point is where the descent stands.
        last.shape = shape;
        set_geodesic_wrenches(scene, last.shape, Stiffness::softened);
    }
    fill(scene, equilibrium, last, solution);
    switch (last.report.status) {
        case SolveStatus::singular_jacobian:
            solution.message = "not converged: the stiffness became singular (a fold or a mechanism)";
            break;
        case SolveStatus::not_finite:
            solution.message = "not converged: the rods have no finite shape under these loads";
            break;
        default:
            solution.message = "not converged: Newton's budget ran out from every mesh";
    }
    return solution;
}

Matrix6 tip_compliance(const Geometry& geometry, const Scene& scene, const Shape& shape) {
    Equilibrium equilibrium(geometry, scene);
    if (!equilibrium.linearise_at(shape)) throw std::runtime_error("the stiffness is singular here: no compliance");
    std::vector<Vector6> wrenches(geometry.plates(), Vector6::Zero()), moves(geometry.plates());
    Matrix6 compliance;
    for (int k = 0; k < 6; ++k) {
        wrenches.back() = Vector6::Unit(k);
        equilibrium.respond(wrenches, moves);
        compliance.col(k) = moves.back();
    }
    return compliance;
}

Eigen::MatrixXd plate_stiffness(const Geometry& geometry, const Scene& scene, const Shape& shape) {
    Equilibrium equilibrium(geometry, scene);
    if (!equilibrium.linearise_at(shape)) throw std::runtime_error("the stiffness is singular here: a fold");
    Eigen::MatrixXd dense = equilibrium.dense_stiffness();
    for (int j = 0; j < geometry.plates(); ++j) {
        const Matrix6& free = equilibrium.balance().projector(j);
        dense.middleRows<6>(6 * j) = free * dense.middleRows<6>(6 * j).eval();
        dense.middleCols<6>(6 * j) = dense.middleCols<6>(6 * j).eval() * free;
    }
    return dense;
}

std::vector<Vector6> tip_response(const Geometry& geometry, const Scene& scene, const Shape& shape,
                                  const std::vector<RodSlope>& slopes) {
    Equilibrium equilibrium(geometry, scene);
    if (!equilibrium.linearise_at(shape)) throw std::runtime_error("the stiffness is singular here: no derivatives");
    std::vector<Vector6> responses, moves(geometry.plates());
    for (std::size_t i = 0; i < slopes.size(); ++i) {
        equilibrium.respond_to_rod(shape, static_cast<int>(i), slopes[i].section, slopes[i].rest_length, moves);
        responses.push_back(moves.back());
    }
    return responses;
}

}  // namespace softlimb::limb
