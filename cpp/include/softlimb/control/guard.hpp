#pragma once
// Watches one actuator: is its pressure sensor alive, and does the pressure follow the valve? Freestanding.
#include <stdint.h>

#include "softlimb/control/scalar.hpp"

namespace softlimb {
namespace control {

enum class Fault : uint8_t {
    none,
    sensor_not_finite,  // readings that are no number
    sensor_stuck,       // the same reading although the valve moves air
    over_pressure,      // above what the actuator may carry
    no_response,        // full command, error large, pressure does not come nearer: a valve that is stuck
    supply_lost,        // the supply is below what is needed
};

template <class Real>
struct GuardOptions {
    int32_t not_finite_steps = 5;     // in a row; one lost reading is no fault
    Real highest = Real(1.5e5);       // reading [Pa]
    int32_t over_pressure_steps = 5;  // in a row; a spike of noise is no fault
    // A healthy reading repeats itself too, where the converter is coarse and the valve is shut. Not while the valve
    // has moved this much air: sum of |command| beyond the idle band, in steps of full command.
    Real stuck_effort = Real(150);
    Real idle_command = Real(0.15);
    // Full command towards the target for so long must have changed the reading by so much.
    Real response_error = Real(5e3);    // [Pa]; below it a slow end of an exhaust is no fault
    Real response_command = Real(0.9);  // of the limit
    Real response = Real(1e3);          // [Pa]
    int32_t response_steps = 400;
    Real lowest_supply = Real(0);  // reading of the supply's own sensor [Pa]
    int32_t supply_steps = 20;

    constexpr bool valid() const {
        return not_finite_steps > 0 && over_pressure_steps > 0 && response_steps > 0 && supply_steps > 0 &&
               is_finite(highest) && is_finite(stuck_effort) && stuck_effort > Real(0) && is_finite(idle_command) &&
               is_finite(response_error) && response_error > Real(0) && is_finite(response_command) &&
               is_finite(response) && is_finite(lowest_supply);
    }
};

/// One step after the controller's. The first fault stays until `reset`.
template <class Real>
class Guard {
public:
    constexpr explicit Guard(const GuardOptions<Real>& options) : o_(options) {}

    constexpr Fault step(Real target, Real reading, Real command, Real supply) {
        if (fault_ != Fault::none) return fault_;
        if (count(!is_finite(reading), not_finite_) >= o_.not_finite_steps) return fault_ = Fault::sensor_not_finite;
        if (count(!(supply >= o_.lowest_supply), supply_low_) >= o_.supply_steps) return fault_ = Fault::supply_lost;
        if (!is_finite(reading)) return fault_;
        if (count(reading > o_.highest, too_high_) >= o_.over_pressure_steps) return fault_ = Fault::over_pressure;

        const bool same = seen_ && reading == last_;
        const Real moved = magnitude(command) - o_.idle_command;
        effort_ = same ? effort_ + (moved > Real(0) ? moved : Real(0)) : Real(0);
        last_ = reading;
        seen_ = true;
        if (effort_ >= o_.stuck_effort) return fault_ = Fault::sensor_stuck;

        const Real error = target - reading;
        const int8_t way = command >= o_.response_command ? 1 : (command <= -o_.response_command ? -1 : 0);
        const bool pushing = way != 0 && error * Real(way) >= o_.response_error;
        if (!pushing || way != way_ || (reading - from_) * Real(way) >= o_.response) {
            from_ = reading;
            way_ = way;
            pushing_ = 0;
        } else if (++pushing_ >= o_.response_steps) {
            return fault_ = Fault::no_response;
        }
        return fault_;
    }

    constexpr Fault fault() const { return fault_; }
    constexpr void reset() { *this = Guard(o_); }

private:
    static constexpr int32_t count(bool bad, int32_t& in_a_row) { return in_a_row = bad ? in_a_row + 1 : 0; }

    GuardOptions<Real> o_;
    Fault fault_ = Fault::none;
    int32_t not_finite_ = 0, supply_low_ = 0, too_high_ = 0, pushing_ = 0;
    Real last_ = Real(0), effort_ = Real(0), from_ = Real(0);
    int8_t way_ = 0;
    bool seen_ = false;
};

}  // namespace control
}  // namespace softlimb
