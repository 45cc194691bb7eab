#pragma once
#include <limits>

#include "softlimb/dual.hpp"
#include "softlimb/materials/law.hpp"

namespace softlimb::materials {

/// W = -(mu jm / 2) log(1 - (I1 - 3)/jm), shear modulus mu. Chains are fully stretched at I1 - 3 = jm: the stress grows
/// without bound towards it, and at or past it every derivative is NaN.
/// Source: A. N. Gent, A new constitutive relation for rubber, Rubber Chemistry and Technology 69 (1996) 59-61.
struct Gent {
    static constexpr std::string_view name = "gent", class_name = "Gent", shear_modulus_formula = "mu",
                                      summary =
                                          "Gent's law: W = -(mu jm/2) log(1 - (I1 - 3)/jm); "
                                          "NaN at and past I1 - 3 = jm.";
    static constexpr auto parameters() {
        return std::tuple{
            Parameter<Gent, double>{"mu", &Gent::mu, Bound::positive, "Initial shear modulus [Pa], positive."},
            Parameter<Gent, double>{"jm", &Gent::jm, Bound::positive,
                                    "Value of I1 - 3 that no state can reach, positive.", false, false}};
    }

    double mu = 0.0;          // [Pa]
    double jm = 0.0;          // largest I1 - 3
    double density = 1080.0;  // [kg/m^3]
    double max_strain = 0.0;

    bool operator==(const Gent&) const = default;
    double shear_modulus() const { return mu; }

    template <class Scalar>
    EnergyDerivatives<Scalar> derivatives(const Scalar& a, const Scalar& t) const {
        using std::log;
        const Scalar x = a + t - 3.0;
        if (!(value_of(x) < jm)) {
            // As a factor, so that the slopes of a Dual are NaN as well.
            const Scalar nan = x * std::numeric_limits<double>::quiet_NaN();
            return {nan, nan, nan, nan, nan, nan};
        }
        const Scalar gain = 1.0 / (1.0 - x / jm);
        const Scalar first = 0.5 * mu * gain, second = first * gain / jm;
        return {0.5 * mu * jm * log(gain), first, first, second, second, second};
    }
};

}  // namespace softlimb::materials
