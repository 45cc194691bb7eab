#include "softlimb/sweep/trail.hpp"

#include <limits>

namespace softlimb::sweep {

double Trail::behind(const double* other, const double* last, const double* pressures) const {
    double along = 0.0, back = 0.0, ahead = 0.0;
    for (int i = 0; i < actuators_; ++i) {
        const double a = last[i] - other[i], b = pressures[i] - last[i];
        along += a * b, back += a * a, ahead += b * b;
    }
    // Aside by more than a tenth, or so near that it says little of what comes twice as far ahead.
    if (!(along > 0.0) || along * along < 0.99 * back * ahead || ahead > 4.0 * back) return 0.0;
    constexpr double farthest = 4.0;
    const double steps = back / along;
    return steps <= farthest ? steps : 0.0;
}

std::optional<Trail::Lead> Trail::lead(const double* pressures) const {
    if (rows_.empty()) return std::nullopt;
    Lead lead;
    double nearest = std::numeric_limits<double>::infinity();
    for (std::size_t k = rows_.size(); k-- > 0;) {  // of equally near ones the latest
        double square = 0.0;
        for (int i = 0; i < actuators_; ++i) {
            const double away = pressures[i] - rows_[k][i];
            square += away * away;
        }
        if (square < nearest) nearest = square, lead.nearest = k;
    }
    // The two nearest behind it.
    double one = 0.0, two = 0.0;
    for (std::size_t k = rows_.size(); k-- > 0;) {
        const double steps = behind(rows_[k], rows_[lead.nearest], pressures);
        if (steps == 0.0) continue;
        if (lead.others == 0 || steps < one) {
            lead.other[1] = lead.other[0], two = one;
            lead.other[0] = k, one = steps;
            if (lead.others < 2) ++lead.others;
        } else if (lead.others < 2 || steps < two) {
            lead.other[1] = k, two = steps;
            lead.others = 2;
        }
    }
    if (lead.others == 0) return lead;
    lead.straight = lead.weight[0] = -1.0 / one;
    // Rows hardly apart would make a parabola of their errors.
    if (lead.others == 2 && !(two > 1.2 * one)) lead.others = 1;
    if (lead.others == 2) {
        // Lagrange's weights at 1 of a parabola through 0, -one and -two.
        lead.weight[0] = -(1.0 + two) / (one * (two - one)), lead.weight[1] = (1.0 + one) / (two * (two - one));
    }
    return lead;
}

void ShapeTrail::add(const double* pressures, limb::Shape shape) {
    if (trail_.size() == shapes_.size()) shapes_.emplace_back();
    shapes_[trail_.size()] = std::move(shape);
    trail_.add(pressures);
}

const limb::Shape* ShapeTrail::start(const limb::Geometry& geometry, const double* pressures) {
    const std::optional<Trail::Lead> lead = trail_.lead(pressures);
    if (!lead) return nullptr;
    const limb::Shape &nearest = shapes_[lead->nearest], &first = shapes_[lead->other[0]],
                      &second = shapes_[lead->other[1]];
    if (lead->others == 2 &&
        limb::extrapolate(geometry, nearest, {{&first, lead->weight[0]}, {&second, lead->weight[1]}}, ahead_))
        return &ahead_;
    if (lead->others > 0 && limb::extrapolate(geometry, nearest, {{&first, lead->straight}}, ahead_)) return &ahead_;
    return &nearest;
}

void NumberTrail::add(const double* pressures, const std::vector<double>& numbers) {
    if (trail_.size() == numbers_.size()) numbers_.emplace_back();
    numbers_[trail_.size()] = numbers;
    trail_.add(pressures);
}

NumberTrail::Led NumberTrail::start(const limb::Geometry& geometry, const limb::Mesh& mesh, const double* pressures,
                                    std::vector<double>& numbers) const {
    const std::optional<Trail::Lead> lead = trail_.lead(pressures);
    if (!lead) return Led::none;
    const std::vector<double>& nearest = numbers_[lead->nearest];
    numbers = nearest;
    if (lead->others == 0) return Led::nearest;
    for (int k = 0; k < lead->others; ++k) {
        const std::vector<double>& other = numbers_[lead->other[k]];
        const double weight = lead->weight[k];
        for (std::size_t i = 0; i < numbers.size(); ++i) numbers[i] += weight * (other[i] - nearest[i]);
    }
    limb::make_orthonormal(geometry, mesh, numbers.data());
    return Led::on;
}

}  // namespace softlimb::sweep
