// Pressure control against the plant: bounded under any command, no memory taken in a step, the same from a copy.
#include <limits>

#include "allocations.hpp"
#include "check.hpp"
#include "examples.hpp"
#include "softlimb/control/loop.hpp"

using namespace softlimb;
using namespace softlimb::tests;

namespace {

control::Plant plant(double exponent, int substeps) {
    const control::VolumeTable volume({0.0, 100e3, 200e3}, {5e-5, 9e-5, 12e-5});
    const control::ChannelParameters channel{
        {1e-9, 1e-9, 0.3, 0.01, 0.003, 0.03, 0.02}, {1.0, 2.5e-3}, 2e-9, volume, {0.0, 200e3, 100.0, 0.0, 10}};
    const control::Gas gas{.exponent = exponent};
    return {gas, {5e-3, 250e3, 6e-4, 20e3}, {channel, channel, channel}, 1e-3, substeps, 1};
}

}  // namespace

CLAIM(pressures_stay_between_atmosphere_and_supply_and_no_air_is_made_under_any_commands) {
    for (const double exponent : {1.0, 1.4}) {
        control::Plant p = plant(exponent, 2);
        Draw draw(71);
        std::vector<double> commands(3);
        const int steps = 2000;
        for (int k = 0; k < steps; ++k) {
            if (k % 50 == 0)
                for (double& command : commands) command = draw(-1.5, 1.5);
            if (k == 1500) commands[1] = std::numeric_limits<double>::quiet_NaN();
            CHECK(p.advance(commands.data()));
            for (std::size_t i = 0; i < 3; ++i) CHECK(p.pressure(i) > -1.0 && p.pressure(i) < 250e3);
        }
        const control::AirLedger air = p.ledger();
        // Each of the sub-steps adds a few numbers to sums of 0.02 kg, a rounding of 3e-18 each.
        CHECK_NEAR(air.stored, air.at_start + air.pumped - air.lost, steps * 2 * 3 * 3e-18);
        CHECK_NEAR(p.mass_defect(), 0.0, 1e-10);  // Newton's 1e-12 of a channel, over the line's share of its air
    }
}

CLAIM(a_step_of_plant_and_controllers_takes_no_memory) {
    control::Plant p = plant(1.2, 4);
    const control::Common<double> common{.scale = 1e5};
    const double weights[3] = {3.0, 3.0, 0.0};
    control::Pid<double> pid(common, weights);
    control::NeuralPid<double> neural(common, weights, {});
    std::vector<double> readings(3), commands(3);
    const long before = allocations();
    for (int k = 0; k < 500; ++k) {
        p.read(readings.data());
        commands[0] = pid.step(50e3, readings[0]);
        commands[1] = neural.step(60e3, readings[1]);
        p.advance(commands.data());
    }
    CHECK(allocations() == before);
    CHECK_NEAR(p.pressure(0), 50e3,
               2e3);  // that something was controlled: within a few codes and the valve's dead band
}

CLAIM(a_copy_of_a_plant_goes_on_as_the_plant_does) {
    control::Plant one = plant(1.2, 4);
    const std::vector<double> commands{0.5, -0.2, 1.0};
    for (int k = 0; k < 50; ++k) one.advance(commands.data());
    control::Plant other = one;
    std::vector<double> a(3), b(3);
    for (int k = 0; k < 50; ++k) {
        one.advance(commands.data());
        other.advance(commands.data());
        one.read(a.data());
        other.read(b.data());
        CHECK(a == b);
    }
}
