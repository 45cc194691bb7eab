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
    no_response,        // air is sent towards the target and the pressure does not come nearer: a valve that is stuck
    wrong_way,          // full command away from the target: gains of the wrong sign
    supply_lost,        // the supply is below what is needed
};

/// Air counts in steps of full flow: |command| beyond the idle band times the pressure difference over `full_drop`, at
/// most one. A subsonic exhaust passes about that share of what a choked feed does.
template <class Real>
struct GuardOptions {
    int32_t not_finite_steps = 5;     // in a row; one lost reading is no fault
    Real highest = Real(1.5e5);       // reading [Pa]
    int32_t over_pressure_steps = 5;  // in a row; a spike of noise is no fault
    Real idle_command = Real(0.04);   // opens nothing: the valve's dead band and half its play
    Real full_drop = Real(1.6e5);     // [Pa]
    // So much air must have changed any reading. A healthy one repeats itself too, where the converter is coarse: not
    // while this much air moves. Of slow air the share will do that a code of the converter, the least change seen so
    // far, has of `coarse_code`, a tenth at least: what is in the valve's dead time and lag counts little then.
    Real stuck_effort = Real(60);
    Real coarse_code = Real(1e3);  // [Pa]
    int32_t stuck_steps = 250;     // with the valve open, in a row: air is slow
    // So much air towards the target must have brought the reading nearer by so much. It may be sent in pieces, as
    // after a target that swings.
    Real response_error = Real(2e3);  // [Pa]; nearer than this nothing is counted: a small leak holds no error
    Real response = Real(1e3);        // [Pa]
    Real response_effort = Real(120);
    // Full command away from the target for so long is no control.
    Real response_command = Real(0.9);  // of the limit
    int32_t response_steps = 400;
    Real lowest_supply = Real(0);  // reading of the supply's own sensor [Pa]
    int32_t supply_steps = 20;
    Real low = Real(-1);  // limits of the command
    Real high = Real(1);

    constexpr bool valid() const {
        return not_finite_steps > 0 && over_pressure_steps > 0 && response_steps > 0 && supply_steps > 0 &&
               is_finite(highest) && positive(idle_command) && positive(full_drop) && positive(stuck_effort) &&
               positive(coarse_code) && stuck_steps > 0 && positive(response_error) && positive(response) &&
               positive(response_effort) && positive(response_command) && response_command <= Real(1) &&
               is_finite(lowest_supply) && is_finite(low) && is_finite(high) && low < high;
    }

private:
    static constexpr bool positive(Real x) { return is_finite(x) && x > Real(0); }
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

        const Real moved = flow(reading, command, supply, Real(0));
        const Real change = magnitude(reading - last_);
        if (seen_ && change == Real(0)) {
            effort_ += moved;
            open_ += moved > Real(0);
        } else {
            if (seen_ && (code_ == Real(0) || change < code_)) code_ = change;
            effort_ = Real(0);
            open_ = 0;
        }
        last_ = reading;
        const Real share = open_ < o_.stuck_steps || code_ == Real(0) ? Real(1) : code_ / o_.coarse_code;
        if (effort_ >= o_.stuck_effort * within(share, Real(0.1), Real(1))) return fault_ = Fault::sensor_stuck;

        if (!seen_) extreme_[0] = extreme_[1] = reading;
        seen_ = true;
        const Real error = target - reading;
        // Near the end of an exhaust, or of the supply, no air moves: a share of full flow is counted there all the
        // same, so that a target that is beyond both is a fault in the end.
        const Real sent = magnitude(error) >= o_.response_error ? flow(reading, command, supply, Real(0.1)) : Real(0);
        for (int way = 0; way < 2; ++way) {  // down, up
            const Real sign = way == 1 ? Real(1) : Real(-1);
            // The reading that it was farthest from the target with, since it last came nearer.
            if ((extreme_[way] - reading) * sign > Real(0)) extreme_[way] = reading;
            if ((reading - extreme_[way]) * sign >= o_.response) {
                extreme_[way] = reading;
                sent_[way] = Real(0);
            } else if (command * sign > Real(0) && error * sign > Real(0)) {
                sent_[way] += sent;
            }
            if (sent_[way] >= o_.response_effort) return fault_ = Fault::no_response;
        }
        const bool up = o_.high > Real(0) && command >= o_.response_command * o_.high;
        const bool down = o_.low < Real(0) && command <= o_.response_command * o_.low;
        const bool away = (up && error <= -o_.response_error) || (down && error >= o_.response_error);
        if (count(away, away_) >= o_.response_steps) return fault_ = Fault::wrong_way;
        return fault_;
    }

    constexpr Fault fault() const { return fault_; }
    constexpr void reset() { *this = Guard(o_); }

private:
    static constexpr int32_t count(bool bad, int32_t& in_a_row) { return in_a_row = bad ? in_a_row + 1 : 0; }

    /// Air that a command moves in a step, in steps of full flow; the least share of it where the valve is open.
    constexpr Real flow(Real reading, Real command, Real supply, Real least) const {
        const Real open = magnitude(command) - o_.idle_command;
        if (!(open > Real(0))) return Real(0);
        const Real share = (command > Real(0) ? supply - reading : reading) / o_.full_drop;
        return open * (share > least ? (share < Real(1) ? share : Real(1)) : least);
    }

    GuardOptions<Real> o_;
    Fault fault_ = Fault::none;
    int32_t not_finite_ = 0, supply_low_ = 0, too_high_ = 0, away_ = 0, open_ = 0;
    Real last_ = Real(0), effort_ = Real(0), code_ = Real(0);
    Real extreme_[2] = {}, sent_[2] = {};  // of the ways down and up
    bool seen_ = false;
};

}  // namespace control
}  // namespace softlimb
