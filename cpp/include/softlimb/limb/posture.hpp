#pragma once
// A solved posture with all that it needs to answer questions later: curves along the rods, clearance, verification.
#include <memory>
#include <string>
#include <vector>

#include "softlimb/limb/solver.hpp"

namespace softlimb::limb {

struct Posture {
    std::shared_ptr<const Geometry> geometry;
    Scene scene;
    Solution solution;
    std::vector<double> pressures{};  // of the actuators, where the rods came from pressures [Pa]

    Solved solved() const { return {*geometry, scene, solution}; }
};

/// State of a rod at a point, base axes; strains v and curvatures u in section axes.
struct RodPoint {
    Pose pose;
    Vector3 force, moment, strain, curvature;
};

/// Rod i at fractions 0..1 of its rest length.
std::vector<RodPoint> points_along(const Posture& posture, int i, const std::vector<double>& fractions);

/// Largest stretch lz v3 along rod i against its length at zero pressure: what a material law's range is judged by.
double largest_stretch(const Posture& posture, int i);

/// True when the axial force of rod i leaves the range of its nonlinear axial law somewhere.
bool leaves_axial_law(const Posture& posture, int i);

/// Smallest gap between two tubes [m] and where: rods and their fractions. Negative: they overlap. Tubes of one segment
/// are compared everywhere; tubes of different segments only where both come closest away from their ends, because
/// there the plates keep them apart. Radii of zero or less leave a rod out.
struct Clearance {
    double gap = 0.0;
    int first = -1, second = -1;  // flat rod numbers; -1 when there are no two tubes to compare
    double first_fraction = 0.0, second_fraction = 0.0;
};
/// `points` a rod: with 25 a gap is good to a thousandth of a rod's length.
Clearance clearance(const Posture& posture, const std::vector<double>& radii, int points);

/// What to know before a posture that converged is trusted, in words: a law or an axial curve that left its range,
/// tubes that touch. `nearest` is its clearance.
std::vector<std::string> remarks(const Posture& posture, const Clearance& nearest);

/// Independent check of a posture: every piece re-integrated by another formulation (quaternions, strains in section
/// axes, classical RK4 with step halving until it no longer changes), every node and every plate re-balanced from the
/// re-integrated ends. Errors are relative: positions to the limb's length, rotations in radians, forces and moments to
/// the largest internal force and moment (or EI/l^2, EI/l where those are larger).
struct Verification {
    double position_error = 0.0, rotation_error = 0.0, force_error = 0.0, moment_error = 0.0;
    double hold_error = 0.0;
};
Verification verify(const Posture& posture);

}  // namespace softlimb::limb
