#pragma once
// What a tube is made of: layers of silicone, each with families of parallel fibres.
#include <vector>

#include "softlimb/materials/laws.hpp"

namespace softlimb::actuator {

/// One family of parallel fibres, spread evenly over its layer. Energy per volume of the layer:
/// k (sqrt(I4) - 1)^2 / 2, where sqrt(I4) is the fibre's stretch.
struct Fibres {
    double angle = 0.0;      // from the circumferential direction, within [-pi/2, pi/2] [rad]
    double stiffness = 0.0;  // k [Pa]: modulus times fraction where those are given
    double modulus = 0.0;    // of the thread [Pa]; 0 when the stiffness was given
    double fraction = 0.0;   // volume of this family over volume of the layer; 0 leaves the silicone whole

    /// The stiffness itself: the silicone is not reduced. Raises std::invalid_argument.
    static Fibres with_stiffness(double angle, double stiffness);
    /// Thread of a modulus that takes a fraction of the layer from the silicone. Raises std::invalid_argument.
    static Fibres with_fraction(double angle, double modulus, double fraction);
    bool operator==(const Fibres&) const = default;
};

struct Layer {
    double inner = 0.0, outer = 0.0;  // undeformed radii [m]
    materials::AnyLaw law;
    std::vector<Fibres> fibres;

    /// Radii, law and fractions checked. Raises std::invalid_argument.
    static Layer make(double inner, double outer, const materials::AnyLaw& law, std::vector<Fibres> fibres);
    /// Part of the layer's volume that is silicone: 1 - sum of fibre fractions.
    double silicone_fraction() const;
    /// Initial shear modulus of the silicone [Pa], area [m^2] and second moment of area [m^4] of the undeformed layer.
    double shear_modulus() const;
    double area() const;
    double second_moment() const;
    double density() const;  // of the silicone [kg/m^3]
    bool operator==(const Layer&) const = default;
};

}  // namespace softlimb::actuator
