// What a search that moves along postures needs of an equilibrium: one Newton step, and where the whole limb goes when
// its rods change.
#include <algorithm>
#include <cmath>
#include <limits>

#include "softlimb/limb/equilibrium.hpp"

namespace softlimb::limb {

double Equilibrium::step_to_balance(Shape& shape) {
    if (!linearise_at(shape)) return std::numeric_limits<double>::infinity();
    const Scales scales = scales_at(shape);
    const double residual = relative_residual(shape, scales);
    propose(shape);
    const double size = step_now(scales).size;
    if (!std::isfinite(size)) return std::numeric_limits<double>::infinity();
    const double factor = bounded_factor(shape, NewtonSettings{}.largest_turn);
    apply(geometry_, moves_, factor, shape);
    // The square of the step, or that of the imbalance where stiff rods make much of a small move: on random steps of
    // the reference limb 0.1 to 0.7 of it were left.
    return factor == 1.0 ? std::max(size * size, 0.5 * residual * residual) : std::numeric_limits<double>::infinity();
}

const Moves& Equilibrium::moves_with_rods(const Shape& shape, const std::vector<double>& amounts) {
    for (std::size_t i = 0; i < shape.rods.size(); ++i)
        for (int e = 0; e < shape.rods[i].elements(); ++e) {
            const rod::EndSlope& slope = end_slopes_[i][e];
            gaps_[i][e] = amounts[i] * slope.pose;
            const Vector6 change = exact_[i][e].wrench_for_gap(gaps_[i][e]);
            loads_[i][e] << -change, amounts[i] * slope.wrench + exact_[i][e].end_wrench_by_base_wrench() * change;
        }
    for (int j = 0; j < geometry_.plates(); ++j) {
        plate_forces_[j].setZero();
        hold_rows_[j].setZero();
    }
    respond_to_gaps(shape);
    return moves_;
}

}  // namespace softlimb::limb
