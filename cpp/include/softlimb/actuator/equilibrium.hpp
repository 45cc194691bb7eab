#pragma once
// Equilibrium of a wall under pressure, axial force and torque, and the path of equilibria from rest upwards.
// All in the scaled variables of wall.hpp. Source: cpp/MECHANICS.md, "Actuator".
#include <vector>

#include "softlimb/actuator/wall.hpp"
#include "softlimb/solve/status.hpp"

namespace softlimb::actuator {

/// Loads per area of the bore [Pa]: F/(pi R_i^2), P, M/(pi R_i^3).
struct WallLoads {
    double force = 0.0, pressure = 0.0, torque = 0.0;
};

/// Which unknowns may move; the others stay where the start has them.
struct Freedom {
    bool stretch = true, volume = true, twist = true;
};

/// LDL^T of the Hessian over the free unknowns; the fixed ones get a unit diagonal and no coupling.
struct Factor {
    double d_l, d_w, d_t, wl, tl, tw;
    bool positive;  // all pivots positive: stable with respect to the free unknowns

    Factor(const WallEnergy<double>& e, Freedom free, double shift = 0.0);
    /// H x = b, in place.
    void solve(double& l, double& w, double& t) const;
};

struct Equilibrium {
    Shape<double> shape;
    WallEnergy<double> energy;  // at the shape, up to the last (negligible) step
    solve::SolveStatus status = solve::SolveStatus::max_iterations;
    bool stable = false;
    int iterations = 0;

    bool converged() const { return status == solve::SolveStatus::converged; }
};

/// A Newton step this small (relative) is taken without looking again: what it leaves is of the order of its square,
/// and the Hessian at its start serves as the tangent to about ten digits (stiff fibres change it a thousand times
/// faster than the shape).
constexpr double negligible_step = 1e-11;

/// Minimum of the potential energy - force lz - pressure w - torque gamma over the free unknowns, from a start.
/// Newton's method with a bounded step and backtracking. Allocates nothing.
Equilibrium relax(const Wall& wall, const WallLoads& loads, const Shape<double>& start, Freedom free,
                  double last_step = negligible_step);

/// The state with a given stretch, whose pressure is then an answer (loads.pressure is where it starts from).
Equilibrium at_stretch(const Wall& wall, double stretch, WallLoads& loads, const Shape<double>& start, Freedom free);

/// One equilibrium on the path that the tube takes as its volume grows, with slopes along the volume.
struct PathPoint {
    Shape<double> shape;
    double pressure = 0.0;
    double d_pressure = 0.0, d_stretch = 0.0, d_twist = 0.0;  // over d volume
    bool stable = false;                                      // under given pressure
    bool stable_at_volume = false;
};

PathPoint path_point(const Equilibrium& at, Freedom free);

/// Moves along the path by a change of volume, guided by an earlier point where that is known. False when no
/// equilibrium was found there.
bool advance(const Wall& wall, const WallLoads& loads, Freedom free, const PathPoint& from, double volume,
             PathPoint& to, const PathPoint* before = nullptr);

/// Largest step of the volume from a point that keeps every change small enough for `advance` and for interpolation.
/// `pressure_scale` [Pa] is a small pressure of the tube.
double volume_step(const PathPoint& at, double pressure_scale);

enum class PathEnd {
    out_of_scope,  // stretches or pressure far beyond any use
    limit_point,   // the pressure has its maximum: beyond it the tube balloons
    instability,   // another mode turns unstable first
    no_solution,   // the law has no value or no equilibrium further on
};

/// Equilibria from rest to the first loss of stability, under pressure alone. It starts the solver near the answer, so
/// that a solve does not depend on what was solved before, and it knows the limit point.
class Path {
public:
    Path(const Wall& wall, Freedom free, double pressure_scale);

    const PathPoint& last() const { return points_.back(); }
    const std::vector<PathPoint>& points() const { return points_; }
    PathEnd end() const { return end_; }
    bool covers(double pressure) const { return pressure >= 0.0 && pressure <= last().pressure; }
    /// Interpolated shape at a covered pressure; about 1e-6 from the equilibrium.
    Shape<double> guess(double pressure) const;

private:
    void add_turning_point(const Wall& wall, Freedom free, const PathPoint& next);
    std::vector<PathPoint> points_;
    PathEnd end_ = PathEnd::out_of_scope;
};

}  // namespace softlimb::actuator
