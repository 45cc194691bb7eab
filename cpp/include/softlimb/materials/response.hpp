#pragma once
// What a law says in the three homogeneous tests (tension, planar tension, equibiaxial tension), and whether it is
// stable there in Drucker's sense. Source: cpp/MECHANICS.md, "Material".
#include <algorithm>
#include <cmath>
#include <limits>

#include "softlimb/materials/law.hpp"

namespace softlimb::materials {

enum class Test { uniaxial, planar, equibiaxial };

/// Nominal stress [Pa] (force over undeformed area) and its derivative in the stretch [Pa].
struct Response {
    double stress, tangent;
};

/// State of a test at stretch l: W follows a(l), t(l); `share` of dW/dl is the stress in one loaded direction.
struct Path {
    double a, a_l, a_ll, t, t_l, t_ll, share;
};

inline Path path_of(Test test, double l) {
    const double inverse = 1.0 / l, inverse2 = inverse * inverse;
    switch (test) {
        case Test::planar:  // stretches l, 1, 1/l; the held direction is the known one
            return {1.0, 0.0, 0.0, l * l + inverse2, 2.0 * (l - inverse * inverse2), 2.0 + 6.0 * inverse2 * inverse2,
                    1.0};
        case Test::equibiaxial: {  // l, l, 1/l^2; through the thickness is the known direction
            const double inverse4 = inverse2 * inverse2;
            return {inverse4, -4.0 * inverse4 * inverse, 20.0 * inverse4 * inverse2, 2.0 * l * l, 4.0 * l, 4.0, 0.5};
        }
        default:  // l, 1/sqrt(l), 1/sqrt(l); the axis is the known direction
            return {l * l, 2.0 * l, 2.0, 2.0 * inverse, -2.0 * inverse2, 4.0 * inverse2 * inverse, 1.0};
    }
}

template <MaterialLaw L>
Response response(const L& law, Test test, double stretch) {
    const Path s = path_of(test, stretch);
    const EnergyDerivatives<double> e = law.derivatives(s.a, s.t);
    return {s.share * (e.w_a * s.a_l + e.w_t * s.t_l),
            s.share * (e.w_aa * s.a_l * s.a_l + 2.0 * e.w_at * s.a_l * s.t_l + e.w_tt * s.t_l * s.t_l + e.w_a * s.a_ll +
                       e.w_t * s.t_ll)};
}

/// Smallest ratio of d(stress) : d(strain) to 2 mu d(strain) : d(strain) over all increments of logarithmic strain that
/// keep the volume: one in the undeformed state, positive where the law is stable in Drucker's sense, NaN where the law
/// has no value. In the coordinates e1 = log(l1) sqrt(3/2) and e2 = log(l2/l3)/sqrt(2) the strain's square is
/// e1^2 + e2^2, so it is the smallest eigenvalue of the 2x2 Hessian of W over 2 mu.
template <MaterialLaw L>
double drucker_margin(const L& law, Test test, double stretch) {
    const Path s = path_of(test, stretch);
    const double a = s.a, t = s.t;
    const EnergyDerivatives<double> e = law.derivatives(a, t);
    // dt/d log(l2/l3); zero but for rounding where the block's stretches coincide, as they do in two of the tests
    const double t_s = test == Test::planar ? stretch * stretch - 1.0 / (stretch * stretch) : 0.0;
    const double along = 4.0 * a * a * e.w_aa - 4.0 * a * t * e.w_at + t * t * e.w_tt + 4.0 * a * e.w_a + t * e.w_t;
    const double cross = t_s * (2.0 * a * e.w_at - t * e.w_tt - e.w_t);
    const double across = t_s * t_s * e.w_tt + t * e.w_t;
    const double h11 = along / 1.5, h12 = cross / std::sqrt(0.75), h22 = across / 0.5;
    const double smallest = 0.5 * (h11 + h22) - std::hypot(0.5 * (h11 - h22), h12);
    return smallest / (2.0 * law.shear_modulus());
}

/// Where a law is stable: `stable` over the whole range of all three tests, or first lost at `strain` of `test`.
struct DruckerCheck {
    bool stable = true;
    double max_strain = 0.0;     // range that was checked
    double margin = 1.0;         // smallest margin met; NaN when the law has no value somewhere
    Test test = Test::uniaxial;  // where stability is lost at the smallest strain
    double strain = 0.0;         // that nominal strain; NaN when stable
};

/// Looks at nominal strains 0..max_strain of the three tests. 400 points a test: a loss narrower than a 400th of the
/// range could pass unseen; the strain of a loss that is seen is refined by bisection to 1e-10.
template <MaterialLaw L>
DruckerCheck check_drucker(const L& law, double max_strain) {
    constexpr int points = 400;
    DruckerCheck result;
    result.max_strain = max_strain;
    result.strain = std::numeric_limits<double>::quiet_NaN();
    for (const Test test : {Test::uniaxial, Test::planar, Test::equibiaxial}) {
        for (int i = 0; i <= points; ++i) {
            const double strain = max_strain * i / points;
            const double margin = drucker_margin(law, test, 1.0 + strain);
            if (std::isnan(margin) || margin < result.margin) result.margin = margin;
            if (margin > 0.0) continue;
            double safe = max_strain * std::max(i - 1, 0) / points, lost = strain;
            while (lost - safe > 1e-10 * (1.0 + lost)) {
                const double middle = 0.5 * (safe + lost);
                (drucker_margin(law, test, 1.0 + middle) > 0.0 ? safe : lost) = middle;
            }
            if (result.stable || lost < result.strain) result.test = test, result.strain = lost;
            result.stable = false;
            break;
        }
    }
    return result;
}

}  // namespace softlimb::materials
