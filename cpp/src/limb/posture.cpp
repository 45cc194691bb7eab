#include "softlimb/limb/posture.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace softlimb::limb {

std::vector<RodPoint> points_along(const Posture& posture, int i, const std::vector<double>& fractions) {
    const RodShape& rod = posture.solution.shape.rods[i];
    const Section& section = posture.scene.rods[i].section;
    const rod::RodPiece piece{&section, posture.scene.rods[i].rest_length / rod.elements(), posture.scene.line_load(i)};
    std::vector<RodPoint> points(fractions.size());
    for (std::size_t k = 0; k < fractions.size(); ++k) {
        const double along = rod.elements() * fractions[k];
        const int e = std::min(static_cast<int>(along), rod.elements() - 1);
        const double fraction = along - e;
        rod::EndState state;
        rod::states_along(piece, rod.nodes[e], rod.wrenches[e], {rod.integration.order, 2 * rod.integration.steps},
                          &fraction, 1, &state);
        RodPoint& point = points[k];
        point.pose = state.pose;
        point.force = state.wrench.head<3>();
        point.moment = state.wrench.tail<3>();
        const Vector3 n = state.pose.rotation.transpose() * point.force;
        const Vector3 m = state.pose.rotation.transpose() * point.moment;
        double strain, compliance;
        axial_strain(section.axial_law, n.z(), strain, compliance);
        point.strain << n.x() / section.shear, n.y() / section.shear, 1.0 + strain + section.extension_twist * m.z();
        point.curvature << m.x() / section.bending, m.y() / section.bending,
            section.rest_twist + section.extension_twist * n.z() + m.z() / section.torsion;
    }
    return points;
}

namespace {

// Force and moment vary smoothly along a rod: five points find the extremes to a few per cent, enough for a warning.
const std::vector<double> few_fractions = {0.0, 0.25, 0.5, 0.75, 1.0};

}  // namespace

bool leaves_axial_law(const Posture& posture, int i) {
    const AxialLaw& law = posture.scene.rods[i].section.axial_law;
    if (law.linear()) return false;
    for (const RodPoint& point : points_along(posture, i, few_fractions))
        if (!law.covers(point.force.dot(point.pose.rotation.col(2)))) return true;
    return false;
}

namespace {

/// Largest norm of the internal force along rod i: the load is constant, so it is at an end of a piece.
double largest_force(const Posture& posture, int i) {
    const RodShape& rod = posture.solution.shape.rods[i];
    const Vector3 change =
        (posture.scene.rods[i].rest_length / rod.elements()) * eigen(posture.scene.line_load(i).force);
    double largest = 0.0;
    for (const Vector6& wrench : rod.wrenches)
        largest = std::max({largest, wrench.head<3>().norm(), (wrench.head<3>() - change).norm()});
    return largest;
}

/// False where no direction of the rod's forces could take it out of the ranges of its laws: most postures, for a
/// fraction of what integrating the rod once more would cost.
bool may_leave_a_range(const Posture& posture, int i) {
    const Section& section = posture.scene.rods[i].section;
    const double force = largest_force(posture, i);
    if (!(section.axial_law.covers(force) && section.axial_law.covers(-force))) return true;
    if (section.largest_stretch <= 0.0) return false;
    double strain, compliance;
    axial_strain(section.axial_law, force, strain, compliance);
    return section.extension_twist != 0.0 || !(section.stretch * (1.0 + strain) <= section.largest_stretch);
}

std::string number(const char* format, double value) {
    char text[32];
    std::snprintf(text, sizeof text, format, value);
    return text;
}

}  // namespace

std::vector<std::string> remarks(const Posture& posture, const Clearance& nearest) {
    std::vector<std::string> notes;
    int out_of_law = 0, out_of_axial_law = 0;
    double stretch = 0.0, limit = 1.0;
    for (std::size_t k = 0; k < posture.scene.rods.size(); ++k) {
        const int i = static_cast<int>(k);
        if (!may_leave_a_range(posture, i)) continue;
        const double largest = largest_stretch(posture, i), range = posture.scene.rods[k].section.largest_stretch;
        if (range > 0.0 && largest > range) {
            ++out_of_law;
            if (largest / range > stretch / limit) stretch = largest, limit = range;
        }
        out_of_axial_law += leaves_axial_law(posture, i);
    }
    if (out_of_law > 0)
        notes.push_back("the law leaves its range in " + std::to_string(out_of_law) +
                        (out_of_law > 1 ? " rods: stretch " : " rod: stretch ") + number("%.4g", stretch) +
                        ", fitted to " + number("%.4g", limit));
    if (out_of_axial_law > 0)
        notes.push_back("the axial force leaves the range of the nonlinear axial law in " +
                        std::to_string(out_of_axial_law) + " rods");
    if (nearest.first >= 0 && nearest.gap <= 0.0)
        notes.push_back("tubes touch: the smallest gap is " + number("%.3g", 1e3 * nearest.gap) +
                        " mm, contact is not modelled");
    return notes;
}

double largest_stretch(const Posture& posture, int i) {
    double largest = 0.0;
    for (const RodPoint& point : points_along(posture, i, few_fractions)) largest = std::max(largest, point.strain.z());
    return posture.scene.rods[i].section.stretch * largest;
}

}  // namespace softlimb::limb
