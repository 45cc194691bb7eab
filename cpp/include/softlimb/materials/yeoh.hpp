#pragma once
#include "softlimb/materials/law.hpp"

namespace softlimb::materials {

/// W = c1 (I1 - 3) + c2 (I1 - 3)^2 + c3 (I1 - 3)^3, shear modulus 2 c1. c2 and c3 may be negative.
struct Yeoh {
    static constexpr std::string_view name = "yeoh", class_name = "Yeoh", shear_modulus_formula = "2 c1",
                                      summary = "Yeoh's law: W = c1 (I1 - 3) + c2 (I1 - 3)^2 + c3 (I1 - 3)^3.";
    static constexpr auto parameters() {
        return std::tuple{
            Parameter<Yeoh, double>{"c1", &Yeoh::c1, Bound::positive, "Half the initial shear modulus [Pa], positive."},
            Parameter<Yeoh, double>{"c2", &Yeoh::c2, Bound::finite, "Coefficient of (I1 - 3)^2 [Pa]."},
            Parameter<Yeoh, double>{"c3", &Yeoh::c3, Bound::finite, "Coefficient of (I1 - 3)^3 [Pa].", true}};
    }

    double c1 = 0.0, c2 = 0.0, c3 = 0.0;  // [Pa]
    double density = 1080.0;              // [kg/m^3]
    double max_strain = 0.0;

    bool operator==(const Yeoh&) const = default;
    double shear_modulus() const { return 2.0 * c1; }

    template <class Scalar>
    EnergyDerivatives<Scalar> derivatives(const Scalar& a, const Scalar& t) const {
        const Scalar x = a + t - 3.0;
        const Scalar first = c1 + x * (2.0 * c2 + 3.0 * c3 * x), second = 2.0 * c2 + 6.0 * c3 * x;
        return {x * (c1 + x * (c2 + c3 * x)), first, first, second, second, second};
    }
};

}  // namespace softlimb::materials
