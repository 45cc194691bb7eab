#pragma once
// Air in a volume and through an orifice. Absolute pressures. MECHANICS, "Control".
#include <cmath>

namespace softlimb::control {

/// p = p_a (rho / rho_a)^n: n = 1 isothermal, n = 1.4 adiabatic from the atmosphere.
struct Gas {
    double exponent = 1.2;         // assumption: fills of a second exchange some of their heat
    double atmosphere = 101325.0;  // [Pa], standard atmosphere
    double temperature = 293.15;   // of the room [K], as ISO 8778 has its reference atmosphere
    double constant = 287.05;      // dry air [J/(kg K)]
    double viscosity = 1.82e-5;    // air at 20 C [Pa s]

    double density_at_atmosphere() const { return atmosphere / (constant * temperature); }
    double density(double pressure) const {
        return density_at_atmosphere() * std::pow(pressure / atmosphere, 1.0 / exponent);
    }
    /// d density / d pressure, where the density is known.
    double density_slope(double pressure, double density) const { return density / (exponent * pressure); }
    double pressure(double density) const { return atmosphere * std::pow(density / density_at_atmosphere(), exponent); }
};

/// A mass flow [kg/s] and its derivatives to the pressures at both ends.
struct Flow {
    double rate = 0.0, d_first = 0.0, d_second = 0.0;
};

inline constexpr double kReferenceDensity = 1.185;  // of air at 100 kPa, 20 C, 65 % humidity [kg/m^3], ISO 8778
inline constexpr double kLaminarRatio = 0.999;      // beyond it the flow is linear: the root's slope is infinite at 1

/// ISO 6358: sonic conductance C [m^3/(s Pa)], critical pressure ratio b; choked below b, an ellipse above it, linear
/// from 0.999 on. Positive from the first end to the second. Air upstream counts as at room temperature.
Flow orifice(double conductance, double critical_ratio, double first, double second);

/// Laminar flow of an isothermal gas through a round line: factor (p1^2 - p2^2), Hagen and Poiseuille.
inline Flow laminar(double factor, double first, double second) {
    return {factor * (first * first - second * second), 2.0 * factor * first, -2.0 * factor * second};
}

}  // namespace softlimb::control
