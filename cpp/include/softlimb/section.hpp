#pragma once
// What an actuator hands to a rod: stiffnesses per rest length, the mass, and the axial law.
// Source: cpp/MECHANICS.md, "Section". Shared by `actuator` (which makes it) and `rod` (which uses it).
#include <array>
#include <cmath>

#include "softlimb/always_inline.hpp"
#include "softlimb/dual.hpp"

namespace softlimb {

/// Axial law of a rod without end moment: stretch v3 as a smooth function of the axial force n3 [N].
///
///   v3 = 1 + n3 g(x),   g = c0 + c1 x + ... + cd x^d,   x = (n3 - centre) / half_range,   |x| <= 1
///
/// so v3(0) = 1 exactly. Outside the range the curve goes on as its second-order Taylor polynomial at the end of the
/// range. Degree zero with c0 = 1/EA is the linear law. The complementary energy is the integral of v3 - 1, so the
/// law is conservative whatever the coefficients.
struct AxialLaw {
    static constexpr int max_degree = 15;
    int degree = 0;
    double centre = 0.0;                               // [N]
    double half_range = 0.0;                           // [N]; none where the law is linear
    std::array<double, max_degree + 1> coefficient{};  // [1/N]

    bool linear() const { return degree == 0; }
    bool covers(double force) const { return degree == 0 || std::abs(force - centre) <= half_range; }
    bool operator==(const AxialLaw&) const = default;
};

/// Strain v3 - 1 and its derivative d v3 / d n3 [1/N] at the axial force n3 [N], without end moment. Outside the
/// law's range both continue as the second-order Taylor polynomial of the strain at the end of the range, so the
/// strain and its first two derivatives are continuous. `S` is double or a dual number.
template <class S>
inline void axial_strain(const AxialLaw& law, const S& force, S& strain, S& compliance) {
    const auto& c = law.coefficient;
    if (law.degree == 0) {
        compliance = S(c[0]);
        strain = force * c[0];
        return;
    }
    const double per_range = 1.0 / law.half_range;
    const double where = (value_of(force) - law.centre) * per_range;
    if (std::abs(where) <= 1.0) {
        const S x = (force - law.centre) * per_range;
        S g(c[law.degree]), dg(0.0);
        for (int i = law.degree; i-- > 0;) {
            dg = dg * x + g;
            g = g * x + c[i];
        }
        strain = force * g;
        compliance = g + force * dg * per_range;
        return;
    }
    const double x = where > 0.0 ? 1.0 : -1.0, end = law.centre + x * law.half_range;
    double g = c[law.degree], dg = 0.0, half_ddg = 0.0;
    for (int i = law.degree; i-- > 0;) {
        half_ddg = half_ddg * x + dg;
        dg = dg * x + g;
        g = g * x + c[i];
    }
    const double slope = g + end * dg * per_range;
    const double curvature = 2.0 * per_range * (dg + end * half_ddg * per_range);
    const S beyond = force - end;
    strain = end * g + beyond * (slope + 0.5 * curvature * beyond);
    compliance = slope + curvature * beyond;
}

/// Relative growth of a law's range at a rate of the law. Ranges grow from zero force: the centre moves along.
SOFTLIMB_ALWAYS_INLINE double range_growth(const AxialLaw& law, const AxialLaw& rate) {
    return law.degree == 0 ? 0.0 : rate.half_range / law.half_range;
}

/// Rates of strain and compliance at a rate of the law, field by field, while the force stays: what the coefficients
/// make of them, and as x stays where the force grows with the range, the growth times (strain - n3 compliance), inside
/// the range and outside.
inline void axial_strain_rate(const AxialLaw& law, const AxialLaw& rate, double force, double& strain,
                              double& compliance) {
    AxialLaw by_coefficients = law;
    by_coefficients.coefficient = rate.coefficient;
    axial_strain(by_coefficients, force, strain, compliance);
    Dual<1> along, slope;  // as the force grows
    axial_strain(law, Dual<1>::variable(force, 0), along, slope);
    const double growth = range_growth(law, rate);
    strain += growth * (along.value - force * slope.value);
    compliance -= growth * force * slope.slope[0];
}

/// Transversely isotropic section, SI, per *rest* length. n = R diag(GA, GA, EA) (v - v*), m = R diag(EI, EI, GJ)
/// (u - u*), v* = (0,0,1), u* = (0,0,rest_twist). Where extension and twist are coupled,
///   v3 - 1 = n3/EA + extension_twist m3,   u3 - u3* = extension_twist n3 + m3/GJ,
/// that is, `axial` and `torsion` are the inverses of the diagonal compliances.
struct Section {
    double axial = 0.0;            // EA [N]
    double shear = 0.0;            // GA [N]
    double bending = 0.0;          // EI [N m^2]
    double torsion = 0.0;          // GJ [N m^2]
    double mass_per_length = 0.0;  // [kg/m]
    double rest_twist = 0.0;       // u3* [rad/m]
    double extension_twist = 0.0;  // c12 [1/(N m)]
    double stretch = 1.0;          // rest length over reference length, lz(P): only for judging a law's range
    double largest_stretch = 0.0;  // lz v3 beyond which a material law leaves its range; 0: not known
    AxialLaw axial_law{};          // degree 0: linear with 1/EA

    bool operator==(const Section&) const = default;
    /// Raises std::invalid_argument: not finite, a stiffness not positive, a negative mass, or a coupling so strong
    /// that the section loses positive definiteness (extension_twist^2 EA GJ >= 1).
    void check() const;
    /// Linear section with all checks done.
    static Section make(double axial, double shear, double bending, double torsion, double mass_per_length,
                        double rest_twist, double extension_twist);
};

}  // namespace softlimb
