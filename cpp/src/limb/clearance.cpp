// Two tubes of one segment mostly run beside each other: every point of one has a single nearest place on the other,
// and a model of second order finds it from few points. Where curvature or a crossing leaves room for more, edges of
// polygons are compared. Nine tubes of a limb at up to 20 kPa take a fifth of the time of polygons alone, at up to 60
// kPa a quarter. Source: cpp/MECHANICS.md, "Clearance".
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "softlimb/limb/posture.hpp"
#include "softlimb/solve/room.hpp"

namespace softlimb::limb {
namespace {

/// A point of a centreline with two derivatives along it.
struct CurvePoint {
    Vector3 position, slope, bend;
};

/// A node of a rod with three derivatives along it.
struct Knot {
    Vec3<double> position, slope, bend, jerk;
};

/// A piece of a rod as a polynomial of degree seven that shares position and three derivatives with it at both ends; by
/// powers of u from 0 to 1. The fourth row is padding: two registers of two numbers.
struct Piece {
    double from, per_length;  // fraction of the rod where it begins; u by fraction
    Eigen::Matrix<double, 4, 8> power;

    Vector3 position(double fraction) const {
        const double u = per_length * (fraction - from);
        Eigen::Vector4d value = power.col(7);
        for (int i = 7; i-- > 0;) value = value * u + power.col(i);
        return value.head<3>();
    }
};

struct Ball {
    Vector3 centre;
    double radius;
};

/// A tube as clearance sees it: few points at equal steps of rest length, and edges where they are wanted.
struct Tube {
    Tube() {}  // leaves the rows as they are: they are filled at once

    static constexpr int points = 12, steps = points - 1, block = 8;
    using Row = Eigen::Array<double, points, 1>;

    int rod = 0, segment = 0, first_piece = 0, pieces = 0;
    double radius = 0.0, curvature = 0.0, longest = 0.0;  // of the centreline; of a step
    Row x, y, z, tx, ty, tz, bx, by, bz, speed;           // points, with two derivatives by the number of the step
    Ball ball;
    const Vector3* polygon = nullptr;  // its points, and balls around each `block` of its edges
    const Ball* blocks = nullptr;
};

struct Pair {
    int first, second;
};

/// A place on each of two tubes, as fractions.
struct Places {
    double first, second;
};

/// Where two tubes beside each other may be nearest, and about how near.
struct Candidate {
    const Tube *first, *second;
    Places at;
    double gap, bow;  // bow of the squared distance by the step
    bool second_end;  // at an end of the second
};

/// What a search works in, handed from one to the next on a thread.
struct ClearanceRoom {
    std::vector<Tube> tubes_;
    std::vector<Piece> pieces_;
    std::vector<Candidate> candidates_;
    std::vector<Pair> open_;  // of which more than one place may be the nearest
    std::vector<Vector3> polygons_;
    std::vector<Ball> blocks_;
};

/// A node of a rod with the derivatives by rest length, from pose and internal wrench; cpp/MECHANICS.md, "Rod". The
/// curve of the axial law is left out of the third.
Knot knot_of_rod(const rod::RodPiece& piece, const Pose& pose, const Vector3& force, const Vector3& moment) {
    const Section& section = *piece.section;
    const Vec3<double> t = vec3(pose.rotation.col(2)), n = vec3(force), m = vec3(moment);
    const auto& [f, l] = piece.load;
    const double a = 1.0 / section.shear, c = 1.0 / section.bending, n3 = dot(t, n);
    double strain, compliance;
    axial_strain(section.axial_law, n3, strain, compliance);
    const double k = 1.0 + strain + section.extension_twist * dot(t, m) - a * n3;
    const Vec3<double> t1 = c * cross(m, t), t2 = c * (cross(m, t1) - cross(k * cross(t, n) + l, t));
    const double k1 = (compliance - a) * (dot(t1, n) - dot(t, f)) - section.extension_twist * dot(t, l);
    const double k2 = (compliance - a) * (dot(t2, n) - 2.0 * dot(t1, f)) - section.extension_twist * dot(t1, l);
    return {vec3(pose.position), a * n + k * t, k1 * t + k * t1 - a * f, k2 * t + (2.0 * k1) * t1 + k * t2};
}

Piece piece_between(const Knot& a, const Knot& b, double from, double length, double rest_length) {
    Piece piece;
    piece.from = from, piece.per_length = 1.0 / length;
    const double h = length * rest_length, h2 = h * h / 2.0, h3 = h * h2 / 3.0;
    // Taylor coefficients at the end, beyond what those at the beginning give there; divided by u^4; by powers of u.
    const auto fill = [&](int axis, double Vec3<double>::* x) {
        const double p0 = a.position.*x, v0 = h * a.slope.*x, w0 = h2 * a.bend.*x, j0 = h3 * a.jerk.*x;
        const double p = b.position.*x - p0 - v0 - w0 - j0, v = h * b.slope.*x - v0 - 2.0 * w0 - 3.0 * j0;
        const double w = h2 * b.bend.*x - w0 - 3.0 * j0, j = h3 * b.jerk.*x - j0;
        const double q1 = v - 4.0 * p, q2 = w - 4.0 * v + 10.0 * p, q3 = j - 4.0 * w + 10.0 * v - 20.0 * p;
        piece.power.row(axis) << p0, v0, w0, j0, p - q1 + q2 - q3, q1 - 2.0 * q2 + 3.0 * q3, q2 - 3.0 * q3, q3;
    };
    fill(0, &Vec3<double>::x), fill(1, &Vec3<double>::y), fill(2, &Vec3<double>::z);
    piece.power.row(3).setZero();
    return piece;
}

/// Internal moment at the end of a rod from the balance of its last piece, the weight where a cubic between the nodes
/// has it.
Vector3 end_moment(const rod::RodPiece& piece, const RodShape& rod) {
    const Vector6& wrench = rod.wrenches.back();
    const Pose &a = rod.nodes[rod.elements() - 1], &b = rod.nodes.back();
    const double h = piece.length;
    const Vector3 f = eigen(piece.load.force), n = wrench.head<3>(), arm = b.position - a.position;
    const Vector3 mean_arm = 0.5 * arm + (h / 12.0) * (a.rotation.col(2) - b.rotation.col(2));
    return wrench.tail<3>() - arm.cross(n) + (h * (arm - mean_arm)).cross(f) - h * eigen(piece.load.moment);
}

/// The centreline of rod i, appended.
void add_pieces(const Posture& posture, int i, std::vector<Piece>& pieces) {
    const RodShape& rod = posture.solution.shape.rods[i];
    const double rest_length = posture.scene.rods[i].rest_length, share = 1.0 / rod.elements();
    const rod::RodPiece piece{&posture.scene.rods[i].section, rest_length * share, posture.scene.line_load(i)};
    Knot from = knot_of_rod(piece, rod.nodes[0], rod.wrenches[0].head<3>(), rod.wrenches[0].tail<3>());
    for (int e = 0; e < rod.elements(); ++e) {
        const bool last = e + 1 == rod.elements();
        const Vector3 force = rod.wrenches[e].head<3>() - piece.length * eigen(piece.load.force);
        const Knot to =
            knot_of_rod(piece, rod.nodes[e + 1], force, last ? end_moment(piece, rod) : rod.wrenches[e + 1].tail<3>());
        pieces.push_back(piece_between(from, to, e * share, share, rest_length));
        from = to;
    }
}

/// Derivatives by the number of the step.
void differentiate(const Tube::Row& x, Tube::Row& t, Tube::Row& b) {
    constexpr int last = Tube::steps;
    t.segment<last - 1>(1) = 0.5 * (x.tail<last - 1>() - x.head<last - 1>());
    b.segment<last - 1>(1) = x.tail<last - 1>() - 2.0 * x.segment<last - 1>(1) + x.head<last - 1>();
    b[0] = b[1], b[last] = b[last - 1];
    t[0] = x[1] - x[0] - 0.5 * b[0], t[last] = x[last] - x[last - 1] + 0.5 * b[last];
}

/// The tube's points, and what is known from them.
void sample(const std::vector<Piece>& pieces, Tube& tube) {
    const Piece* piece = pieces.data() + tube.first_piece;
    for (int i = 0, p = 0; i < Tube::points; ++i) {
        const double fraction = static_cast<double>(i) / Tube::steps;
        while (p + 1 < tube.pieces && fraction >= piece[1].from) ++piece, ++p;
        const Vector3 at = piece->position(fraction);
        tube.x[i] = at.x(), tube.y[i] = at.y(), tube.z[i] = at.z();
    }
    differentiate(tube.x, tube.tx, tube.bx);
    differentiate(tube.y, tube.ty, tube.by);
    differentiate(tube.z, tube.tz, tube.bz);
    const Tube::Row square = tube.tx.square() + tube.ty.square() + tube.tz.square();
    tube.curvature = std::sqrt(((tube.bx.square() + tube.by.square() + tube.bz.square()) / square.square()).maxCoeff());
    tube.speed = square.sqrt();
    tube.longest = tube.speed.maxCoeff();
    const double cx = 0.5 * (tube.x[0] + tube.x[Tube::steps]), cy = 0.5 * (tube.y[0] + tube.y[Tube::steps]);
    const double cz = 0.5 * (tube.z[0] + tube.z[Tube::steps]);
    const double farthest = ((tube.x - cx).square() + (tube.y - cy).square() + (tube.z - cz).square()).maxCoeff();
    tube.ball = {{cx, cy, cz}, std::sqrt(farthest)};
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

/// Does the distance fall where the curve goes on from one end of an edge (where = 0 or 1)? `away` points from the
/// other curve to it. At an end of the curve it does not go on.
bool falls_beyond(const Vector3* polygon, int edges, int edge, double where, const Vector3& away) {
    const auto along = [&](int i) { return away.dot(polygon[i + 1] - polygon[i]); };
    // Along parallel tubes the distance does not change.
    const double rounding = 1e-6 * (polygon[edge + 1] - polygon[edge]).norm() * away.norm();
    if (where >= 1.0) return edge + 1 < edges && along(edge + 1) < -rounding;
    if (where <= 0.0) return edge > 0 && along(edge - 1) > rounding;
    return false;
}

class ClearanceSearch : private solve::Room<ClearanceRoom> {
public:
    ClearanceSearch(const Posture& posture, const std::vector<double>& radii, int points)
        : edges_((points - 2 + Tube::block) / Tube::block * Tube::block) {
        tubes_.clear(), pieces_.clear(), candidates_.clear(), open_.clear();
        tubes_.reserve(radii.size());  // candidates point at them
        const Geometry& geometry = *posture.geometry;
        int number = 0;
        for (int j = 0; j < geometry.plates(); ++j)
            for (std::size_t k = 0; k < geometry.segments[j].rods.size(); ++k, ++number) {
                if (radii[number] <= 0.0) continue;
                Tube& tube = tubes_.emplace_back();
                tube.rod = number, tube.segment = j, tube.radius = radii[number];
                tube.first_piece = static_cast<int>(pieces_.size());
                add_pieces(posture, number, pieces_);
                tube.pieces = static_cast<int>(pieces_.size()) - tube.first_piece;
                sample(pieces_, tube);
            }
    }

    Clearance run() {
        best_.gap = std::numeric_limits<double>::infinity();
        const int tubes = static_cast<int>(tubes_.size());
        for (int a = 0; a < tubes; ++a)
            for (int b = a + 1; b < tubes && tubes_[b].segment == tubes_[a].segment; ++b)
                if (!look_beside(tubes_[a], tubes_[b])) open_.push_back({a, b});
        settle_candidates();
        for (int a = 0; a < tubes; ++a)
            for (int b = a + 1; b < tubes; ++b) {
                const Tube &first = tubes_[a], &second = tubes_[b];
                if (first.segment == second.segment || beyond_reach(first, second)) continue;
                if (!leads_past(first, second.ball, 1.0) && !leads_past(second, first.ball, -1.0))
                    open_.push_back({a, b});
            }
        if (open_.empty()) return best_;
        polygons_.resize((edges_ + 1) * tubes_.size()), blocks_.resize(edges_ / Tube::block * tubes_.size());
        for (const Pair& pair : open_) {
            cut_into_edges(tubes_[pair.first]), cut_into_edges(tubes_[pair.second]);
            compare_edges(tubes_[pair.first], tubes_[pair.second]);
        }
        return best_;
    }

private:
    /// No point of one tube is as near to one of the other as the best so far.
    bool beyond_reach(const Tube& first, const Tube& second) const {
        const double limit = best_.gap + first.radius + second.radius + first.ball.radius + second.ball.radius;
        return limit < 0.0 || (first.ball.centre - second.ball.centre).squaredNorm() >= limit * limit;
    }

    /// All along the tube one comes nearer to all that is in the ball (sense = 1), or farther from it (-1): nothing
    /// there is closest to a point of the tube between its ends.
    static bool leads_past(const Tube& tube, const Ball& ball, double sense) {
        const Vector3& c = ball.centre;
        const Tube::Row along = (c.x() - tube.x) * tube.tx + (c.y() - tube.y) * tube.ty + (c.z() - tube.z) * tube.tz;
        return (sense * along - ball.radius * tube.speed).minCoeff() > 0.0;
    }

    /// From each point of the first tube to its foot on the second: where that is, and the squared distance, by a model
    /// of second order that goes on beyond the second's ends.
    struct Feet {
        Tube::Row place, squared;
    };

    /// Looks for candidates of tubes that run beside each other: the foot of each point of the first is sought near the
    /// point of the same number of the second. False where it may not be the only one.
    bool look_beside(const Tube& first, const Tube& second) {
        constexpr int last = Tube::steps;
        static const Tube::Row number = Tube::Row::LinSpaced(Tube::points, 0.0, last);
        const Tube::Row x = first.x - second.x, y = first.y - second.y, z = first.z - second.z;
        const Tube::Row apart = x.square() + y.square() + z.square();
        // Half the squared distance by the place on the second tube: -along at once, and its derivative.
        const Tube::Row along = x * second.tx + y * second.ty + z * second.tz;
        const Tube::Row steep = second.speed.square() - (x * second.bx + y * second.by + z * second.bz);
        const Tube::Row shift = along / steep;
        // A point at distance d from its foot q0 on a curve of curvature at most k has no other where k d < 1 and the
        // curve turns by less than pi: (q - p).q' is (q - q0).q', at least sin(k s)/k at arclength s from the foot,
        // plus (q0 - p).q', at least -d sin(k s). The model needs room to its pole at k d = 1.
        constexpr double most_curved = 0.8, most_turned = 3.0;
        const double curvature = second.curvature;
        if (!(curvature * std::sqrt(apart.maxCoeff()) < most_curved && curvature * last * second.longest < most_turned))
            return false;
        Feet feet{number + shift, apart - along * shift};
        // What the model leaves out of the squared distance is about k^2 d shift^3/3: this share of it.
        constexpr double largest_error = 0.003;
        const double shifted = second.longest * shift.abs().maxCoeff();
        if (!(curvature * curvature * shifted * shifted * shifted < 3.0 * largest_error * std::sqrt(apart.minCoeff())))
            find_feet(first, second, feet);
        const auto add = [&](double s, double t, double squared, double bow, bool second_end) {
            const auto fraction = [](double step) { return std::clamp(step / last, 0.0, 1.0); };
            const double gap = std::sqrt(std::max(squared, 0.0)) - first.radius - second.radius;
            candidates_.push_back({&first, &second, {fraction(s), fraction(t)}, gap, bow, second_end});
        };
        const Tube::Row& squared = feet.squared;
        for (int i = 0; i <= last; ++i) {
            if ((i > 0 && squared[i - 1] <= squared[i]) || (i < last && squared[i + 1] < squared[i])) continue;
            // The lowest point of the parabola through this one and its neighbours.
            const int middle = std::clamp(i, 1, last - 1);
            const double before = squared[middle - 1], here = squared[middle], after = squared[middle + 1];
            const double slope = 0.5 * (after - before), bow = before - 2.0 * here + after;
            const double step = bow > 0.0 ? std::clamp(-slope / bow, -1.0, 1.0) : i - middle;
            add(middle + step, middle + step + feet.place[i] - i, here + step * (slope + 0.5 * step * bow), bow, false);
        }
        // Where an end of the first has its foot beyond the second's, the second's end counts by itself. The share of a
        // step that is let pass moves a distance by less than 1e-5 of a rod.
        constexpr double beyond = 0.02;
        if (feet.place[0] < -beyond) add(-feet.place[0], 0.0, squared[0], 0.0, true);
        if (feet.place[last] > last + beyond) add(2.0 * last - feet.place[last], last, squared[last], 0.0, true);
        return true;
    }

    /// The same with the second tube as it is where the model led, once and again.
    void find_feet(const Tube& first, const Tube& second, Feet& feet) const {
        constexpr int last = Tube::steps;
        for (int i = 0; i <= last; ++i) {
            const Vector3 p(first.x[i], first.y[i], first.z[i]);
            for (int round = 0; round < 3; ++round) {
                const double place = std::clamp(feet.place[i] / last, 0.0, 1.0);
                const CurvePoint q = point_on(second, place);
                const Vector3 away = p - q.position;
                const double along = away.dot(q.slope), square = q.slope.squaredNorm();
                const double shift = along / std::max(square - away.dot(q.bend), least_steep * square);
                feet.place[i] = last * (place + shift);
                feet.squared[i] = away.squaredNorm() - along * shift;
            }
        }
    }

    /// Measures where the candidates are nearest, the most likely one first.
    void settle_candidates() {
        if (candidates_.empty()) return;
        const auto nearer = [](const Candidate& a, const Candidate& b) { return a.gap < b.gap; };
        std::iter_swap(candidates_.begin(), std::min_element(candidates_.begin(), candidates_.end(), nearer));
        for (const Candidate& candidate : candidates_) {
            // Along parallel tubes rounding makes many points the lowest; one is enough.
            const double rounding = 1e-9 * candidate.first->longest;
            if (candidate.gap < best_.gap - rounding) settle(candidate);
        }
    }

    void settle(const Candidate& candidate) {
        const Tube &first = *candidate.first, &second = *candidate.second;
        Places at = candidate.at;
        if (candidate.second_end) {
            at.first = nearest_place(first, position_on(second, at.second), at.first);
            return take_if_best(first, second, at);
        }
        const CurvePoint p = point_on(first, at.first);
        at.second = nearest_place(second, p.position, at.second);
        take_if_best(first, second, at);
        // The squared distance from there on: its slope by the step of the first tube is known now, and its bow nearly.
        const double slope = 2.0 * (p.position - position_on(second, at.second)).dot(p.slope) / Tube::steps;
        if (!(candidate.bow > 0.0)) return;
        const double step = std::clamp(-slope / candidate.bow, -1.0, 1.0) / Tube::steps;
        take_if_best(first, second, {std::clamp(at.first + step, 0.0, 1.0), std::clamp(at.second + step, 0.0, 1.0)});
    }

    const Piece& piece_at(const Tube& tube, double fraction) const {
        int p = tube.first_piece + tube.pieces - 1;
        while (p > tube.first_piece && fraction < pieces_[p].from) --p;
        return pieces_[p];
    }

    Vector3 position_on(const Tube& tube, double fraction) const { return piece_at(tube, fraction).position(fraction); }

    /// A point of the tube with two derivatives by the fraction.
    CurvePoint point_on(const Tube& tube, double fraction) const {
        const Piece& piece = piece_at(tube, fraction);
        const double u = piece.per_length * (fraction - piece.from);
        Eigen::Vector4d value = piece.power.col(7), slope = Eigen::Vector4d::Zero(), half_bend = slope;
        for (int i = 7; i-- > 0;) {
            half_bend = half_bend * u + slope;
            slope = slope * u + value;
            value = value * u + piece.power.col(i);
        }
        const double by = piece.per_length;
        return {value.head<3>(), by * slope.head<3>(), (2.0 * by * by) * half_bend.head<3>()};
    }

    /// Place on the tube nearest to a point, by Newton from a place that is close.
    double nearest_place(const Tube& tube, const Vector3& to, double place) const {
        for (int round = 0; round < 2; ++round) {
            const CurvePoint at = point_on(tube, place);
            const Vector3 away = at.position - to;
            const double square = at.slope.squaredNorm();
            const double steep = std::max(square + away.dot(at.bend), least_steep * square);
            place = std::clamp(place - away.dot(at.slope) / steep, 0.0, 1.0);
        }
        return place;
    }

    void take_if_best(const Tube& first, const Tube& second, const Places& at) {
        const double gap =
            (position_on(first, at.first) - position_on(second, at.second)).norm() - first.radius - second.radius;
        if (gap < best_.gap) best_ = {gap, first.rod, second.rod, at.first, at.second};
    }

    /// Whether the nearest place of two tubes may be at these: between the ends if they are of different segments.
    static bool counts(const Tube& first, const Tube& second, const Places& at) {
        const bool at_end = at.first <= 0.0 || at.first >= 1.0 || at.second <= 0.0 || at.second >= 1.0;
        return !at_end || first.segment == second.segment;
    }

    /// The tube's polygon with balls around its blocks, once.
    void cut_into_edges(Tube& tube) {
        if (tube.polygon != nullptr) return;
        const std::size_t number = &tube - tubes_.data();
        Vector3* const polygon = polygons_.data() + (edges_ + 1) * number;
        for (int i = 0; i <= edges_; ++i) {
            const double fraction = static_cast<double>(i) / edges_;
            polygon[i] = position_on(tube, fraction);
        }
        Ball* const blocks = blocks_.data() + edges_ / Tube::block * number;
        for (int k = 0; k * Tube::block < edges_; ++k) {
            const Vector3* const at = polygon + k * Tube::block;
            blocks[k] = {0.5 * (at[0] + at[Tube::block]), 0.0};
            for (int i = 0; i <= Tube::block; ++i)
                blocks[k].radius = std::max(blocks[k].radius, (at[i] - blocks[k].centre).squaredNorm());
            blocks[k].radius = std::sqrt(blocks[k].radius);
        }
        tube.polygon = polygon, tube.blocks = blocks;
    }

    /// Compares all edges of two tubes that may come closer than the best.
    void compare_edges(const Tube& first, const Tube& second) {
        const double radii = first.radius + second.radius;
        std::optional<Places> found;
        double least = best_.gap;
        // Are these so far apart that nothing within `around` of them comes closer than the least?
        const auto farther = [&](const Vector3& p, const Vector3& q, double around) {
            const double limit = least + radii + around;
            return limit < 0.0 || (p - q).squaredNorm() >= limit * limit;
        };
        constexpr int block = Tube::block;
        for (int i = 0; i < edges_; i += block)
            for (int k = 0; k < edges_; k += block) {
                const Ball &here = first.blocks[i / block], &there = second.blocks[k / block];
                if (farther(here.centre, there.centre, here.radius + there.radius)) continue;
                for (int p = i; p < i + block; ++p) {
                    const Vector3 middle = 0.5 * (first.polygon[p] + first.polygon[p + 1]);
                    const double half = 0.5 * (first.polygon[p + 1] - first.polygon[p]).norm();
                    if (farther(middle, there.centre, half + there.radius)) continue;
                    for (int q = k; q < k + block; ++q) compare_two_edges(first, second, p, q, least, found);
                }
            }
        if (!found) return;
        // Polygons cut corners: the curves themselves have the last word, between the ends where these do not count.
        Places at = *found;
        for (int round = 0; round < 3; ++round) {
            at.second = nearest_place(second, position_on(first, at.first), at.second);
            at.first = nearest_place(first, position_on(second, at.second), at.first);
        }
        take_if_best(first, second, counts(first, second, at) ? at : *found);
    }

    /// Approach of one edge of each of two tubes, if it is one of the whole tubes and closer than the least.
    void compare_two_edges(const Tube& first, const Tube& second, int i, int k, double& least,
                           std::optional<Places>& found) const {
        const Vector3 &p = first.polygon[i], &q = second.polygon[k];
        const Vector3 u = first.polygon[i + 1] - p, v = second.polygon[k + 1] - q;
        const Approach near = closest(p, u, q, v);
        const double gap = near.distance - first.radius - second.radius;
        if (gap >= least) return;
        const Vector3 apart = p + near.s * u - q - near.t * v;
        // A neighbouring edge comes closer still: it will speak for itself, or it leads to an end that does not count.
        if (falls_beyond(first.polygon, edges_, i, near.s, apart) ||
            falls_beyond(second.polygon, edges_, k, near.t, -apart))
            return;
        const Places at{(i + near.s) / edges_, (k + near.t) / edges_};
        if (!counts(first, second, at)) return;
        least = gap, found = at;
    }

    static constexpr double least_steep = 0.2;  // share of the slope's square that a Newton step divides by at least
    const int edges_;                           // of a polygon, whole blocks
    Clearance best_;
};

}  // namespace

Clearance clearance(const Posture& posture, const std::vector<double>& radii, int points) {
    return ClearanceSearch(posture, radii, points).run();
}

}  // namespace softlimb::limb
