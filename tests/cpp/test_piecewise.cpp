#include <cmath>

#include "check.hpp"
#include "examples.hpp"
#include "softlimb/actuator/piecewise.hpp"
#include "softlimb/actuator/unloaded.hpp"

using namespace softlimb;
using namespace softlimb::actuator;
using namespace softlimb::tests;

CLAIM(a_table_of_smooth_functions_meets_them_to_the_digits_it_was_asked_for) {
    Piecewise<2> table;
    int samples = 0;
    table.fit(0.0, 10.0, 600, [&](double x, const auto*, auto& sample) {
        ++samples;
        sample.value = {std::sin(x), std::exp(-x)}, sample.allowed = {1e-13, 1e-13};
        return true;
    });
    CHECK(samples < 150);
    for (int i = 0; i <= 1000; ++i) {
        const double x = 0.01 * i;
        std::array<double, 2> y{};
        CHECK(table.at(x, y));
        CHECK_NEAR(y[0], std::sin(x), 2e-13);
        CHECK_NEAR(y[1], std::exp(-x), 2e-13);
        std::array<double, 2> again{}, slope{};
        CHECK(table.at(x, again, slope) && again == y);
        // A polynomial of degree 19 that errs by 1e-13 has slopes that err by 361 times that over half a piece, 1.25.
        CHECK_NEAR(slope[0], std::cos(x), 3e-11);
        CHECK_NEAR(slope[1], -std::exp(-x), 3e-11);
    }
    std::array<double, 2> y{};
    CHECK(!table.at(-1e-9, y) && !table.at(10.0 + 1e-9, y) && !table.at(std::nan(""), y));
}

CLAIM(a_table_has_no_values_at_a_corner_and_where_its_function_has_none) {
    Piecewise<1> table;
    int samples = 0;
    table.fit(0.0, 1.0, 600, [&](double x, const auto*, auto& sample) {
        ++samples;
        sample.value = {std::abs(x - 0.3)}, sample.allowed = {1e-12};
        return x < 0.8;
    });
    CHECK(samples <= 600);
    std::array<double, 1> y{};
    CHECK(!table.at(0.3, y) && !table.at(0.9, y));
    CHECK(table.at(0.1, y));
    CHECK_NEAR(y[0], 0.2, 1e-12);
    CHECK(table.at(0.5, y));
    CHECK_NEAR(y[0], 0.2, 1e-12);
}

namespace {

std::vector<Tube> examples() {
    return {proximal(),
            middle_tube(),
            distal(),
            plain_tube(),
            unequal(),
            unequal(true),
            proximal({.tension_only = true}),
            proximal({.ends = Ends::bonded, .cap_length = 0.01})};
}

}  // namespace

CLAIM(a_section_out_of_the_table_is_that_of_the_equilibrium) {
    Draw draw(5);
    for (const Tube& tube : examples()) {
        const Freedom free{true, true, tube.options().ends == Ends::free};
        const double highest = std::min(90 * kPa, tube.limit_pressure());
        for (int i = 0; i < 200; ++i) {
            const double pressure = highest * draw(0.0, 0.99);
            const SectionAtPressure at = tube.section(pressure);
            CHECK(at.status == solve::SolveStatus::converged);
            // Newton from far off, by another way than the table's own samples; its stiffness at the very shape.
            const Equilibrium found =
                relax(tube.wall(), {0.0, pressure, 0.0}, tube.path().guess(0.99 * pressure), free);
            const UnloadedState<double> state = unloaded_state(tube.wall().energy(found.shape), found.shape);
            const double active = tube.length() - 2.0 * tube.options().cap_length;
            const double rest = state.shape.stretch * active + (tube.length() - active);
            CHECK_NEAR(at.rest_length, rest, 1e-12 * rest);
            const AxialStiffness<double>& k = state.open;
            const double condensed = free.twist ? k.ll - k.lt * k.lt / k.tt : k.ll;
            const double axial = rest / active * pi * tube.inner_radius() * tube.inner_radius() * condensed;
            // Near the limit point of the plain tube the stiffness is a small difference.
            const double difficulty = state.locked.ll / condensed;
            CHECK_NEAR(at.section.axial, axial, 1e-12 * std::max(1.0, difficulty) * axial);
        }
    }
}

CLAIM(a_slope_to_the_pressure_out_of_the_table_is_that_of_the_equilibrium) {
    Draw draw(6);
    using Kind = TubeParameter::Kind;
    for (const Tube& tube : examples()) {
        const double highest = std::min(90 * kPa, tube.limit_pressure());
        for (const SectionModel model : {SectionModel::tangent, SectionModel::paper})
            for (const Valve valve : {Valve::open, Valve::locked})
                for (int i = 0; i < 50; ++i) {
                    const double pressure = highest * draw(0.01, 0.9);
                    std::vector<SectionSlope> table, plain;
                    tube.section_slopes(pressure, model, valve, {{Kind::pressure}}, table);
                    // Beside another parameter the pressure's slope is found by the equilibrium, differentiated.
                    tube.section_slopes(pressure, model, valve, {{Kind::pressure}, {Kind::length}}, plain);
                    const SectionAtPressure at = tube.section(pressure, model, valve);
                    const auto check = [&](double Section::* field) {
                        // A hundredth of what a Jacobian may miss.
                        const double size = std::abs(at.section.*field) / highest;
                        CHECK_NEAR(table[0].section.*field, plain[0].section.*field,
                                   1e-8 * (size + std::abs(plain[0].section.*field)));
                    };
                    for (double Section::* field :
                         {&Section::axial, &Section::shear, &Section::bending, &Section::torsion, &Section::rest_twist,
                          &Section::extension_twist, &Section::mass_per_length, &Section::stretch})
                        check(field);
                    CHECK_NEAR(table[0].rest_length, plain[0].rest_length, 1e-9 * at.rest_length / highest);
                    CHECK_NEAR(table[0].section.axial_law.coefficient[0], plain[0].section.axial_law.coefficient[0],
                               1e-8 / (at.section.axial * highest));
                }
    }
}

CLAIM(a_section_depends_on_its_pressure_alone) {
    for (const Tube& tube : examples()) {
        const Tube again(tube.length(), tube.layers(), tube.options());
        for (const double pressure : {80 * kPa, 1.0, 0.0, 33 * kPa, 1e-6, 60 * kPa}) {
            const SectionAtPressure first = tube.section(pressure), second = again.section(pressure);
            CHECK(first.section == second.section && first.rest_length == second.rest_length);
        }
    }
}
