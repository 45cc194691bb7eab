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
void centreline(const Posture& posture, int i, int points, std::vector<Knot>& knots, double* x, double* y, double* z) {
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
        // A cubic errs by a 384th of the fourth derivative: bend (bend^2 + tension l^2/EI), of the distance of two
        // knots.
        constexpr double allowed = 0.25;  // of a rod's quarter: 1.6e-4 of the rod
        constexpr int most = 16;
        const double largest = std::max(m.norm(), rod.wrenches[std::min(e + 1, rod.elements() - 1)].tail<3>().norm());
        const double bend = piece.length * largest / section.bending;
        const double growth = piece.length * piece.length * n.norm() / section.bending;
        const double error = bend * (bend * bend + growth);
        int parts = 1;
        while (parts < most && error > allowed * parts * parts * parts) ++parts;
        if (parts > 1) {
            std::array<double, most> fractions;
            std::array<rod::EndState, most> states;
            for (int k = 1; k < parts; ++k) fractions[k - 1] = static_cast<double>(k) / parts;
            rod::states_along(piece, rod.nodes[e], rod.wrenches[e], rod.integration, fractions.data(), parts - 1,
                              states.data());
            for (int k = 1; k < parts; ++k) {
                const auto& [pose, wrench] = states[k - 1];
                add((e + fractions[k - 1]) * piece.length, pose, wrench.head<3>(), wrench.tail<3>());
            }
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
        const Vector3 point = v * v * ((1.0 + 2.0 * u) * a.position + (u * h) * a.slope) +
                              u * u * ((1.0 + 2.0 * v) * b.position - (v * h) * b.slope);
        x[k] = point.x(), y[k] = point.y(), z[k] = point.z();
    }
}

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

struct Ball {
    Vector3 centre;
    double radius;
};

/// A tube as clearance sees it: a polygon of `pieces` edges, in whole blocks, with balls around all of it and each.
struct TubeCurve {
    static constexpr int block = 8;
    int segment = 0, pieces = 0;
    double radius = 0.0, longest = 0.0;                     // of the tube; of an edge
    const double *x = nullptr, *y = nullptr, *z = nullptr;  // of the points
    Ball ball;
    std::vector<Ball> blocks;

    Ball ball_around(int from, int to) const {
        Ball around{0.5 * (point(from) + point(to)), 0.0};
        for (int i = from; i <= to; ++i)
            around.radius = std::max(around.radius, (point(i) - around.centre).squaredNorm());
        around.radius = std::sqrt(around.radius);
        return around;
    }
    Vector3 point(int i) const { return {x[i], y[i], z[i]}; }
    Vector3 edge(int i) const { return point(i + 1) - point(i); }
};

/// Does the distance fall where the curve goes on from one end of an edge (where = 0 or 1)? `away` points from the
/// other curve to it. At an end of the curve it does not go on.
bool falls_beyond(const TubeCurve& curve, int edge, double where, const Vector3& away) {
    const double rounding = 1e-6 * curve.longest * away.norm();  // along parallel tubes the distance does not change
    if (where >= 1.0) return edge + 1 < curve.pieces && away.dot(curve.edge(edge + 1)) < -rounding;
    if (where <= 0.0) return edge > 0 && away.dot(curve.edge(edge - 1)) > rounding;
    return false;
}

/// Approach of one edge of each of two tubes, if it is one of the whole tubes and closer than the best.
void compare_edges(const std::vector<TubeCurve>& curves, int a, int b, int i, int k, Clearance& best) {
    const TubeCurve &first = curves[a], &second = curves[b];
    const Vector3 p = first.point(i), q = second.point(k), u = first.edge(i), v = second.edge(k);
    const Approach near = closest(p, u, q, v);
    const double gap = near.distance - first.radius - second.radius;
    if (gap >= best.gap) return;
    const Vector3 apart = p + near.s * u - q - near.t * v;
    // A neighbouring edge comes closer still: it will speak for itself, or it leads to an end that does not count.
    if (falls_beyond(first, i, near.s, apart) || falls_beyond(second, k, near.t, -apart)) return;
    const double s = (i + near.s) / first.pieces, t = (k + near.t) / second.pieces;
    const bool at_end = s <= 0.0 || s >= 1.0 || t <= 0.0 || t >= 1.0;
    if (at_end && first.segment != second.segment) return;
    best = {gap, a, b, s, t};
}

void compare(const std::vector<TubeCurve>& curves, int a, int b, Clearance& best) {
    const TubeCurve &first = curves[a], &second = curves[b];
    const double radii = first.radius + second.radius;
    // Distances from which on nothing can come closer than the best; negative where nothing at all can.
    const auto beyond = [&](double balls) { return best.gap + radii + balls; };
    const auto farther = [](const Vector3& p, const Vector3& q, double limit) {
        return limit < 0.0 || (p - q).squaredNorm() >= limit * limit;
    };
    constexpr int block = TubeCurve::block;
    for (int from = 0; from < second.pieces; from += block) {
        const Ball& ball = second.blocks[from / block];
        if (farther(first.ball.centre, ball.centre, beyond(first.ball.radius + ball.radius))) continue;
        using Row = Eigen::Array<double, block + 1, 1>;
        const Eigen::Map<const Row> x(second.x + from), y(second.y + from), z(second.z + from);
        Row low, high, nearest;
        int filled = -1;  // row that `high` holds
        const auto fill = [&](int i) {
            high = (x - first.x[i]).square() + (y - first.y[i]).square() + (z - first.z[i]).square();
            filled = i;
        };
        for (int i = 0; i < first.pieces; ++i) {
            if (farther(first.point(i), ball.centre, beyond(ball.radius + first.longest))) continue;
            if (filled != i) fill(i);
            low = high;
            fill(i + 1);
            // The squared distance over two straight edges is a convex parabola: it is nowhere further below the
            // smallest of its corners than this.
            const double bow = 0.25 * (first.longest * first.longest + second.longest * second.longest);
            const double limit = std::max(0.0, best.gap + radii), threshold = limit * limit + bow;
            nearest = low.min(high);
            if (!(nearest.minCoeff() < threshold)) continue;
            for (int k = 0; k < block; ++k)
                if (nearest[k] < threshold || nearest[k + 1] < threshold)
                    compare_edges(curves, a, b, i, from + k, best);
        }
    }
}

}  // namespace

Clearance clearance(const Posture& posture, const std::vector<double>& radii, int points) {
    const Geometry& geometry = *posture.geometry;
    const int rods = static_cast<int>(radii.size());
    points = (points - 2 + TubeCurve::block) / TubeCurve::block * TubeCurve::block + 1;  // whole blocks of edges
    std::vector<TubeCurve> curves(radii.size());
    std::vector<double> room(static_cast<std::size_t>(3 * points) * radii.size());
    std::vector<Knot> knots;
    int number = 0;
    for (int j = 0; j < geometry.plates(); ++j)
        for (std::size_t k = 0; k < geometry.segments[j].rods.size(); ++k, ++number) {
            TubeCurve& curve = curves[number];
            curve.segment = j, curve.radius = radii[number];
            if (curve.radius <= 0.0) continue;
            double* x = room.data() + static_cast<std::size_t>(3 * points) * number;
            double *y = x + points, *z = y + points;
            centreline(posture, number, points, knots, x, y, z);
            curve.x = x, curve.y = y, curve.z = z, curve.pieces = points - 1;
            curve.ball = curve.ball_around(0, curve.pieces);
            for (int i = 0; i < curve.pieces; i += TubeCurve::block)
                curve.blocks.push_back(curve.ball_around(i, i + TubeCurve::block));
            for (int i = 0; i < curve.pieces; ++i) curve.longest = std::max(curve.longest, curve.edge(i).squaredNorm());
            curve.longest = std::sqrt(curve.longest);
        }
    Clearance best;
    best.gap = std::numeric_limits<double>::infinity();
    // First the two that look closest: the less is left for the others.
    int first = -1, second = -1;
    double least = best.gap;
    for (int a = 0; a < rods; ++a)
        for (int b = a + 1; b < rods && curves[b].segment == curves[a].segment; ++b)
            for (const int i : {points / 4, points / 2, 3 * points / 4}) {
                if (!curves[a].x || !curves[b].x) continue;
                const double gap =
                    (curves[a].point(i) - curves[b].point(i)).norm() - curves[a].radius - curves[b].radius;
                if (gap < least) least = gap, first = a, second = b;
            }
    if (first >= 0) compare(curves, first, second, best);
    for (int a = 0; a < rods; ++a)
        for (int b = a + 1; b < rods; ++b)
            if (curves[a].x && curves[b].x && (a != first || b != second)) compare(curves, a, b, best);
    return best;
}

}  // namespace softlimb::limb
