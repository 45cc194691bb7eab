#include "check.hpp"
#include "examples.hpp"
#include "softlimb/rod/element.hpp"

using namespace softlimb;
using namespace softlimb::rod;
using namespace softlimb::tests;

namespace {

constexpr Integration fine{8, 6};
// Central differences with this step: 1e-10 of truncation, and rounding of 1e-16 over the step.
constexpr double step = 1e-5;

struct Example {
    Section section;
    LineLoad<double> load;
    RodPiece piece(double length = 0.1) const { return {&section, length, load}; }
};

std::vector<Example> examples() {
    const LineLoad<double> heavy{{1.0, -2.0, 4.0}, {0.02, 0.05, -0.03}};
    return {{soft_section(), {}}, {odd_section(), {}}, {soft_section(), heavy}, {odd_section(), heavy}};
}

Vector6 wrench(Draw& draw) {
    Vector6 w;
    w << draw.matrix<Vector3>(10.0), draw.matrix<Vector3>(0.8);
    return w;
}

/// Newton on the base wrench until the piece, shot from the first node, ends on the second.
Vector12 settled(const RodPiece& piece, const Pose& first, const Pose& second, Vector6 base, ElementStiffness& out) {
    ExactElement element;
    for (int round = 0; round < 12; ++round) {
        CHECK(element.linearise(piece, first, second, base, fine, out));
        base += element.wrench_change(Vector6::Zero(), Vector6::Zero(), element.gap());
    }
    return out.force;
}

}  // namespace

CLAIM(the_integrators_agree_with_each_other_as_their_orders_say) {
    Draw draw(10);
    for (const Example& example : examples()) {
        const Pose base = draw.pose(1.0);
        const Vector6 w = wrench(draw);
        const EndState exact = end_of(example.piece(), base, w, {8, 20});
        // 0.1 m in 20 steps: h = 0.005 m against a length of 0.1 m over which anything changes, to the fourth power.
        CHECK_NEAR(end_of(example.piece(), base, w, {4, 20}).pose.position, exact.pose.position, 1e-6);
        CHECK_NEAR(end_of(example.piece(), base, w, {6, 20}).pose.position, exact.pose.position, 1e-9);
        CHECK_NEAR(end_of(example.piece(), base, w, {8, 40}).pose.position, exact.pose.position, 1e-13);
        CHECK_NEAR(exact.pose.rotation.transpose() * exact.pose.rotation, Matrix3::Identity(), 1e-14);
    }
    CHECK_RAISES(std::invalid_argument, end_of(examples()[0].piece(), {}, Vector6::Zero(), {5, 1}));
}

CLAIM(states_along_a_piece_end_where_the_piece_ends) {
    Draw draw(11);
    for (const Example& example : examples()) {
        const Pose base = draw.pose(1.0);
        const Vector6 w = wrench(draw);
        const std::vector<double> fractions = {0.0, 0.0, 0.3, 0.7, 1.0};
        std::vector<EndState> states(fractions.size());
        states_along(example.piece(), base, w, fine, fractions.data(), static_cast<int>(fractions.size()),
                     states.data());
        const EndState end = end_of(example.piece(), base, w, fine);
        CHECK_NEAR(states.front().pose.position, base.position, 0.0);
        CHECK_NEAR(states.back().pose.position, end.pose.position, 1e-12);  // eighth order with other steps
        CHECK_NEAR(states.back().wrench, end.wrench, 1e-10);
    }
}

CLAIM(the_exact_element_has_the_stiffness_of_central_differences) {
    Draw draw(12);
    for (const Example& example : examples())
        for (int trial = 0; trial < 4; ++trial) {
            const RodPiece piece = example.piece();
            const Pose first = draw.pose(1.5);
            const Vector6 base = wrench(draw);
            const Pose second = end_of(piece, first, base, fine).pose;
            ElementStiffness at, ignored;
            settled(piece, first, second, base, at);
            CHECK_NEAR(at.force.head<6>(), -base, 1e-9 * base.norm());
            const double size = at.stiffness.cwiseAbs().maxCoeff();
            for (int k = 0; k < 12; ++k) {
                const Vector6 change = step * Vector6::Unit(k % 6);
                const auto force_at = [&](const Vector6& x) {
                    return k < 6 ? settled(piece, moved(first, x), second, base, ignored)
                                 : settled(piece, first, moved(second, x), base, ignored);
                };
                CHECK_NEAR(at.stiffness.col(k), (force_at(change) - force_at(-change)) / (2.0 * step), 1e-6 * size);
            }
        }
}

CLAIM(a_gap_enters_the_forces_as_the_linearised_wrench_that_closes_it) {
    Draw draw(13);
    const Example example = examples()[3];
    const RodPiece piece = example.piece();
    const Pose first = draw.pose(1.0);
    const Vector6 base = wrench(draw);
    const Pose end = end_of(piece, first, base, fine).pose;
    const Vector6 gap = 1e-6 * draw.matrix<Vector6>();
    ElementStiffness out;
    ExactElement element;
    CHECK(element.linearise(piece, first, moved(end, gap), base, fine, out));
    CHECK_NEAR(element.gap(), -gap, 1e-11);  // rotations add up to the square of the gap
    const Vector6 change = element.wrench_change(Vector6::Zero(), Vector6::Zero(), element.gap());
    CHECK_NEAR(change, element.wrench_for_gap(element.gap()), 1e-12 * change.norm());
    CHECK_NEAR(out.force.head<6>(), -(base + change), 1e-10 * base.norm());
    // The change closes the gap to first order: what remains is of the order of its square.
    CHECK_NEAR(end_of(piece, first, base + change, fine).pose.position, moved(end, gap).position, 1e-10);
}

CLAIM(a_rod_without_a_finite_shape_is_said_to_be_so) {
    const Example example = examples()[0];
    ElementStiffness out;
    ExactElement element;
    for (const double bad : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(), 1e200})
        CHECK(!element.linearise(example.piece(), {}, {}, Vector6::Constant(bad), fine, out));
}

CLAIM(the_end_has_the_slope_to_section_length_and_load_that_it_says) {
    Draw draw(14);
    for (const Example& example : examples()) {
        const RodPiece piece = example.piece();
        const Pose base = draw.pose(1.0);
        const Vector6 w = wrench(draw);
        Section slope;  // field by field
        slope.shear = 20.0, slope.bending = 0.02, slope.torsion = -0.01, slope.rest_twist = 0.7;
        slope.extension_twist = 0.01, slope.axial_law.coefficient = {1e-4, 2e-5, 3e-6, -1e-6};
        const Vector3 load_slope = draw.matrix<Vector3>();
        constexpr double length_slope = 0.3;
        const EndSlope found = end_slope(piece, slope, length_slope, load_slope, base, w, fine);
        const auto end_at = [&](double h) {
            Section section = example.section;
            section.shear += h * slope.shear, section.bending += h * slope.bending;
            section.torsion += h * slope.torsion, section.rest_twist += h * slope.rest_twist;
            section.extension_twist += h * slope.extension_twist;
            for (int i = 0; i <= example.section.axial_law.degree; ++i)
                section.axial_law.coefficient[i] += h * slope.axial_law.coefficient[i];
            LineLoad<double> load = piece.load;
            load.force += h * vec3(load_slope);
            return end_of({&section, piece.length + h * length_slope, load}, base, w, fine);
        };
        const EndState up = end_at(step), down = end_at(-step), here = end_at(0.0);
        CHECK_NEAR(found.pose, pose_gap(up.pose, down.pose) / (2.0 * step), 1e-6 * found.pose.norm());
        CHECK_NEAR(found.wrench, (up.wrench - down.wrench) / (2.0 * step), 1e-6 * found.wrench.norm());
        CHECK_NEAR(here.wrench, end_of(piece, base, w, fine).wrench, 0.0);
    }
}

CLAIM(the_geodesic_element_has_the_gradient_and_the_hessian_of_central_differences) {
    Draw draw(15);
    for (const double angle : {0.0, 1e-8, 0.19, 0.21, 0.99, 1.01, 2.4})
        for (const Example& example : examples()) {
            RodPiece piece = example.piece();
            const Pose first = draw.pose(1.5);
            Vector6 xi;
            xi << 0.02 * draw.matrix<Vector3>() + Vector3(0, 0, piece.length), angle * draw.direction();
            const Pose second = first * exp_se3(xi);
            const auto energy = [&](const Pose& a, const Pose& b) {
                return geodesic_energy(piece, log_se3(a.inverse() * b), a.position + b.position);
            };
            ElementStiffness at, up, down;
            geodesic_element(piece, first, second, at);
            Vector12 lumped_moment = Vector12::Zero();  // has no potential
            lumped_moment.segment<3>(3) = lumped_moment.tail<3>() = -0.5 * piece.length * eigen(piece.load.moment);
            const double size = at.stiffness.cwiseAbs().maxCoeff(), force = at.force.cwiseAbs().maxCoeff() + size;
            for (int k = 0; k < 12; ++k) {
                const Vector6 change = step * Vector6::Unit(k % 6);
                const auto nodes = [&](const Vector6& x) {
                    return k < 6 ? std::pair{moved(first, x), second} : std::pair{first, moved(second, x)};
                };
                const auto [a, b] = nodes(change);
                const auto [c, d] = nodes(-change);
                geodesic_element(piece, a, b, up), geodesic_element(piece, c, d, down);
                const double slope = (energy(a, b) - energy(c, d)) / (2.0 * step);
                CHECK_NEAR(at.force(k) - lumped_moment(k), slope, 1e-7 * force);
                CHECK_NEAR(at.stiffness.col(k), (up.force - down.force) / (2.0 * step), 1e-6 * size);
            }
        }
}

CLAIM(the_geodesic_base_wrench_is_the_force_on_the_first_node) {
    Draw draw(16);
    const Example example = examples()[1];
    const RodPiece piece = example.piece();
    const Pose first = draw.pose(1.0), second = first * draw.pose(0.5);
    ElementStiffness at;
    geodesic_element(piece, first, second, at);
    CHECK_NEAR(geodesic_base_wrench(piece, first, second), -at.force.head<6>(), 1e-12 * at.force.norm());
}
