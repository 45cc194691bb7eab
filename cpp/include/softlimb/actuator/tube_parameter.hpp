#pragma once
// The numbers that a tube is made of, one by one, for derivatives to them. Source: cpp/MECHANICS.md, "Derivatives".
#include "softlimb/section.hpp"

namespace softlimb::actuator {

struct TubeParameter {
    enum class Kind {
        pressure,     // [Pa]
        length,       // [m]; the mass that follows from densities goes with it
        mass,         // [kg], where it was given
        cap_length,   // [m]
        radius,       // `number`: the face, 0 inside [m]
        angle,        // `layer`, `number`: the family [rad]
        fraction,     // the same, where modulus and fraction were given; the silicone gives way
        modulus,      // the same [Pa]
        stiffness,    // the same, where it was given itself [Pa]
        coefficient,  // `layer`, `number`: of its law, in the order of materials/coefficients.hpp
        density,      // `layer` [kg/m^3]; no effect where the mass was given
    };
    Kind kind = Kind::pressure;
    int layer = 0, number = 0;
    int twin = -1;  // another family of the layer that changes as much, its angle the other way

    bool operator==(const TubeParameter&) const = default;
};

/// Derivative of a tube's section and rest length to one of its parameters, field by field; of the axial law a
/// law whose strain at a given force is the derivative of the strain (its centre and half range are the same).
struct SectionSlope {
    double rest_length = 0.0;
    Section section{};
};

}  // namespace softlimb::actuator
