#pragma once
// Which pressures put the tip where it is wanted.
//
//   a start     given, or by constant curvature: pressures whose segments alone would end there
//   approach    to the target: Gauss-Newton between the bounds, every point a stable posture
//   economise   along the pressures that keep the tip there, to those nearest to the preferred ones
//   the answer  the whole solve at those pressures; its tip decides whether the target was reached
//
// Where a start ends out of reach others follow; what is nearest is an answer too.
// Source: cpp/MECHANICS.md, "Reach".
#include "softlimb/limb/driven.hpp"

namespace softlimb::limb {

struct ReachTarget {
    Pose pose;
    /// Of the tip's errors: translations along base axes in units of the limb's length, then the rotation vector from
    /// the target to the tip, base axes [rad]. Zero leaves a freedom alone.
    Vector6 weights = Vector6::Ones();
};

struct ReachSettings {
    Eigen::VectorXd lower, upper;  // bounds of the pressures [Pa]
    Eigen::VectorXd preferred;     // of all pressures that reach those with the least sum of squares about these [Pa]
    double tolerance = 1e-6;       // of the tip: relative to the limb's length, and in radians
    int starts = 16;               // from nothing, at most
    std::function<bool()> interrupted;
};

/// What a search along a path learns for the next one: curvature of the Lagrangian in units of the widest bounds, and
/// the tip's derivatives where the search started.
struct ReachMemory {
    Eigen::MatrixXd curvature;
    Eigen::VectorXd pressures;
    Eigen::Matrix<double, 6, Eigen::Dynamic> tip_by_pressure;
};

/// Where a search starts: a posture at its pressures, and what an earlier search learned there (may be null).
struct ReachStart {
    const Shape* shape;
    Eigen::VectorXd pressures;
    const ReachMemory* memory = nullptr;
};

struct ReachSolution {
    Eigen::VectorXd pressures;
    Scene scene;  // at these pressures
    Solution posture;
    Vector6 gap = Vector6::Zero();      // of the tip: position minus target [m], rotation vector from the target [rad]
    double miss = 0.0;                  // norm of the gap by the target's weights
    bool reached = false;               // a stable posture within the tolerance of the target
    bool least = false;                 // and no pressures nearby that reach are nearer to the preferred ones
    bool another_from_nothing = false;  // a solve of these pressures without a start ends in another posture
    /// converged: reached. no_progress: no change of the pressures within bounds comes nearer. Else the search ended
    /// before it knew.
    solve::SolveStatus status = solve::SolveStatus::max_iterations;
    int iterations = 0;  // postures that the search looked at
    int starts = 0;      // from nothing
    ReachMemory memory;
};

/// Pressures within bounds that put the tip on the target, or as near to it as found. Raises solve::Interrupted.
ReachSolution reach(const Geometry& geometry, const Scene& scene, const Actuation& actuation, const ReachTarget& target,
                    const ReachSettings& settings, const ReachStart* start);

}  // namespace softlimb::limb
