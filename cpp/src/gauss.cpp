#include "softlimb/gauss.hpp"

#include <cmath>
#include <numbers>

namespace softlimb {

GaussRule gauss_rule(int points) {
    GaussRule rule;
    rule.points = points;
    for (int i = 0; i < points; ++i) {
        // Tricomi's estimate of the root of the Legendre polynomial is close enough for Newton to converge in a few
        // steps for every degree used here.
        double x = std::cos(std::numbers::pi * (i + 0.75) / (points + 0.5)), slope = 1.0;
        for (int step = 0; step < 10; ++step) {
            double previous = 1.0, current = x;
            for (int k = 2; k <= points; ++k) {
                const double next = ((2 * k - 1) * x * current - (k - 1) * previous) / k;
                previous = current;
                current = next;
            }
            slope = points * (x * current - previous) / (x * x - 1.0);
            x -= current / slope;
        }
        rule.node[points - 1 - i] = x;
        rule.weight[points - 1 - i] = 2.0 / ((1.0 - x * x) * slope * slope);
    }
    return rule;
}

}  // namespace softlimb
