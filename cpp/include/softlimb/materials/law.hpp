#pragma once
// What a material law is. Every law is incompressible and isotropic, and in everything that the package computes one
// principal direction is known beforehand (through the wall of a tube; across a tensile specimen). Its energy density
// is therefore a function of two numbers,
//   a : squared stretch in the known direction,
//   t : trace of the two-by-two block of C = F^T F in the other two directions,
// with  I1 = a + t,  I2 = 1/a + a t,  and the block's determinant 1/a. Writing W(a, t) keeps Ogden's law smooth where
// principal stretches coincide: h(t, D) = l1^p + l2^p is analytic in t at t = 2 sqrt(D).
// Source: cpp/MECHANICS.md, "Material".
#include <concepts>
#include <string_view>

namespace softlimb::materials {

/// Energy density [Pa] and its first and second derivatives in (a, t).
template <class Scalar>
struct EnergyDerivatives {
    Scalar w, w_a, w_t, w_aa, w_at, w_tt;
};

/// A law has a name, an initial shear modulus [Pa], a density [kg/m^3] and `derivatives(a, t)` for any scalar.
template <class L>
concept MaterialLaw = requires(const L& law, double x) {
    { L::name } -> std::convertible_to<std::string_view>;
    { law.shear_modulus() } -> std::convertible_to<double>;
    { law.density } -> std::convertible_to<double>;
    { law.derivatives(x, x) } -> std::same_as<EnergyDerivatives<double>>;
};

}  // namespace softlimb::materials
