#include "softlimb/limb/cantilever.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>

#include "softlimb/rod/lanes/pieces.hpp"

namespace softlimb::limb {
namespace {

using rod::lanes::Wanted;

constexpr int most_pieces = 8;

/// What is the same in all shots: the rod, its forces, and how it stands.
struct Cantilever {
    Pose base;
    const Section* section;
    double length;
    rod::LineLoad<double> load;
    Vector3 tip_force, base_force;

    Vector3 force(double from_tip) const { return tip_force + from_tip * (base_force - tip_force); }
    /// Exponent by which shots grow.
    double growth() const {
        return length * std::sqrt(std::max(tip_force.norm(), base_force.norm()) / section->bending);
    }
};

/// The limb as such a rod; none if anything else than its forces matters, or if these push.
std::optional<Cantilever> cantilever(const Geometry& geometry, const Scene& scene) {
    if (geometry.plates() != 1 || scene.rods.size() != 1 || scene.holds[0].any()) return std::nullopt;
    const Segment& segment = geometry.segments[0];
    const RodAtPressure& made = scene.rods[0];
    const Placement& place = segment.rods[0];
    const bool dead_force = scene.wrenches[0].tail<3>().isZero(0.0) &&
                            (!scene.following || scene.wrenches[0].isZero(0.0)) && is_zero(made.line_load.moment);
    const bool bare_tip = place.end.position.isZero(0.0) && (segment.plate_mass == 0.0 || scene.gravity.isZero(0.0));
    const bool untwisted = made.section.rest_twist == 0.0 && made.section.extension_twist == 0.0;
    if (!dead_force || !bare_tip || !untwisted) return std::nullopt;
    const rod::LineLoad<double> load = scene.line_load(0);
    const Vector3 tip_force = scene.wrenches[0].head<3>();
    const Vector3 base_force = tip_force + made.rest_length * eigen(load.force);
    // The force is linear along the rod: where it does not push at the ends it does not between.
    const Vector3 axis = place.base.rotation.col(2);
    const bool pulls = axis.dot(tip_force) >= 0.0 && axis.dot(base_force) >= 0.0;
    const bool straight = axis.cross(tip_force).isZero(0.0) && axis.cross(base_force).isZero(0.0);
    if (!pulls || straight || !base_force.allFinite()) return std::nullopt;
    // Pieces and steps are chosen by how much the rod bends. One that shears or stretches as much as it is long, or
    // that leaves what its axial law is known for, is another matter.
    const double largest_force = std::max(tip_force.norm(), base_force.norm());
    double strain, compliance;
    axial_strain(made.section.axial_law, largest_force, strain, compliance);
    if (!(largest_force < made.section.shear && strain < 1.0)) return std::nullopt;
    if (!made.section.axial_law.covers(largest_force) || !made.section.axial_law.covers(0.0)) return std::nullopt;
    return Cantilever{place.base, &made.section, made.rest_length, load, tip_force, base_force};
}

/// Two unit vectors perpendicular to one.
struct Across {
    Vector3 first, second;

    explicit Across(const Vector3& axis) {
        int smallest = 0;
        axis.cwiseAbs().minCoeff(&smallest);
        first = axis.cross(Vector3::Unit(smallest)).normalized();
        second = axis.cross(first);
    }
};

/// A shot from the tip to the base, where no moment is left: nodes counted from the base, position relative to the tip.
/// Nothing turns the rod about its tangent, so that the tip's decides all but the directors. Variations are by
/// rotations of the tip across its tangent; a rotation about it turns each node about its own and moves nothing.
struct Shot {
    int pieces = 0;
    Across tip{Vector3::UnitZ()};
    std::array<rod::RodState<double>, most_pieces + 1> state;  // directors of the last shot that has them
    rod::Variation<double> column[most_pieces + 1][2];

    Vector3 tangent(int node) const { return eigen(state[node].tangent); }
    Matrix3 rotation(int node) const {
        const Vector3 t = tangent(node), d = eigen(state[node].director);
        Matrix3 r;
        r << d, t.cross(d), t;
        return r;
    }
    Matrix3 turned(int node) const {
        return by(node, &rod::Variation<double>::rotation) + tangent(node) * tip.first.cross(tip.second).transpose();
    }
    Matrix3 by(int node, Vec3<double> rod::Variation<double>::* part) const {
        return eigen(column[node][0].*part) * tip.first.transpose() +
               eigen(column[node][1].*part) * tip.second.transpose();
    }
    double from_tip(int node) const { return 1.0 - static_cast<double>(node) / pieces; }
};

/// From a tip of that tangent; `pieces` and `steps` of each.
void shoot(const Cantilever& rod, Wanted wanted, const Vector3& tangent, int pieces, int steps, Shot& shot) {
    shot.pieces = pieces;
    const Across across(tangent);
    shot.state[pieces] = {{}, vec3(tangent), vec3(across.first), {}};
    if (wanted == Wanted::slopes) {
        shot.tip = across;
        shot.column[pieces][0] = {{}, vec3(across.first), {}}, shot.column[pieces][1] = {{}, vec3(across.second), {}};
    }
    rod::lanes::kernel().shoot_alone({rod.section, rod.length, rod.load, vec3(rod.tip_force), pieces, steps, wanted},
                                     shot.state.data(), shot.column);
}

/// Rotation of the tip that takes the base's tangent where it is clamped, to first order.
Vector3 correction(const Cantilever& rod, const Shot& shot, const Matrix3& inverse) {
    const Vector3 clamped = rod.base.rotation.col(2), found = shot.tangent(0), across = clamped.cross(found);
    const double sine = across.norm(), cosine = clamped.dot(found);
    constexpr double small = 1e-9;  // of whose angle no more than rounding is lost
    return -(inverse * across) * (sine < small && cosine > 0.0 ? 1.0 : std::atan2(sine, cosine) / sine);
}

/// Largest activity of the rod as one piece.
double activity(const Cantilever& rod, const Shot& shot) {
    double largest = 0.0;
    for (int node = 0; node <= shot.pieces; ++node) {
        Vector6 wrench;
        wrench << rod.force(shot.from_tip(node)), eigen(shot.state[node].moment);
        largest = std::max(largest, limb::activity(*rod.section, wrench, rod.length));
    }
    return largest;
}

/// No mode is unstable: the rotations that the tip's freedom leaves behind it nowhere turn back to zero.
bool surely_stable(const Shot& shot) {
    // Along a piece they change by little more than its activity allows, so a share this large at every node leaves
    // none between. Loads that pull make them grow towards the base.
    constexpr double least = 0.3;
    for (int node = 0; node < shot.pieces; ++node) {
        const Matrix3 turned = shot.turned(node), symmetric = 0.5 * (turned + turned.transpose());
        const Matrix3 less = symmetric - least * Matrix3::Identity();
        const double minor = less(0, 0) * less(1, 1) - less(0, 1) * less(0, 1);
        if (!(less(0, 0) > 0.0 && minor > 0.0 && less.determinant() > 0.0)) return false;
    }
    return true;
}

/// Everywhere the rod heads where its force pulls, and within a right angle of where it is clamped.
bool follows_its_forces(const Cantilever& rod, const Shot& shot) {
    constexpr double widest = 0.2;  // cosine of the angle
    for (int node = 0; node <= shot.pieces; ++node) {
        const Vector3 t = shot.tangent(node);
        if (!(t.dot(rod.force(shot.from_tip(node))) >= 0.0 && t.dot(rod.base.rotation.col(2)) > widest)) return false;
    }
    return true;
}

Shape shape_of(const Cantilever& rod, const Placement& place, const Shot& shot) {
    RodShape found;
    found.nodes.reserve(shot.pieces + 1), found.wrenches.reserve(shot.pieces);
    const Vector3 base = eigen(shot.state[0].position);
    for (int node = 0; node <= shot.pieces; ++node) {
        found.nodes.push_back({rod.base.position + eigen(shot.state[node].position) - base, shot.rotation(node)});
        if (node == shot.pieces) break;
        Vector6& wrench = found.wrenches.emplace_back();
        wrench << rod.force(shot.from_tip(node)), eigen(shot.state[node].moment);
    }
    found.nodes.front() = rod.base;
    Shape shape;
    shape.plates.push_back(found.nodes.back() * place.end.inverse());
    shape.rods.push_back(std::move(found));
    return shape;
}

/// The shot's states after a small rotation of its tip, with directors as the base is clamped.
void turn_tip(const Cantilever& rod, Shot& shot, const Vector3& turn) {
    for (int node = 0; node <= shot.pieces; ++node) {
        rod::RodState<double>& y = shot.state[node];
        const auto change = [&](Vec3<double> rod::Variation<double>::* part) {
            return vec3(Vector3(shot.by(node, part) * turn));
        };
        const Matrix3 rotation = exp_so3(shot.turned(node) * turn) * shot.rotation(node);
        y.position += change(&rod::Variation<double>::position), y.moment += change(&rod::Variation<double>::moment);
        y.tangent = vec3(rotation.col(2)), y.director = vec3(rotation.col(0));
    }
    // An angle about the tangents, the same at every node.
    const Vector3 clamped = rod.base.rotation.col(0);
    const Matrix3 base = shot.rotation(0);
    const double along = clamped.dot(base.col(0)), across = clamped.dot(base.col(1)), norm = std::hypot(along, across);
    for (int node = 0; node <= shot.pieces; ++node) {
        const Matrix3 rotation = shot.rotation(node);
        shot.state[node].director = vec3(Vector3((along * rotation.col(0) + across * rotation.col(1)) / norm));
    }
}

}  // namespace

std::optional<Solution> solve_cantilever(const Geometry& geometry, const Scene& scene, const SolveOptions& options) {
    const std::optional<Cantilever> rod = cantilever(geometry, scene);
    if (!rod) return std::nullopt;
    // A rod whose shots grow by more is pulled so hard that rounding at its tip would be seen at its base.
    constexpr double largest_growth = 8.0;
    if (!(rod->growth() < largest_growth)) return std::nullopt;
    const auto newton = [&](int pieces, Vector3& tip, Matrix3& inverse, Shot& shot) {
        shoot(*rod, Wanted::slopes, tip, pieces, 1, shot);
        inverse = shot.turned(0).inverse();
        const Vector3 turn = correction(*rod, shot, inverse);
        const double size = turn.norm(), largest = 0.7;
        tip = exp_so3(size > largest ? Vector3(largest / size * turn) : turn) * tip;
        return size;
    };
    Solution solution;
    Vector3 tip = rod->base.rotation.col(2);
    Matrix3 inverse;
    Shot shot;
    // By coarse steps, until what a step leaves is less than their error.
    constexpr int most_coarse = 8, most_fine = 6;
    const int coarse_pieces = std::max(2, static_cast<int>(std::ceil(0.75 * rod->growth())));
    constexpr double coarse = 0.05;
    for (double size = 1.0; !(size < coarse);) {
        if (++solution.iterations > most_coarse || !std::isfinite(size)) return std::nullopt;
        size = newton(coarse_pieces, tip, inverse, shot);
    }
    // Pieces such that one step each should meet the tolerance.
    const double whole = activity(*rod, shot);
    const double longest = std::min(warm_piece, allowed_step(options.tolerance));
    if (!(whole <= most_pieces * longest)) return std::nullopt;
    const int wanted = std::max(1, static_cast<int>(std::ceil(whole / longest)));
    // The forces fall towards the tip, and with them the error: two thirds mostly do, and the check tells.
    const int fewer = std::max(2, (2 * wanted + 2) / 3);
    for (const int pieces : {fewer, wanted}) {
        ++solution.iterations;
        double previous = newton(pieces, tip, inverse, shot), left = 1.0;
        Vector3 reach = Vector3::Zero();  // of the tip from the base, reversed
        if (!surely_stable(shot) || !follows_its_forces(*rod, shot)) return std::nullopt;
        // By steps of the eighth order, with these slopes: each turn leaves the same share of the one before.
        for (int round = 0; !(left < 0.1 * options.tolerance); ++round) {
            if (round == most_fine || !std::isfinite(left)) return std::nullopt;
            shoot(*rod, Wanted::axis, tip, pieces, 1, shot);
            const Vector3 turn = correction(*rod, shot, inverse);
            tip = exp_so3(turn) * tip;
            left = turn.norm() * std::min(turn.norm() / previous, 1.0);
            previous = turn.norm();
            reach = eigen(shot.state[0].position) + shot.by(0, &rod::Variation<double>::position) * turn;
        }
        // The same with half the step tells the error, and is the answer.
        shoot(*rod, Wanted::directors, tip, pieces, 2, shot);
        const Vector3 turn = correction(*rod, shot, inverse);
        turn_tip(*rod, shot, turn);
        solution.residual = turn.norm();
        solution.error_estimate =
            std::max(turn.norm(), (eigen(shot.state[0].position) - reach).norm() / geometry.length);
        if (solution.error_estimate <= options.tolerance) break;
    }
    if (!(solution.error_estimate <= options.tolerance)) return std::nullopt;
    solution.shape = shape_of(*rod, geometry.segments[0].rods[0], shot);
    solution.shape.rods[0].integration.steps = shot.pieces < wanted ? 2 : 1;
    if (!mesh_suffices(scene, options.tolerance, solution.shape)) return std::nullopt;
    solution.status = solve::SolveStatus::converged;
    solution.message = "converged";
    solution.plan.push_back("one clamped rod, pulled by dead forces: shot from its tip");
    solution.stable = true, solution.unstable_modes = 0;
    const Vector6& wrench = solution.shape.rods[0].wrenches.front();
    solution.base_wrench = -wrench;
    solution.base_wrench.tail<3>() -= rod->base.position.cross(rod->base_force);
    solution.reactions.assign(1, Vector6::Zero());
    return solution;
}

}  // namespace softlimb::limb
