#pragma once
// cosh(q arccosh c) as a function of c: the Chebyshev polynomial T_q(c) continued to real degree q. It is what makes a
// sum of powers of two stretches, l1^p + l2^p, a smooth function of trace and determinant of their block.
// Source: cpp/MECHANICS.md, "Material".
#include <algorithm>
#include <cmath>
#include <limits>

#include "softlimb/dual.hpp"

namespace softlimb::materials {

/// Value and first two derivatives in c.
template <class Scalar>
struct RealChebyshev {
    Scalar value, first, second;
};

/// For c >= 1 (a block with real stretches has no other c; rounding may put it slightly below). Relative errors near
/// 1e-14 for 0.1 <= |q| <= 15, at c = 1 and around it too, also of the derivatives that a Dual carries; a smaller
/// |q| loses 1/|q| of them for c > 1.25. NaN for c < 0.75.
template <class Scalar>
RealChebyshev<Scalar> real_chebyshev(double q, const Scalar& c) {
    using std::pow, std::sqrt;
    // Where the two forms change over. The closed form loses a factor 1/(c^2 - 1) in the second derivative, and the
    // series needs the more terms the larger c is: at 1.25 (stretches in the ratio 2) that is one bit against 18 terms.
    constexpr double largest_series_argument = 0.125;

    const Scalar y = 0.5 * (c - 1.0);
    const double size = std::abs(value_of(y));
    if (size <= largest_series_argument) {
        // sum a_n y^n with a_(n+1) = a_n (q^2 - n^2) / ((n + 1/2)(n + 1)). A Dual also carries the third derivative,
        // whose terms are n^3 |a_n| |y|^(n-3) at most: the sum ends when those no longer count.
        constexpr int most_terms = 100;
        Scalar value(1.0), first(0.0), second(0.0), two_below(0.0), below(1.0);  // y^(n-2), y^(n-1)
        double a = 2.0 * q * q, power = 1.0, largest = 0.0;
        for (int n = 1; n <= most_terms; ++n) {
            const double weight = n;
            value += a * (below * y);
            first += (0.5 * weight * a) * below;
            second += (0.25 * weight * (weight - 1.0) * a) * two_below;
            if (n >= 3) {
                const double term = weight * weight * weight * std::abs(a) * power;
                if (term <= 1e-17 * largest || a == 0.0) break;
                largest = std::max(largest, term);
                power *= size;
            }
            a *= (q * q - weight * weight) / ((weight + 0.5) * (weight + 1.0));
            two_below = below;
            below = below * y;
        }
        return {value, first, second};
    }
    if (!(value_of(c) > 1.0)) {
        const Scalar nan = c * std::numeric_limits<double>::quiet_NaN();  // a factor: NaN slopes of a Dual as well
        return {nan, nan, nan};
    }
    const Scalar root_squared = c * c - 1.0, root = sqrt(root_squared);
    const Scalar growth = pow(c + root, q), decay = 1.0 / growth;
    const Scalar value = 0.5 * (growth + decay), first = q * (growth - decay) / (2.0 * root);
    return {value, first, (q * q * value - c * first) / root_squared};
}

}  // namespace softlimb::materials
