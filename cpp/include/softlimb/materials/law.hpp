#pragma once
// What a material law is. Every law is incompressible and isotropic, and in everything that the package computes one
// principal direction is known beforehand (through the wall of a tube; across a tensile specimen). Its energy density
// is therefore a function of two numbers,
//   a : squared stretch in the known direction,
//   t : trace of the two-by-two block of C = F^T F in the other two directions,
// with  I1 = a + t,  I2 = 1/a + a t,  and the block's determinant 1/a. Writing W(a, t) keeps Ogden's law smooth where
// principal stretches coincide: h(t, D) = l1^p + l2^p is analytic in t at t = 2 sqrt(D).
// Source: cpp/MECHANICS.md, "Material".
//
// A law is an aggregate: its coefficients, then `density` [kg/m^3] and `max_strain`, the largest nominal strain of the
// data it was fitted to (0: not known; it judges a result, it never enters the energy). Outside the domain of its
// formula (Gent past its limit) a law returns NaN in every field, never a finite number.
#include <concepts>
#include <string>
#include <string_view>
#include <tuple>

#include "softlimb/arguments.hpp"

namespace softlimb::materials {

/// Energy density [Pa] and its first and second derivatives in (a, t).
template <class Scalar>
struct EnergyDerivatives {
    Scalar w, w_a, w_t, w_aa, w_at, w_tt;
};

/// Rule that a coefficient obeys on its own; what they obey together is that the shear modulus is positive.
enum class Bound { finite, positive, not_zero };

/// One coefficient of law `L`: its name, where it is stored (`Value` is double or Terms), its bound, its meaning with
/// unit, whether a constructor may leave it out (it is then zero), and whether the energy is linear in it.
template <class L, class Value>
struct Parameter {
    std::string_view name;
    Value L::* member;
    Bound bound;
    std::string_view meaning;
    bool optional = false, linear = true;
};

/// A law has names, a list of parameters, a density, a fit range, a shear modulus [Pa] with its formula as text, and
/// `derivatives(a, t)` for any scalar.
template <class L>
concept MaterialLaw = requires(const L& law, double x) {
    { L::name } -> std::convertible_to<std::string_view>;
    { L::class_name } -> std::convertible_to<std::string_view>;
    { L::summary } -> std::convertible_to<std::string_view>;
    { L::shear_modulus_formula } -> std::convertible_to<std::string_view>;
    L::parameters();
    { law.shear_modulus() } -> std::convertible_to<double>;
    { law.density } -> std::convertible_to<double>;
    { law.max_strain } -> std::convertible_to<double>;
    { law.derivatives(x, x) } -> std::same_as<EnergyDerivatives<double>>;
};

inline void require_bound(std::string_view name, double value, Bound bound) {
    require_finite(name, value);
    if (bound == Bound::positive) require_positive(name, value);
    if (bound == Bound::not_zero && value == 0.0) reject(name, value, "different from zero");
}

/// Raises std::invalid_argument (ValueError) that names the argument, its value and the rule.
template <MaterialLaw L>
void check(const L& law) {
    std::apply(
        [&](const auto&... parameter) { (require_bound(parameter.name, law.*parameter.member, parameter.bound), ...); },
        L::parameters());
    if constexpr (requires { law.check_terms(); }) law.check_terms();
    require_positive("density", law.density);
    require_not_negative("max_strain", law.max_strain);
    require_positive(std::string("initial shear modulus ") + std::string(L::shear_modulus_formula),
                     law.shear_modulus());
}

}  // namespace softlimb::materials
