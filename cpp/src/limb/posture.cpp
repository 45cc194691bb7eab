#include "softlimb/limb/posture.hpp"

#include <algorithm>
#include <cmath>

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

double largest_stretch(const Posture& posture, int i) {
    double largest = 0.0;
    for (const RodPoint& point : points_along(posture, i, few_fractions)) largest = std::max(largest, point.strain.z());
    return posture.scene.rods[i].section.stretch * largest;
}

namespace {

/// Closest approach of two segments of centreline.
struct Approach {
    double distance, s, t;
    bool inside;  // neither parameter at its end
};

Approach closest(const Vector3& p0, const Vector3& p1, const Vector3& q0, const Vector3& q1) {
    const Vector3 u = p1 - p0, v = q1 - q0, w = p0 - q0;
    const double a = u.dot(u), b = u.dot(v), c = v.dot(v), d = u.dot(w), e = v.dot(w);
    const double determinant = a * c - b * b;
    double s = determinant > 1e-12 * a * c ? std::clamp((b * e - c * d) / determinant, 0.0, 1.0) : 0.5;
    double t = std::clamp((b * s + e) / c, 0.0, 1.0);
    s = std::clamp((b * t - d) / a, 0.0, 1.0);
    return {(p0 + s * u - q0 - t * v).norm(), s, t, s > 0.0 && s < 1.0 && t > 0.0 && t < 1.0};
}

}  // namespace

Clearance clearance(const Posture& posture, const std::vector<double>& radii, int points) {
    const Geometry& geometry = *posture.geometry;
    std::vector<double> fractions(points);
    for (int k = 0; k < points; ++k) fractions[k] = static_cast<double>(k) / (points - 1);
    std::vector<std::vector<RodPoint>> curves;
    std::vector<int> segment_of;
    std::vector<double> longest;  // piece of each curve
    for (int j = 0; j < geometry.plates(); ++j)
        for (std::size_t k = 0; k < geometry.segments[j].rods.size(); ++k) {
            curves.push_back(points_along(posture, static_cast<int>(curves.size()), fractions));
            segment_of.push_back(j);
            longest.push_back(0.0);
            for (int i = 0; i + 1 < points; ++i)
                longest.back() = std::max(longest.back(),
                                          (curves.back()[i + 1].pose.position - curves.back()[i].pose.position).norm());
        }
    Clearance best;
    best.gap = std::numeric_limits<double>::infinity();
    for (std::size_t a = 0; a < curves.size(); ++a)
        for (std::size_t b = a + 1; b < curves.size(); ++b) {
            if (radii[a] <= 0.0 || radii[b] <= 0.0) continue;
            const bool same = segment_of[a] == segment_of[b];
            // Pieces whose first points are farther apart than this cannot come closer than the best so far; with 300
            // rods the full comparison of all of them takes a second.
            const double reach = longest[a] + longest[b] + radii[a] + radii[b];
            for (int i = 0; i + 1 < points; ++i)
                for (int k = 0; k + 1 < points; ++k) {
                    const Vector3 apart = curves[a][i].pose.position - curves[b][k].pose.position;
                    const double far = best.gap + reach;
                    if (far >= 0.0 && apart.squaredNorm() > far * far) continue;
                    const Approach near = closest(curves[a][i].pose.position, curves[a][i + 1].pose.position,
                                                  curves[b][k].pose.position, curves[b][k + 1].pose.position);
                    const double gap = near.distance - radii[a] - radii[b];
                    const double s = (i + near.s) / (points - 1), t = (k + near.t) / (points - 1);
                    const bool at_end = s <= 0.0 || s >= 1.0 || t <= 0.0 || t >= 1.0;
                    if (gap >= best.gap || (!same && at_end)) continue;
                    best = {gap, static_cast<int>(a), static_cast<int>(b), s, t};
                }
        }
    return best;
}

}  // namespace softlimb::limb
