#pragma once
#include "softlimb/materials/law.hpp"

namespace softlimb::materials {

/// W = c10 (I1 - 3) + c01 (I2 - 3), shear modulus 2 (c10 + c01). Either coefficient may be negative.
struct MooneyRivlin {
    static constexpr std::string_view name = "mooney-rivlin", class_name = "MooneyRivlin",
                                      shear_modulus_formula = "2 (c10 + c01)",
                                      summary = "Mooney-Rivlin law: W = c10 (I1 - 3) + c01 (I2 - 3).";
    static constexpr auto parameters() {
        return std::tuple{
            Parameter<MooneyRivlin, double>{"c10", &MooneyRivlin::c10, Bound::finite, "Coefficient of I1 - 3 [Pa]."},
            Parameter<MooneyRivlin, double>{"c01", &MooneyRivlin::c01, Bound::finite, "Coefficient of I2 - 3 [Pa]."}};
    }

    double c10 = 0.0, c01 = 0.0;  // [Pa]
    double density = 1080.0;      // [kg/m^3]
    double max_strain = 0.0;

    bool operator==(const MooneyRivlin&) const = default;
    double shear_modulus() const { return 2.0 * (c10 + c01); }

    template <class Scalar>
    EnergyDerivatives<Scalar> derivatives(const Scalar& a, const Scalar& t) const {
        const Scalar inverse = 1.0 / a;
        return {c10 * (a + t - 3.0) + c01 * (inverse + a * t - 3.0),
                c10 + c01 * (t - inverse * inverse),
                c10 + c01 * a,
                2.0 * c01 * inverse * inverse * inverse,
                Scalar(c01),
                Scalar(0.0)};
    }
};

}  // namespace softlimb::materials
