#pragma once
#include "softlimb/materials/law.hpp"

namespace softlimb::materials {

/// W = c1 (I1 - 3) + c2 (I1 - 3)^2 + c3 (I1 - 3)^3, shear modulus 2 c1.
struct Yeoh {
    static constexpr std::string_view name = "yeoh";
    double c1 = 0.0, c2 = 0.0, c3 = 0.0;  // [Pa]
    double density = 1080.0;              // [kg/m^3]

    double shear_modulus() const { return 2.0 * c1; }

    template <class Scalar>
    EnergyDerivatives<Scalar> derivatives(const Scalar& a, const Scalar& t) const {
        const Scalar x = a + t - 3.0;
        const Scalar first = c1 + x * (2.0 * c2 + 3.0 * c3 * x), second = 2.0 * c2 + 6.0 * c3 * x;
        return {x * (c1 + x * (c2 + c3 * x)), first, first, second, second, second};
    }
};

}  // namespace softlimb::materials
