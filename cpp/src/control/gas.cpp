#include "softlimb/control/gas.hpp"

namespace softlimb::control {

Flow orifice(double conductance, double critical_ratio, double first, double second) {
    if (first < second) {
        const Flow back = orifice(conductance, critical_ratio, second, first);
        return {-back.rate, -back.d_second, -back.d_first};
    }
    const double choked = conductance * kReferenceDensity, ratio = second / first, room = 1.0 - critical_ratio;
    if (ratio <= critical_ratio) return {choked * first, choked, 0.0};
    if (ratio <= kLaminarRatio) {
        const double x = (ratio - critical_ratio) / room, root = std::sqrt(1.0 - x * x);
        const double slope = -x / (root * room);  // d root / d ratio
        return {choked * first * root, choked * (root - ratio * slope), choked * slope};
    }
    const double x = (kLaminarRatio - critical_ratio) / room;
    const double factor = choked * std::sqrt(1.0 - x * x) / (1.0 - kLaminarRatio);
    return {factor * (first - second), factor, -factor};
}

}  // namespace softlimb::control
