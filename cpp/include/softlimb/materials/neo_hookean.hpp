#pragma once
#include "softlimb/materials/law.hpp"

namespace softlimb::materials {

/// W = c1 (I1 - 3), so the shear modulus is 2 c1.
struct NeoHookean {
    static constexpr std::string_view name = "neo-hooke", class_name = "NeoHookean", shear_modulus_formula = "2 c1",
                                      summary = "Neo-Hookean law: W = c1 (I1 - 3).";
    static constexpr auto parameters() {
        return std::tuple{Parameter<NeoHookean, double>{"c1", &NeoHookean::c1, Bound::positive,
                                                        "Half the shear modulus [Pa], positive."}};
    }

    double c1 = 0.0;          // [Pa]
    double density = 1080.0;  // [kg/m^3]
    double max_strain = 0.0;

    bool operator==(const NeoHookean&) const = default;
    double shear_modulus() const { return 2.0 * c1; }

    template <class Scalar>
    EnergyDerivatives<Scalar> derivatives(const Scalar& a, const Scalar& t) const {
        return {c1 * (a + t - 3.0), Scalar(c1), Scalar(c1), Scalar(0.0), Scalar(0.0), Scalar(0.0)};
    }
};

}  // namespace softlimb::materials
