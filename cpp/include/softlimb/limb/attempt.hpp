#pragma once
// One try at an equilibrium: a descent on a mesh, then exact Newton between the same nodes. The plan of a solve and its
// detours are made of these. Source: cpp/MECHANICS.md, "Plan of a solve".
#include <optional>

#include "softlimb/limb/descent.hpp"
#include "softlimb/limb/equilibrium.hpp"
#include "softlimb/limb/solver.hpp"

namespace softlimb::limb {

struct Attempt {
    Shape shape;
    NewtonReport report;
    bool converged() const { return report.status == solve::SolveStatus::converged; }
    bool stable() const { return converged() && report.modes() == 0; }
};

/// Largest distance of two shapes' plates: translations relative to the limb, rotations in radians.
double distance(const Geometry& geometry, const Shape& a, const Shape& b);

/// Descends until the mesh is fine enough for its bends and the descent is done.
DescentReport descend(const Geometry& geometry, const Scene& scene, solve::Work& work, Shape& shape, int& iterations);

/// Exact Newton from a shape whose wrenches are set; refines the mesh until no piece is active enough to hide a mode.
Attempt refine(const Scene& scene, const SolveOptions& options, solve::Work& work, Equilibrium& equilibrium,
               Shape shape, int& iterations, double largest_piece = newton_piece);

/// The same options with a tolerance no tighter than `tolerance`: for steps on the way, which need not be exact.
SolveOptions loosened(SolveOptions options, double tolerance);

/// Splits the rods of `shape` into `parts` elements at least, descends, and tries exact Newton from there. `shape` is
/// left where the descent ended.
struct MeshAttempt {
    DescentReport descent;
    Attempt attempt;
    bool stayed = false;  // converged, and within what the mesh may err of where the descent ended
};
MeshAttempt attempt_on_mesh(const Scene& scene, const SolveOptions& options, solve::Work& work,
                            Equilibrium& equilibrium, int parts, Shape& shape, int& descent_iterations,
                            int& newton_iterations);

/// The stable equilibrium to which a shape on a mesh slides down, if the exact rods have one there.
std::optional<Attempt> stable_below(const Geometry& geometry, const Scene& scene, const SolveOptions& options,
                                    solve::Work& work, Shape shape);

/// A stable equilibrium beside an unstable one of the same scene: exact Newton from points along its softest move. Just
/// past a critical load the buckled posture is so near that no mesh tells it from the straight one.
std::optional<Attempt> left_along_mode(const Scene& scene, const SolveOptions& options, solve::Work& work,
                                       Equilibrium& equilibrium, const Shape& unstable, int& iterations);

}  // namespace softlimb::limb
