#pragma once
// The plan of a solve: where to start, how to get near, when to believe the answer.
//
//   near:  a posture is given     -> steps with its stiffness, one linearisation at the answer; else warm
//   warm:  a shape is given       -> exact Newton; accepted when it converges and is stable
//   cold:  constant curvature     -> descent on few geodesic elements -> finer elements, descent -> exact Newton
//   check: same basin as the descent, unstable modes counted; if unstable, leave along the mode and descend again
//
// Source: cpp/MECHANICS.md, "Plan of a solve".
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "softlimb/limb/equilibrium.hpp"

namespace softlimb::limb {

struct SolveOptions {
    double tolerance = 1e-6;
    bool prefer_stable = true;
    int max_iterations = 60;
    std::function<bool()> interrupted;  // asked now and then; true ends the solve with solve::Interrupted
};

struct Solution {
    Shape shape;
    solve::SolveStatus status = solve::SolveStatus::max_iterations;
    std::string message;
    std::vector<std::string> plan;  // what was left out or simplified, and which way was taken, in words
    int iterations = 0;             // Newton iterations of the exact solver
    int descent_iterations = 0;
    double residual = 0.0, error_estimate = 0.0;
    bool conservative = true;
    bool stable = false;
    bool second_posture = false;        // another stable one was met on the way; none was looked for
    std::optional<int> unstable_modes;  // none without a potential, or without a solution
    Vector6 base_wrench = Vector6::Zero();
    std::vector<Vector6> reactions;
    bool followed = false;  // from a posture near by: the linearisation that judged it is the one at the answer
    LinearisationNumber linearisation = 0;  // that one, while its thread keeps it
};

/// What is known of an equilibrium that Newton converged to: outcome, stability, base wrench, reactions.
Solution solution_at(const Geometry& geometry, const Scene& scene, const Shape& shape, const NewtonReport& report);

/// Equilibrium of the scene. Never raises for a scene that has none: the status says so.
Solution solve(const Geometry& geometry, const Scene& scene, const SolveOptions& options, const Shape* start);

/// A scene with its solution.
struct Solved {
    const Geometry& geometry;
    const Scene& scene;
    const Solution& solution;
};

/// The same from a posture that was solved before: where it is near, with its stiffness (Equilibrium::follow). The
/// answer does not depend on whether that stiffness is still at hand.
Solution solve(const Geometry& geometry, const Scene& scene, const SolveOptions& options, const Solved& start);

}  // namespace softlimb::limb
