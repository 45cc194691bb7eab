#include "softlimb/sweep/trail.hpp"

#include <algorithm>
#include <limits>

namespace softlimb::sweep {

void Trail::add(const double* pressures, limb::Shape shape) {
    if (count_ == rows_.size()) rows_.emplace_back();
    rows_[count_].pressures = pressures;
    rows_[count_].shape = std::move(shape);
    ++count_;
}

double Trail::behind(const Row& other, const Row& last, const double* pressures) const {
    double along = 0.0, back = 0.0, ahead = 0.0;
    for (int i = 0; i < actuators_; ++i) {
        const double a = last.pressures[i] - other.pressures[i], b = pressures[i] - last.pressures[i];
        along += a * b, back += a * a, ahead += b * b;
    }
    // Aside by more than a tenth, or so near that it says little of what comes twice as far ahead.
    if (!(along > 0.0) || along * along < 0.99 * back * ahead || ahead > 4.0 * back) return 0.0;
    constexpr double farthest = 4.0;
    const double steps = back / along;
    return steps <= farthest ? steps : 0.0;
}

const limb::Shape* Trail::start(const limb::Geometry& geometry, const double* pressures) {
    const Row* last = nullptr;
    double nearest = std::numeric_limits<double>::infinity();
    for (std::size_t k = count_; k-- > 0;) {  // of equally near ones the latest
        double square = 0.0;
        for (int i = 0; i < actuators_; ++i) {
            const double away = pressures[i] - rows_[k].pressures[i];
            square += away * away;
        }
        if (square < nearest) nearest = square, last = &rows_[k];
    }
    if (!last) return nullptr;
    // The two nearest behind it.
    const Row *first = nullptr, *second = nullptr;
    double one = 0.0, two = 0.0;
    for (std::size_t k = count_; k-- > 0;) {
        const double steps = behind(rows_[k], *last, pressures);
        if (steps == 0.0) continue;
        if (!first || steps < one) {
            second = first, two = one;
            first = &rows_[k], one = steps;
        } else if (!second || steps < two) {
            second = &rows_[k], two = steps;
        }
    }
    if (!first) return &last->shape;
    // Rows hardly apart would make a parabola of their errors.
    if (second && two > 1.2 * one) {
        // Lagrange's weights at 1 of a parabola through 0, -one and -two.
        const double of_first = -(1.0 + two) / (one * (two - one)), of_second = (1.0 + one) / (two * (two - one));
        if (limb::extrapolate(geometry, last->shape, {{&first->shape, of_first}, {&second->shape, of_second}}, ahead_))
            return &ahead_;
    }
    if (limb::extrapolate(geometry, last->shape, {{&first->shape, -1.0 / one}}, ahead_)) return &ahead_;
    return &last->shape;
}

}  // namespace softlimb::sweep
