#include "check.hpp"
#include "examples.hpp"
#include "softlimb/actuator/thread.hpp"

using namespace softlimb;
using namespace softlimb::actuator;
using namespace softlimb::tests;
using solve::SolveStatus;

namespace {

std::vector<Tube> examples() {
    return {proximal(), distal(), plain_tube(), unequal(), unequal(true), proximal({.tension_only = true})};
}

template <class S>
std::array<S, 10> numbers(const WallEnergy<S>& e) {
    return {e.value, e.g_l, e.g_w, e.g_t, e.h_ll, e.h_lw, e.h_lt, e.h_ww, e.h_wt, e.h_tt};
}

Shape<double> shifted(const Shape<double>& q, int k, double h) {
    Shape<double> p = q;
    (k == 0 ? p.stretch : k == 1 ? p.volume : p.twist) += h;
    return p;
}

}  // namespace

CLAIM(the_energy_of_a_wall_has_the_gradient_and_the_hessian_that_it_says) {
    for (const Tube& tube : examples()) {
        for (const Shape<double> q : {Shape<double>{1.1, 1.15, 0.02}, {1.3, 1.5, 0.0}, {0.95, 1.1, -0.05}}) {
            const Wall& wall = tube.wall();
            const WallEnergy<double> e = wall.energy(q);
            const double gradient[] = {e.g_l, e.g_w, e.g_t};
            const double hessian[3][3] = {{e.h_ll, e.h_lw, e.h_lt}, {e.h_lw, e.h_ww, e.h_wt}, {e.h_lt, e.h_wt, e.h_tt}};
            const double size = std::abs(e.h_ll) + std::abs(e.h_ww) + std::abs(e.h_tt);
            for (int k = 0; k < 3; ++k) {
                constexpr double h = 1e-5;
                const WallEnergy<double> up = wall.energy(shifted(q, k, h)), down = wall.energy(shifted(q, k, -h));
                // Truncation 1e-10 of the third derivatives; a slack boundary moves and quadrature follows it to 1e-6.
                const double tolerance = 1e-6 * size;
                CHECK_NEAR(gradient[k], (up.value - down.value) / (2.0 * h), tolerance);
                CHECK_NEAR(hessian[k][0], (up.g_l - down.g_l) / (2.0 * h), tolerance);
                CHECK_NEAR(hessian[k][1], (up.g_w - down.g_w) / (2.0 * h), tolerance);
                CHECK_NEAR(hessian[k][2], (up.g_t - down.g_t) / (2.0 * h), tolerance);
                Shape<Dual<1>> d{q.stretch, q.volume, q.twist};
                (k == 0 ? d.stretch : k == 1 ? d.volume : d.twist).slope[0] = 1.0;
                const auto slopes = numbers(wall.energy(d));
                const auto above = numbers(up), below = numbers(down);
                for (int i = 0; i < 10; ++i)
                    CHECK_NEAR(slopes[i].slope[0], (above[i] - below[i]) / (2.0 * h), 10.0 * tolerance);
            }
        }
    }
}

CLAIM(an_inflated_tube_balances_pressure_force_and_torque) {
    for (const Tube& tube : examples()) {
        const double area = pi * tube.inner_radius() * tube.inner_radius();
        for (const double pressure : {0.0, 1e-6, 1.0, 5 * kPa, 30 * kPa, 55 * kPa, 80 * kPa})
            for (const double force : {0.0, 3.0, -2.0})
                for (const double torque : {0.0, 0.01}) {
                    const TubeState state = tube.inflate(pressure, force, torque);
                    CHECK(state.success && state.stable && state.status == SolveStatus::converged);
                    const WallEnergy<double> e = tube.wall().energy(state.shape);
                    // The last Newton step is below 1e-11, times a Hessian of at most a gigapascal of fibres.
                    const double tolerance = 1e-10 * (std::abs(e.h_ll) + std::abs(e.h_ww) + std::abs(e.h_tt));
                    CHECK_NEAR(e.g_w, pressure, tolerance);
                    CHECK_NEAR(e.g_l, force / area, tolerance);
                    CHECK_NEAR(e.g_t, torque / (area * tube.inner_radius()), tolerance);
                }
    }
}

CLAIM(a_plain_tube_balloons_at_its_limit_point_and_volume_control_goes_past_it) {
    const Tube tube = plain_tube();
    CHECK(tube.has_limit() && tube.path_end() == PathEnd::limit_point);
    CHECK_NEAR(tube.limit_pressure(), 90.6 * kPa, 0.1 * kPa);  // by an independent solution, to its last printed digit
    CHECK(tube.inflate(0.9999 * tube.limit_pressure()).success);
    const double limit = tube.limit_pressure();
    for (const double beyond : {1.0001 * limit, 10.0 * limit, 1e12, 1e300}) {
        const TubeState state = tube.inflate(beyond);
        CHECK(!state.success && state.status == SolveStatus::limit_point);
        CHECK(std::isfinite(state.stretch) && std::isfinite(state.inner_radius));
    }
    const TubeState at_limit = tube.inflate(0.9999 * limit);
    const double volume = pi * at_limit.inner_radius * at_limit.inner_radius * at_limit.stretch * tube.length();
    const TubeState blown = tube.at_volume(3.0 * volume);
    CHECK(blown.status == SolveStatus::converged && !blown.stable && blown.pressure < tube.limit_pressure());
    const TubeState again = tube.at_inner_radius(blown.inner_radius);
    CHECK_NEAR(again.pressure, blown.pressure, 1e-8 * blown.pressure);
}

CLAIM(a_stretch_leads_back_to_its_pressure) {
    for (const Tube& tube : examples())
        for (const double pressure : {10 * kPa, 55 * kPa, 85 * kPa}) {
            const double stretch = tube.inflate(pressure).stretch;
            const TubeState back = tube.at_stretch(stretch);
            CHECK(back.success);
            // Of several pressures with this stretch the lowest is given: compare stretches, and pressures where
            // unique.
            CHECK_NEAR(back.stretch, stretch, 1e-10);
            if (tube.pressures_at_stretch(stretch).empty()) CHECK_NEAR(back.pressure, pressure, 1e-6 * pressure);
        }
    CHECK(!proximal().at_stretch(100.0).success);
    CHECK(!proximal().at_stretch(1e-3).success);
}

CLAIM(no_pressure_however_odd_leads_to_an_answer_that_is_not_finite) {
    for (const Tube& tube : examples())
        for (const double pressure : {-1e-300, -1.0, -20 * kPa, -1e6, -1e300, 1e6, 1e9, 1e300}) {
            const TubeState state = tube.inflate(pressure);
            CHECK(std::isfinite(state.stretch + state.inner_radius + state.twist_rate));
            CHECK(!state.success || state.status == SolveStatus::converged);
            for (const double force : {1e3, -1e3, 1e300}) {
                const TubeState pulled = tube.inflate(pressure, force, 0.0);
                CHECK(!pulled.success || std::isfinite(pulled.stretch + pulled.inner_radius));
            }
        }
    const double nan = std::numeric_limits<double>::quiet_NaN();
    CHECK_RAISES(std::invalid_argument, proximal().inflate(nan));
    CHECK_RAISES(std::invalid_argument, proximal().inflate(0.0, nan));
}

CLAIM(a_tube_whose_law_ends_at_once_answers_with_a_status) {
    // Gent's limit at a strain of 1e-6: the path of equilibria has hardly a point besides rest.
    for (const double jm : {1e-300, 1e-12, 1e-6, 1e-2}) {
        const Tube tube(0.2, {Layer::make(0.018, 0.0215, materials::Gent{.mu = 160e3, .jm = jm}, {})});
        for (const double pressure : {0.0, 1.0, 10 * kPa})
            for (const double force : {0.0, 1e-3, 5.0}) {
                const TubeState state = tube.inflate(pressure, force, 0.0);
                CHECK(std::isfinite(state.stretch));
                CHECK(!state.success || std::isfinite(state.inner_radius));
            }
        CHECK(!tube.at_stretch(2.0).success);
        CHECK(std::isfinite(tube.at_stretch(1.0).stretch));
        static_cast<void>(tube.pressures_at_stretch(1.0 + 1e-9));
    }
}

CLAIM(stress_is_the_pressure_inside_and_nothing_outside) {
    for (const Tube& tube : {proximal(), unequal(), distal()}) {
        const TubeState state = tube.inflate(55 * kPa);
        const WallStress inside = tube.stress_at_reference(state, tube.inner_radius());
        const WallStress outside = tube.stress_at_reference(state, tube.outer_radius());
        // Four Gauss points a layer; the balance itself holds to 1e-9.
        CHECK_NEAR(inside.radial, -55 * kPa, 1e-6 * 55 * kPa);
        CHECK_NEAR(outside.radial, 0.0, 1e-6 * 55 * kPa);
        CHECK(tube.fibres(state).size() == 2);
        CHECK_RAISES(std::invalid_argument, tube.stress(state, 1.0));
    }
}

CLAIM(a_section_has_the_slope_to_the_pressure_that_it_says) {
    for (const Tube& tube : {proximal(), unequal()})
        for (const SectionModel model : {SectionModel::tangent, SectionModel::nonlinear, SectionModel::paper})
            for (const Valve valve : {Valve::open, Valve::locked}) {
                constexpr double pressure = 40 * kPa, h = 1.0;
                const SectionAtPressure at = tube.section(pressure, model, valve, true);
                const SectionAtPressure up = tube.section(pressure + h, model, valve);
                const SectionAtPressure down = tube.section(pressure - h, model, valve);
                CHECK(at.status == SolveStatus::converged);
                const auto check = [&](double Section::* field) {
                    const double slope = (up.section.*field - down.section.*field) / (2.0 * h);
                    // Equilibria to 1e-11 give differences to 1e-11 of the value over h.
                    const double tolerance = 1e-6 * std::abs(slope) + 1e-10 * std::abs(at.section.*field);
                    CHECK_NEAR(at.d_section.*field, slope, tolerance);
                };
                check(&Section::axial), check(&Section::shear), check(&Section::bending), check(&Section::torsion);
                check(&Section::rest_twist), check(&Section::extension_twist), check(&Section::mass_per_length);
                CHECK_NEAR(at.d_rest_length, (up.rest_length - down.rest_length) / (2.0 * h), 1e-11);
                at.section.check();
            }
}

CLAIM(tubes_that_cannot_be_built_are_refused) {
    const materials::AnyLaw law = smoothsil();
    CHECK_RAISES(std::invalid_argument, Layer::make(0.02, 0.01, law, {}));
    CHECK_RAISES(std::invalid_argument, Layer::make(-0.02, 0.01, law, {}));
    CHECK_RAISES(std::invalid_argument, Tube(0.2, {}));
    CHECK_RAISES(std::invalid_argument, Tube(0.0, {Layer::make(0.018, 0.02, law, {})}));
    CHECK_RAISES(std::invalid_argument,
                 Tube(0.2, {Layer::make(0.01, 0.02, law, {}), Layer::make(0.03, 0.04, law, {})}));
    CHECK_RAISES(std::invalid_argument, Fibres::with_stiffness(88.67, 1e8));
    CHECK_RAISES(std::invalid_argument, Fibres::with_fraction(0.1, 1e9, 1.5));
    CHECK_RAISES(std::invalid_argument, thread_geometry(0.02, 0.021, 0.01, 0.003));
}
