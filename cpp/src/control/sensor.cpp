#include "softlimb/control/sensor.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace softlimb::control {

double Noise::uniform() {
    // SplitMix64 (Steele, Lea, Flood 2014).
    state_ += 0x9e3779b97f4a7c15ULL;
    std::uint64_t z = state_;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
    z ^= z >> 31;
    return (static_cast<double>(z >> 11) + 0.5) * 0x1.0p-53;
}

double Noise::normal() {
    // Box and Muller: two at a time.
    has_spare_ = !has_spare_;
    if (!has_spare_) return spare_;
    const double radius = std::sqrt(-2.0 * std::log(uniform())), angle = 2.0 * 3.14159265358979323846 * uniform();
    spare_ = radius * std::sin(angle);
    return radius * std::cos(angle);
}

double Sensor::read(double pressure) {
    double reading = pressure + parameters_.offset + bias + parameters_.noise * noise_.normal();
    if (parameters_.bits > 0) {
        const double span = parameters_.high - parameters_.low, codes = std::ldexp(1.0, parameters_.bits) - 1.0;
        const double share = std::clamp((reading - parameters_.low) / span, 0.0, 1.0);
        reading = parameters_.low + span * std::round(share * codes) / codes;
    }
    if (fault == SensorFault::not_finite) return std::numeric_limits<double>::quiet_NaN();
    if (fault == SensorFault::none) last_ = reading;
    return last_;
}

}  // namespace softlimb::control
