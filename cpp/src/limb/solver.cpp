#include "softlimb/limb/solver.hpp"

#include <algorithm>
#include <sstream>

#include "softlimb/largest.hpp"
#include "softlimb/limb/attempt.hpp"
#include "softlimb/limb/cantilever.hpp"
#include "softlimb/limb/detour.hpp"
#include "softlimb/limb/shortcut.hpp"
#include "softlimb/limb/start.hpp"

namespace softlimb::limb {
namespace {

using solve::SolveStatus;

void fill(const Scene& scene, const Equilibrium& equilibrium, Attempt attempt, Solution& solution) {
    solution.shape = std::move(attempt.shape);
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
        solution.stable = equilibrium.diverging_modes() == 0;
    }
    solution.base_wrench = equilibrium.base_wrench(solution.shape);
    solution.reactions = equilibrium.reactions(solution.shape);
}

std::string millimetres(double length) {
    std::ostringstream text;
    text.precision(3);
    text << 1e3 * length;
    return text.str();
}

std::string count_of(int modes) { return std::to_string(modes) + (modes == 1 ? " unstable mode" : " unstable modes"); }

// A cold start of the reference limb takes about 2 000 evaluations of its nine rods; a rod wound into five turns takes
// 40 000.
long budget_of(const Scene& scene) { return 40'000L * (1 + static_cast<long>(scene.rods.size())); }

void note_columns(const Scene& scene, Solution& solution) {
    if (!scene.loads_rods())
        solution.plan.push_back("no gravity or other load along the rods: six columns a piece instead of eight");
}

/// Largest relative change of a rest length.
double lengthening(const Scene& before, const Scene& now) {
    double largest = 0.0;
    for (std::size_t i = 0; i < now.rods.size(); ++i)
        grow(largest, std::abs(now.rods[i].rest_length / before.rods[i].rest_length - 1.0));
    return largest;
}

}  // namespace

Solution solution_at(const Geometry& geometry, const Scene& scene, const Shape& shape, const NewtonReport& report) {
    Solution solution;
    solution.conservative = scene.conservative();
    solution.iterations = report.iterations;
    Equilibrium equilibrium(geometry, scene);
    equilibrium.linearise_at(shape, report.neutral_mode);
    fill(scene, equilibrium, {shape, report}, solution);
    return solution;
}

Solution solve(const Geometry& geometry, const Scene& scene, const SolveOptions& options, const Shape* start) {
    if (start == nullptr && geometry.plates() > 1 && options.prefer_stable && unloaded(geometry, scene)) {
        const auto segment = [](const Geometry& part, const Scene& at, const SolveOptions& how) {
            return solve(part, at, how, nullptr);
        };
        if (std::optional<Solution> whole = solve_apart(geometry, scene, options, segment)) return *std::move(whole);
    }
    if (start == nullptr && options.prefer_stable)
        if (std::optional<Solution> shot = solve_cantilever(geometry, scene, options)) return *std::move(shot);
    Solution solution;
    solution.conservative = scene.conservative();
    const long budget = budget_of(scene);
    solve::Work work(budget, options.interrupted);
    solution.reactions.assign(geometry.plates(), Vector6::Zero());  // of a solve that fails: verification reads them
    Equilibrium equilibrium(geometry, scene);
    std::optional<Attempt> unstable;  // found on the way, in case nothing better turns up

    const auto accept = [&](Attempt attempt, std::string message) {
        fill(scene, equilibrium, std::move(attempt), solution);
        if (!solution.stable && !solution.conservative) message += "; not stable: a small push would grow (divergence)";
        if (attempt.report.neutral_mode)
            message += "; a move of the limb costs nothing here: the posture is one of many equal ones";
        solution.message = std::move(message);
        note_columns(scene, solution);
        return std::move(solution);
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
    // Both sides of a ridge lead down: where the far side ends in another stable posture, the message says so.
    const auto second_posture = [&](const Ridge& ridge, const Attempt& first) -> std::string {
        if (!ridge.other || !solution.conservative) return "";
        const std::optional<Attempt> second =
            stable_below(geometry, scene, loosened(options, 1e-4), work, *ridge.other);
        if (!second || distance(geometry, first.shape, second->shape) < 0.01) return "";
        solution.second_posture = true;
        const double away = (second->shape.plates.back().position - first.shape.plates.back().position).norm();
        return "; another stable posture exists, its tip " + millimetres(away) + " mm away";
    };
    const auto allowed = [](const Attempt& attempt) {
        return attempt.stable() ? "converged" : "converged to an unstable posture, as allowed";
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
        Attempt attempt = refine(scene, brief, work, equilibrium, shape, solution.iterations, warm_piece);
        // A full Newton from a warm start may still run away to another posture: it must stay within reach.
        if (attempt.converged() && (!options.prefer_stable || distance(geometry, attempt.shape, shape) < 2.0)) {
            if (good_enough(attempt)) {
                solution.plan.push_back("started from the given posture: Newton alone");
                const char* message = allowed(attempt);
                return accept(std::move(attempt), message);
            }
            unstable = attempt;
            shape = attempt.shape;
        }
    } else {
        shape = geodesic_shape(geometry, scene, constant_curvature_plates(geometry, scene), 1);
        set_geodesic_wrenches(scene, shape, Stiffness::softened);
        if (std::optional<Shape> straight = straight_shape(geometry, scene)) {
            Attempt attempt =
                refine(scene, options, work, equilibrium, *std::move(straight), solution.iterations, warm_piece);
            if (good_enough(attempt)) {
                solution.plan.push_back("equal pressures and loads along the axis: straight, in closed form");
                return accept(attempt, allowed(attempt));
            }
            if (attempt.converged()) unstable = std::move(attempt);
        }
        if (!options.prefer_stable) {
            Shape fine = shape;
            for (RodShape& rod : fine.rods) split_elements(rod, 4);
            set_geodesic_wrenches(scene, fine, Stiffness::softened);
            Attempt attempt = refine(scene, options, work, equilibrium, std::move(fine), solution.iterations);
            if (attempt.converged()) {
                solution.plan.push_back("started from constant curvature: Newton alone, any equilibrium accepted");
                return accept(attempt, allowed(attempt));
            }
        }
    }

    // Far starts: descend on a coarse mesh, then on finer ones until the exact solution is the descent's own.
    std::optional<Ridge> ridge;
    DescentReport coarse = descend(geometry, scene, work, shape, solution.descent_iterations);
    if (coarse.ridge) ridge = std::move(coarse.ridge);
    solution.plan.push_back(start ? "the given start was not enough: descent of the energy from there"
                                  : "no start given: descent of the energy from constant curvature");
    Attempt last;
    constexpr int finest = 64;
    bool rim_tried = false;
    constexpr const char* past_a_fold = "converged; beyond a posture that ends just before this scene, at a fold";
    // Just past a fold the mesh may still have the minimum that the exact rods have lost: over its shallow rim.
    const auto over_the_rim = [&]() -> std::optional<Attempt> {
        rim_tried = true;
        const Ridge rim = Descent(geometry, scene, work).sides_of(shape);
        for (const std::optional<Shape>* side : {&rim.taken, &rim.other}) {
            if (!*side) continue;
            const std::optional<Attempt> below = stable_below(geometry, scene, options, work, **side);
            if (!below) continue;
            // Once more with the equilibrium at hand: reactions belong to its last linearisation.
            Attempt full = refine(scene, options, work, equilibrium, below->shape, solution.iterations);
            if (full.stable()) return full;
        }
        return std::nullopt;
    };
    double carried = 0.0;  // share of the loads without potential, where they were grown
    for (const int parts : {2, 4, 8, 16, finest}) {
        if (work.exhausted()) break;
        // The finest mesh costs more than all before it together.
        if (parts == finest && !unstable && solution.conservative)
            if (std::optional<Attempt> full = over_the_rim()) return accept(*std::move(full), past_a_fold);
        // From a mesh that is fine enough Newton takes three to six iterations. One that takes many more is lost, and a
        // finer mesh costs less than to wait for it.
        SolveOptions few = options;
        if (parts < finest) few.max_iterations = std::min(options.max_iterations, 12);
        auto [fine, attempt, stayed] = attempt_on_mesh(scene, few, work, equilibrium, parts, shape,
                                                       solution.descent_iterations, solution.iterations);
        if (fine.ridge && !ridge) ridge = std::move(fine.ridge);
        if (attempt.converged()) {
            if (stayed && good_enough(attempt)) {
                std::string message = "converged";
                if (unstable || (ridge && attempt.stable() && is_unstable_posture(ridge->top)))
                    message += "; an unstable posture was met first and left along its mode";
                if (ridge && attempt.stable() && !attempt.report.neutral_mode)
                    message += second_posture(*ridge, attempt);
                if (!attempt.stable() && solution.conservative)
                    message += " to an unstable posture (" +
                               count_of(attempt.report.plate_modes + attempt.report.rod_modes) + ")";
                return accept(attempt, message);
            }
            if (!unstable || attempt.stable()) unstable = attempt;
        }
        last = std::move(attempt);
        const bool descent_lost = fine.status != SolveStatus::converged;
        if (solution.conservative || carried > 0.0 || (parts < 16 && !descent_lost)) continue;
        // No potential to descend and no luck near where the work led: the loads themselves are the way.
        const Scene bare = with_moments(scene, 0.0);
        if (!bare.conservative()) continue;  // a moment that is no number does not vanish at no share
        const Solution unmoved = solve(geometry, bare, loosened(options, 1e-6), nullptr);
        solution.iterations += unmoved.iterations;
        if (unmoved.status != SolveStatus::converged) continue;
        const std::optional<Shape> grown =
            grow_moments(geometry, scene, options, unmoved.shape, work, solution.iterations, carried);
        if (!grown) continue;
        Attempt full = refine(scene, options, work, equilibrium, *grown, solution.iterations);
        if (!full.converged()) continue;
        solution.plan.push_back("the descent did not lead there: loads without potential grown step by step");
        return accept(full, "converged along the growing loads");
    }
    if (!unstable && !rim_tried && solution.conservative && !last.shape.plates.empty())
        if (std::optional<Attempt> full = over_the_rim()) return accept(*std::move(full), past_a_fold);
    if (!unstable) {
        if (const auto stiff = stiffen(geometry, scene, options, shape, work, solution.iterations)) {
            Attempt full = refine(scene, options, work, equilibrium, *stiff, solution.iterations);
            if (good_enough(full)) {
                solution.plan.push_back("the rods stretch hardly at all: their stiffness grown step by step");
                return accept(full, "converged along the growing stiffness");
            }
            if (full.converged()) unstable = full;
        }
    }
    if (start != nullptr && options.prefer_stable && !(unstable && unstable->stable())) {
        // The start led nowhere, or to unstable postures alone. From nothing is another way.
        Solution cold = solve(geometry, scene, options, nullptr);
        if (cold.status == SolveStatus::converged && (cold.stable || !unstable)) {
            cold.message += "; the given start did not lead there";
            cold.iterations += solution.iterations;
            cold.descent_iterations += solution.descent_iterations;
            cold.plan.insert(cold.plan.begin(), "the given start was given up");
            return cold;
        }
    }
    if (unstable && !unstable->stable() && solution.conservative && options.prefer_stable) {
        // Both ways are long and may lead nowhere: what is left of the budget belongs to the answer that stands.
        solve::Work pushes(budget, options.interrupted), detour(budget, options.interrupted);
        if (std::optional<Attempt> beside =
                left_along_mode(scene, options, pushes, equilibrium, unstable->shape, solution.iterations))
            return accept(*std::move(beside), "converged; an unstable posture was met first and left along its mode");
        if (const auto buckled = buckle(geometry, scene, options, unstable->shape, detour, solution.iterations)) {
            Attempt full = refine(scene, options, work, equilibrium, *buckled, solution.iterations);
            if (full.stable()) {
                solution.plan.push_back(
                    "the rods stretch hardly at all: buckled where they stretch more, and followed");
                return accept(std::move(full), "converged; an unstable posture was met first and left along its mode");
            }
        }
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
        case SolveStatus::converged:
            // Newton settled, but somewhere that neither the descent nor a second look confirms.
            solution.message = solution.stable ? "converged; not where the descent ended, another posture may exist"
                                               : "converged to an unstable posture: no stable one was found";
            break;
        default:
            solution.message = work.exhausted() ? "not converged: the solve's budget of evaluations ran out"
                                                : "not converged: Newton's iterations ran out from every mesh";
    }
    if (carried > 0.0 && carried < 1.0)
        solution.message += "; grown from nothing, the loads without potential reached " +
                            std::to_string(static_cast<int>(100.0 * carried)) + " per cent";
    return solution;
}

Solution solve(const Geometry& geometry, const Scene& scene, const SolveOptions& options, const Solved& start) {
    const Solution& before = start.solution;
    // With held plates it is wrenches that are asked for, and steps of the poses say little of them. Without a
    // linearisation of its own a start is worth one where the answer is probably near enough to be followed.
    constexpr double near_lengthening = 0.005;
    const bool same_limb = &start.geometry == &geometry || start.geometry == geometry;
    if (before.status != SolveStatus::converged || !before.stable || !same_limb || start.scene.holds_plates() ||
        scene.holds_plates() || (!before.followed && !(lengthening(start.scene, scene) < near_lengthening)))
        return solve(geometry, scene, options, &before.shape);
    Attempt attempt;
    attempt.shape = before.shape;
    choose_mesh(scene, options.tolerance, attempt.shape, warm_piece);
    // Steps that the check asked to be shorter are asked to be so again, unless they now are by far.
    const bool as_short = before.error_estimate > options.tolerance / 256.0;
    for (std::size_t i = 0; i < before.shape.rods.size(); ++i) {
        const RodShape& rod = before.shape.rods[i];
        RodShape& now = attempt.shape.rods[i];
        if (now.elements() != rod.elements()) return solve(geometry, scene, options, &before.shape);
        if (as_short && rod.integration.steps > now.integration.steps) ++now.integration.steps;
    }
    Equilibrium equilibrium(geometry, scene, before.linearisation);
    NewtonSettings settings;
    settings.tolerance = options.tolerance;
    solve::Work work(budget_of(scene), options.interrupted);
    attempt.report = equilibrium.follow(start.scene, before.shape, before.linearisation, attempt.shape, settings, work);
    if (!attempt.stable() || attempt.report.neutral_mode || !mesh_suffices(scene, options.tolerance, attempt.shape))
        return solve(geometry, scene, options, attempt.report.nearer ? &attempt.shape : &before.shape);
    Solution solution;
    solution.conservative = scene.conservative();
    solution.iterations = attempt.report.iterations;
    solution.message = "converged";
    solution.plan.push_back("started from the given posture: Newton alone, the first steps with its stiffness");
    note_columns(scene, solution);
    fill(scene, equilibrium, std::move(attempt), solution);
    solution.followed = true, solution.linearisation = equilibrium.keep_linearisation();
    return solution;
}

}  // namespace softlimb::limb
