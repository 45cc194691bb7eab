#include "softlimb/limb/posture.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>

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

namespace {

/// Where a rod is and where it heads, at one point of it.
struct Knot {
    double s;  // rest length from its base [m]
    Vector3 position, slope;
};

/// Derivative of the position along the rod, at a point with internal force n; `m3` is the axial moment.
Vector3 slope_at(const Section& section, const Vector3& tangent, const Vector3& n, double m3) {
    const double n3 = tangent.dot(n);
    double strain, compliance;
    axial_strain(section.axial_law, n3, strain, compliance);
    return n / section.shear + (1.0 + strain + section.extension_twist * m3 - n3 / section.shear) * tangent;
}

/// Points of rod i's centreline at equal steps of rest length, both ends included: a cubic between points of the rod so
/// near each other that it errs by less than 1e-4 of a rod.
void centreline(const Posture& posture, int i, int points, std::vector<Knot>& knots, Vector3* out) {
    const RodShape& rod = posture.solution.shape.rods[i];
    const Section& section = posture.scene.rods[i].section;
    const rod::RodPiece piece{&section, posture.scene.rods[i].rest_length / rod.elements(), posture.scene.line_load(i)};
    knots.clear();
    const auto add = [&](double s, const Pose& pose, const Vector3& n, const Vector3& m) {
        const Vector3 t = pose.rotation.col(2);
        knots.push_back({s, pose.position, slope_at(section, t, n, t.dot(m))});
    };
    for (int e = 0; e < rod.elements(); ++e) {
        const Vector3 n = rod.wrenches[e].head<3>(), m = rod.wrenches[e].tail<3>();
        add(e * piece.length, rod.nodes[e], n, m);
        constexpr double largest_bend = 0.5;  // [rad] between two knots; to the fourth power over 384: 1.6e-4 of them
        constexpr int most = 16;
        const double bend = piece.length * (m.norm() / section.bending + std::sqrt(n.norm() / section.bending));
        const int parts = static_cast<int>(std::clamp(std::ceil(bend / largest_bend), 1.0, static_cast<double>(most)));
        if (parts > 1) {
            std::array<double, most> fractions;
            std::array<rod::EndState, most> states;
            for (int k = 1; k < parts; ++k) fractions[k - 1] = static_cast<double>(k) / parts;
            rod::states_along(piece, rod.nodes[e], rod.wrenches[e], rod.integration, fractions.data(), parts - 1,
                              states.data());
            for (int k = 1; k < parts; ++k)
                add((e + fractions[k - 1]) * piece.length, states[k - 1].pose, states[k - 1].wrench.head<3>(),
                    states[k - 1].wrench.tail<3>());
        }
    }
    // Without a distributed moment the axial moment stays what it was.
    const Vector3 before = rod.wrenches.back().tail<3>();
    const double m3 = rod.nodes[rod.elements() - 1].rotation.col(2).dot(before);
    const Vector3 force = rod.wrenches.back().head<3>() - piece.length * eigen(piece.load.force);
    const Pose& end = rod.nodes.back();
    knots.push_back({rod.elements() * piece.length, end.position, slope_at(section, end.rotation.col(2), force, m3)});

    std::size_t at = 0;
    const double step = knots.back().s / (points - 1);
    for (int k = 0; k < points; ++k) {
        const double s = k * step;
        while (at + 2 < knots.size() && s > knots[at + 1].s) ++at;
        const Knot &a = knots[at], &b = knots[at + 1];
        const double h = b.s - a.s, u = (s - a.s) / h, v = 1.0 - u;
        out[k] = v * v * ((1.0 + 2.0 * u) * a.position + (u * h) * a.slope) +
                 u * u * ((1.0 + 2.0 * v) * b.position - (v * h) * b.slope);
    }
}

/// A ball around a stretch of curve.
struct Ball {
    Vector3 centre;
    double radius;
};

Ball ball_around(const Vector3* points, int count) {
    Ball ball{0.5 * (points[0] + points[count - 1]), 0.0};
    for (int k = 0; k < count; ++k) ball.radius = std::max(ball.radius, (points[k] - ball.centre).squaredNorm());
    ball.radius = std::sqrt(ball.radius);
    return ball;
}

double gap_between(const Ball& a, const Ball& b) { return (a.centre - b.centre).norm() - a.radius - b.radius; }

/// Closest approach of two segments of centreline, s and t from 0 to 1 along them.
struct Approach {
    double distance, s, t;
};

Approach closest(const Vector3& p0, const Vector3& u, const Vector3& q0, const Vector3& v) {
    const Vector3 w = p0 - q0;
    const double a = u.dot(u), b = u.dot(v), c = v.dot(v), d = u.dot(w), e = v.dot(w);
    const double determinant = a * c - b * b;
    double s = determinant > 1e-12 * a * c ? std::clamp((b * e - c * d) / determinant, 0.0, 1.0) : 0.5;
    const double t = std::clamp((b * s + e) / c, 0.0, 1.0);
    s = std::clamp((b * t - d) / a, 0.0, 1.0);
    return {(w + s * u - t * v).norm(), s, t};
}

/// A tube as clearance sees it: a polygon of `pieces` edges, in blocks of eight.
struct TubeCurve {
    static constexpr int block = 8;
    int segment = 0, pieces = 0;
    double radius = 0.0, longest = 0.0;  // of the tube, and of an edge
    const Vector3* point = nullptr;
    Ball ball;
    std::vector<Ball> blocks;

    Vector3 edge(int i) const { return point[i + 1] - point[i]; }
};

/// Does the distance fall where the curve goes on from one end of an edge (where = 0 or 1)? `away` points from the
/// other curve to it. At an end of the curve it does not go on.
bool falls_beyond(const TubeCurve& curve, int edge, double where, const Vector3& away) {
    const double rounding = 1e-6 * curve.longest * away.norm();  // along parallel tubes the distance does not change
    if (where >= 1.0) return edge + 1 < curve.pieces && away.dot(curve.edge(edge + 1)) < -rounding;
    if (where <= 0.0) return edge > 0 && away.dot(curve.edge(edge - 1)) > rounding;
    return false;
}

void compare(const TubeCurve& a, const TubeCurve& b, int number_a, int number_b, Clearance& best) {
    const double radii = a.radius + b.radius;
    if (gap_between(a.ball, b.ball) - radii >= best.gap) return;
    constexpr int block = TubeCurve::block;
    for (std::size_t x = 0; x < a.blocks.size(); ++x)
        for (std::size_t y = 0; y < b.blocks.size(); ++y) {
            if (gap_between(a.blocks[x], b.blocks[y]) - radii >= best.gap) continue;
            const int from_a = static_cast<int>(x) * block, to_a = std::min(from_a + block, a.pieces);
            const int from_b = static_cast<int>(y) * block, to_b = std::min(from_b + block, b.pieces);
            // Squared distances of the points, row by row.
            std::array<std::array<double, block + 1>, 2> rows;
            const auto fill = [&](std::array<double, block + 1>& row, int i) {
                for (int k = from_b; k <= to_b; ++k) row[k - from_b] = (a.point[i] - b.point[k]).squaredNorm();
            };
            fill(rows[from_a % 2], from_a);
            for (int i = from_a; i < to_a; ++i) {
                fill(rows[(i + 1) % 2], i + 1);
                const auto &low = rows[i % 2], &high = rows[(i + 1) % 2];
                for (int k = from_b; k < to_b; ++k) {
                    const int c = k - from_b;
                    // Over two straight edges the squared distance is a convex parabola: its smallest value is at
                    // most this much below the smallest at the corners.
                    const double bow = 0.25 * (a.longest + b.longest) * (a.longest + b.longest);
                    const double reach = std::max(0.0, best.gap + radii);
                    const double corner = std::min(std::min(low[c], low[c + 1]), std::min(high[c], high[c + 1]));
                    if (corner - bow >= reach * reach) continue;
                    const Vector3 u = a.edge(i), v = b.edge(k);
                    const Approach near = closest(a.point[i], u, b.point[k], v);
                    if (near.distance - radii >= best.gap) continue;
                    const Vector3 apart = a.point[i] + near.s * u - b.point[k] - near.t * v;
                    // A neighbour comes closer still: it will speak for itself, or it is an end that does not count.
                    if (falls_beyond(a, i, near.s, apart) || falls_beyond(b, k, near.t, -apart)) continue;
                    const double s = (i + near.s) / a.pieces, t = (k + near.t) / b.pieces;
                    const bool at_end = s <= 0.0 || s >= 1.0 || t <= 0.0 || t >= 1.0;
                    if (at_end && a.segment != b.segment) continue;
                    best = {near.distance - radii, number_a, number_b, s, t};
                }
            }
        }
}

}  // namespace

Clearance clearance(const Posture& posture, const std::vector<double>& radii, int points) {
    const Geometry& geometry = *posture.geometry;
    std::vector<TubeCurve> curves(radii.size());
    std::vector<Vector3> all(radii.size() * points);
    std::vector<Knot> knots;
    int number = 0;
    for (int j = 0; j < geometry.plates(); ++j)
        for (std::size_t k = 0; k < geometry.segments[j].rods.size(); ++k, ++number) {
            TubeCurve& curve = curves[number];
            curve.segment = j, curve.radius = radii[number];
            if (curve.radius <= 0.0) continue;
            Vector3* point = all.data() + static_cast<std::size_t>(number) * points;
            centreline(posture, number, points, knots, point);
            curve.point = point, curve.pieces = points - 1;
            curve.ball = ball_around(point, points);
            for (int i = 0; i < curve.pieces; ++i) curve.longest = std::max(curve.longest, curve.edge(i).norm());
            for (int i = 0; i < curve.pieces; i += TubeCurve::block)
                curve.blocks.push_back(ball_around(point + i, std::min(TubeCurve::block, curve.pieces - i) + 1));
        }
    Clearance best;
    best.gap = std::numeric_limits<double>::infinity();
    for (std::size_t a = 0; a < curves.size(); ++a)
        for (std::size_t b = a + 1; b < curves.size(); ++b)
            if (curves[a].point && curves[b].point)
                compare(curves[a], curves[b], static_cast<int>(a), static_cast<int>(b), best);
    return best;
}

}  // namespace softlimb::limb
