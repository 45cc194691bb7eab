#include "check.hpp"
#include "examples.hpp"
#include "softlimb/limb/derivatives.hpp"
#include "softlimb/limb/energy.hpp"
#include "softlimb/sweep/parameters.hpp"

using namespace softlimb;
using namespace softlimb::limb;
using namespace softlimb::tests;
using actuator::SectionModel;
using actuator::TubeParameter;
using actuator::Valve;
using Eigen::MatrixXd;
using sweep::Parameter;

namespace {

const SolveOptions exact{.tolerance = 1e-11, .interrupted = {}};
const std::vector<MaterialPoint> points = {{0, 0.0}, {1, 0.3}, {4, 1.0}, {8, 0.77}};

std::shared_ptr<const Posture> complex_posture_solved() {
    return std::make_shared<const Posture>(posture_of(reference().geometry, complex_posture(), exact));
}

sweep::Members members() {
    std::vector<sweep::Member> list;
    for (int i = 0; i < 9; ++i)
        list.push_back({.tube = std::make_shared<const actuator::Tube>(reference().tubes[i / 3])});
    return sweep::Members(std::move(list));
}

/// One parameter of every kind that a limb of tubes has.
sweep::Parameters some_parameters() {
    sweep::Parameters all;
    const auto add = [&](Parameter p) {
        p.column = all.columns++;
        all.list.push_back(p);
    };
    add({.place = 4, .tube = {TubeParameter::Kind::pressure}});
    add({.place = 1, .tube = {TubeParameter::Kind::radius, 0, 1}});
    add({.place = 7, .tube = {TubeParameter::Kind::angle, 1, 0, 1}});
    Vector12 outwards = Vector12::Zero();
    outwards(0) = outwards(6) = 1.0, outwards(9) = 0.3;
    add({.kind = Parameter::Kind::placement, .place = 3, .direction = outwards});
    add({.kind = Parameter::Kind::line_force, .place = 2, .component = 1});
    add({.kind = Parameter::Kind::plate_thickness, .place = 0});
    add({.kind = Parameter::Kind::plate_mass, .place = 1});
    add({.kind = Parameter::Kind::wrench, .place = 1, .component = 4});
    add({.kind = Parameter::Kind::gravity, .component = 0});
    return all;
}

std::vector<SceneRate> rates(const Posture& posture) {
    return sweep::rates_of(some_parameters(), members(), posture.scene, complex_pressures.data(), SectionModel::tangent,
                           Valve::open);
}

}  // namespace

CLAIM(compliance_and_stiffness_are_slopes_of_the_answer) {
    const auto posture = complex_posture_solved();
    const Derivatives linear(posture, exact.tolerance);
    const Matrix6 compliance = linear.compliance();
    CHECK_NEAR(compliance, compliance.transpose(), 1e-7 * compliance.cwiseAbs().maxCoeff());
    constexpr double force = 1e-3;
    for (int k = 0; k < 6; k += 2) {  // 0 and 2: forces; 4: a moment
        Scene up = posture->scene, down = posture->scene;
        up.wrenches.back()(k) += force, down.wrenches.back()(k) -= force;
        const Posture a = posture_of(reference().geometry, up, exact, &posture->solution.shape);
        const Posture b = posture_of(reference().geometry, down, exact, &posture->solution.shape);
        const Vector6 slope =
            rod::pose_gap(a.solution.shape.plates.back(), b.solution.shape.plates.back()) / (2.0 * force);
        // Answers to 1e-11 over 1e-3 N, and the third derivative of the tip by its load.
        CHECK_NEAR(compliance.col(k), slope, 1e-4 * compliance.col(k).norm());
    }
    const MatrixXd stiffness = linear.plate_stiffness();
    CHECK(stiffness.rows() == 18 && stiffness.cols() == 18);
    CHECK_NEAR(stiffness, stiffness.transpose(), 1e-7 * stiffness.cwiseAbs().maxCoeff());
}

CLAIM(pressures_move_the_plates_as_solves_do) {
    const auto posture = complex_posture_solved();
    sweep::Parameters pressures;
    for (int i = 0; i < 9; ++i)
        pressures.list.push_back({.place = i, .tube = {TubeParameter::Kind::pressure}, .column = i});
    pressures.columns = 9;
    const MatrixXd found = Derivatives(posture, exact.tolerance)
                               .forward(sweep::rates_of(pressures, members(), posture->scene, complex_pressures.data(),
                                                        SectionModel::tangent, Valve::open),
                                        {});
    constexpr double h = 10.0;  // [Pa]
    for (const int i : {0, 4, 8}) {
        const auto at = [&](double change) {
            std::vector<double> changed = complex_pressures;
            changed[i] += change;
            Scene other = reference().scene(changed);
            other.gravity = hanging;
            return posture_of(reference().geometry, other, exact, &posture->solution.shape)
                .solution.shape.plates.back();
        };
        const Vector6 slope = rod::pose_gap(at(h), at(-h)) / (2.0 * h);
        CHECK_NEAR(Vector6(found.col(i).tail<6>()), slope, 1e-5 * slope.norm());
    }
}

CLAIM(the_adjoint_is_the_transpose_of_the_forward_derivative) {
    const auto posture = complex_posture_solved();
    const Derivatives linear(posture, exact.tolerance);
    const std::vector<SceneRate> all = rates(*posture);
    const MatrixXd forward = linear.forward(all, points);
    Draw draw(61);
    const MatrixXd weights = MatrixXd::NullaryExpr(3, forward.rows(), [&] { return draw(); });
    const MatrixXd expected = weights * forward, found = linear.adjoint(weights, all, points);
    for (Eigen::Index n = 0; n < forward.cols(); ++n)
        CHECK_NEAR(found.col(n), expected.col(n), 1e-10 * forward.col(n).norm());
    CHECK(linear.forward({}, points).cols() == 0 && linear.adjoint(weights, {}, points).cols() == 0);
}

CLAIM(a_scene_that_moves_as_a_whole_or_not_at_all_has_no_slopes_that_it_should_not_have) {
    const auto posture = complex_posture_solved();
    const Derivatives linear(posture, exact.tolerance);
    CHECK(linear.forward({SceneRate{}}, points).isZero(0.0));
    // All rods of the first segment pushed aside on the base and on their plate: the limb above stays as it is.
    SceneRate aside;
    for (int i = 0; i < 3; ++i) aside.rod(i).base(0) = 1.0;
    const MatrixXd moved = linear.forward({aside}, {{8, 0.5}});
    for (int j = 0; j < 3; ++j) {
        Vector6 whole = Vector6::Zero();
        whole(0) = 1.0;
        CHECK_NEAR(Vector6(moved.col(0).segment<6>(6 * j)), whole, 1e-7);
    }
    CHECK_NEAR(moved(18, 0), 1.0, 1e-7);
}

CLAIM(the_energy_has_the_slopes_of_the_energy_at_the_shape_as_it_is) {
    const auto posture = complex_posture_solved();
    std::vector<SceneRate> all = rates(*posture);
    CHECK_RAISES(std::runtime_error, potential_energy_slopes(*posture, all));  // a moment has no potential
    SceneRate loads;
    loads.gravity = {0.0, 0.0, 1.0};
    const double slope = potential_energy_slopes(*posture, {loads})[0];
    const auto energy_at = [&](double change) {
        Scene scene = posture->scene;
        scene.gravity.z() += change;
        return potential_energy(posture_of(reference().geometry, scene, exact, &posture->solution.shape));
    };
    constexpr double h = 1e-2;  // the energy is a parabola of the load to 1e-8 or so
    CHECK_NEAR(slope, (energy_at(h) - energy_at(-h)) / (2.0 * h), 1e-7 * std::abs(slope));
    Posture turned = *posture;
    turned.scene.wrenches.back()(4) = 0.1;
    CHECK_RAISES(std::runtime_error, potential_energy(turned));
}

CLAIM(parameters_that_a_limb_does_not_have_are_refused) {
    const sweep::Members of = members();
    const Geometry& geometry = *reference().geometry;
    sweep::check(some_parameters(), of, geometry);
    const auto refused = [&](const Parameter& p, int columns = 1) {
        CHECK_RAISES(std::invalid_argument, sweep::check({{p}, columns}, of, geometry));
    };
    refused({.place = 9});
    refused({.place = -1});
    refused({.place = 0}, 0);
    refused({.place = 0, .tube = {TubeParameter::Kind::radius, 0, 3}});
    refused({.place = 0, .tube = {TubeParameter::Kind::mass}});
    refused({.place = 0, .tube = {TubeParameter::Kind::stiffness, 1, 0}});
    refused({.place = 0, .tube = {TubeParameter::Kind::angle, 1, 0, 2}});
    refused({.place = 0, .tube = {TubeParameter::Kind::coefficient, 0, 3}});
    refused({.kind = Parameter::Kind::rod_length, .place = 0});
    refused({.kind = Parameter::Kind::wrench, .place = 3});
    refused({.kind = Parameter::Kind::wrench, .place = 0, .component = 6});
    refused({.kind = Parameter::Kind::gravity, .component = 3});
}
