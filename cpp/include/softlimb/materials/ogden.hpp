#pragma once
#include "softlimb/materials/real_chebyshev.hpp"
#include "softlimb/materials/terms.hpp"

namespace softlimb::materials {

/// W = sum mu_p/alpha_p (l1^alpha_p + l2^alpha_p + l3^alpha_p - 3), shear modulus sum mu_p alpha_p / 2. One to four
/// terms. (Some programs write 2 mu_p/alpha_p^2: there mu_p alpha_p / 2 is what they call mu_p.)
/// Source: R. W. Ogden, Large deformation isotropic elasticity, Proc. R. Soc. Lond. A 326 (1972) 565-584.
struct Ogden {
    static constexpr std::string_view name = "ogden", class_name = "Ogden", shear_modulus_formula = "sum(mu alpha)/2",
                                      summary =
                                          "Ogden's law: W = sum mu_p/alpha_p (l1^alpha_p + l2^alpha_p + "
                                          "l3^alpha_p - 3).";
    static constexpr auto parameters() {
        return std::tuple{Parameter<Ogden, Terms>{"mu", &Ogden::mu, Bound::finite, "Coefficients, one to four [Pa]."},
                          Parameter<Ogden, Terms>{"alpha", &Ogden::alpha, Bound::not_zero,
                                                  "Exponents, as many, not zero, within [-50, 50].", false, false}};
    }

    Terms mu;  // [Pa]
    Terms alpha;
    double density = 1080.0;  // [kg/m^3]
    double max_strain = 0.0;

    bool operator==(const Ogden&) const = default;

    void check_terms() const {
        if (mu.count != alpha.count)
            reject("number of terms in alpha", alpha.count, "that of mu, " + std::to_string(mu.count));
        // Published exponents stay below about 25; twice that keeps powers of any stretch of interest finite.
        constexpr double largest_exponent = 50.0;
        for (int p = 0; p < alpha.count; ++p)
            if (std::abs(alpha[p]) > largest_exponent)
                reject("alpha[" + std::to_string(p) + "]", alpha[p], "within [-50, 50]");
    }

    double shear_modulus() const {
        double sum = 0.0;
        for (int p = 0; p < mu.count; ++p) sum += 0.5 * mu[p] * alpha[p];
        return sum;
    }

    /// The known direction contributes a^q with q = alpha/2, the block h = l1^alpha + l2^alpha = 2 a^(-q/2) T_q(c) with
    /// c = t sqrt(a)/2 and T_q the Chebyshev function of real degree.
    template <class Scalar>
    EnergyDerivatives<Scalar> derivatives(const Scalar& a, const Scalar& t) const {
        using std::pow, std::sqrt;
        const Scalar inverse = 1.0 / a, root = sqrt(a), c = 0.5 * t * root;
        EnergyDerivatives<Scalar> sum{Scalar(0.0), Scalar(0.0), Scalar(0.0), Scalar(0.0), Scalar(0.0), Scalar(0.0)};
        for (int p = 0; p < mu.count; ++p) {
            const double q = 0.5 * alpha[p], weight = mu[p] / alpha[p];
            const Scalar scale = pow(a, -0.5 * q);  // half the factor of the block
            const Scalar power = 1.0 / (scale * scale);
            const auto [value, first, second] = real_chebyshev(q, c);
            const Scalar g = c * first - q * value, g_c = (1.0 - q) * first + c * second;  // a dh/da = scale g
            sum.w += weight * (power + 2.0 * scale * value - 3.0);
            sum.w_a += weight * inverse * (q * power + scale * g);
            sum.w_t += weight * scale * root * first;
            sum.w_aa +=
                weight * inverse * inverse * (q * (q - 1.0) * power + scale * (0.5 * c * g_c - (0.5 * q + 1.0) * g));
            sum.w_at += (0.5 * weight) * inverse * scale * root * g_c;
            sum.w_tt += (0.5 * weight) * a * scale * second;
        }
        return sum;
    }
};

}  // namespace softlimb::materials
