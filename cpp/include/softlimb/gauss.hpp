#pragma once
// Gauss-Legendre quadrature on [-1, 1].
#include <array>

namespace softlimb {

struct GaussRule {
    static constexpr int max_points = 32;
    int points = 0;
    std::array<double, max_points> node{}, weight{};
};

/// The rule with `points` points (1 to max_points), exact to rounding for polynomials of degree 2 points - 1.
GaussRule gauss_rule(int points);

}  // namespace softlimb
