#include "softlimb/control/valve.hpp"

#include <algorithm>
#include <cmath>

namespace softlimb::control {

Valve::Valve(const ValveParameters& parameters, double step)
    : parameters_(parameters),
      share_(parameters.time_constant > 0.0 ? -std::expm1(-step / parameters.time_constant) : 1.0),
      waiting_(static_cast<std::size_t>(std::lround(parameters.dead_time / step)), 0.0) {}

double Valve::advance(double command) {
    double arrived = command >= -1.0 ? std::min(command, 1.0) : -1.0;  // NaN exhausts
    if (!waiting_.empty()) {
        std::swap(arrived, waiting_[next_]);
        next_ = (next_ + 1) % waiting_.size();
    }
    const double half = 0.5 * parameters_.hysteresis;
    played_ = std::clamp(played_, arrived - half, arrived + half);
    if (!stuck) spool_ += share_ * (played_ - spool_);
    return opening();
}

double Valve::opening() const {
    const double beyond = std::abs(spool_) - parameters_.dead_band;
    return beyond > 0.0 ? std::copysign(beyond / (1.0 - parameters_.dead_band), spool_) : 0.0;
}

}  // namespace softlimb::control
