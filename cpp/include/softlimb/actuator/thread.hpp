#pragma once
// A thread wound around a tube in a helix: its angle and its share of the layer that embeds it.
#include <cmath>
#include <numbers>
#include <optional>

#include "softlimb/arguments.hpp"

namespace softlimb::actuator {

struct ThreadGeometry {
    double angle = 0.0;     // from the circumferential direction [rad]
    double fraction = 0.0;  // of the layer's volume, one family
};

/// Thread of a diameter wound at the inner radius of a layer. One turn advances by the pitch p, so tan(angle) =
/// p / (2 pi R_m); over one pitch it has the length 2 pi R_m / cos(angle), and the layer the volume
/// pi (R_o^2 - R_m^2) p:  fraction = (pi d^2 / 4) 2 R_m / (cos(angle) (R_o^2 - R_m^2) p).
/// An angle given overrides that of the pitch (several starts); the pitch is then the axial distance between turns
/// and the length of thread per axial length is 2 pi R_m / (p cos(angle)) all the same.
/// Raises std::invalid_argument.
inline ThreadGeometry thread_geometry(double inner, double outer, double thread_diameter, double pitch,
                                      std::optional<double> angle = std::nullopt) {
    require_positive("inner radius of the threaded layer", inner);
    require_positive("outer radius of the threaded layer", outer);
    if (!(outer > inner)) reject("outer radius of the threaded layer", outer, "larger than its inner radius");
    require_positive("thread_diameter", thread_diameter);
    require_positive("pitch", pitch);
    if (thread_diameter > pitch)
        reject("thread_diameter", thread_diameter, "at most the pitch (the turns would overlap)");
    const double pi = std::numbers::pi;
    const double alpha = angle.value_or(std::atan2(pitch, 2.0 * pi * inner));
    require_finite("fibre angle", alpha);
    if (!(alpha > 0.0 && alpha < 0.5 * pi))
        reject("fibre angle", alpha, "within (0, pi/2) (was it given in degrees? multiply by units.deg)");
    const double section = 0.25 * pi * thread_diameter * thread_diameter;
    const double fraction = section * 2.0 * inner / (std::cos(alpha) * (outer * outer - inner * inner) * pitch);
    if (!(fraction < 0.5))
        reject("volume fraction of one thread family", fraction, "below 0.5 (two families share the layer)");
    return {alpha, fraction};
}

}  // namespace softlimb::actuator
