#include "softlimb/control/volume_table.hpp"

#include <algorithm>
#include <cmath>

#include "softlimb/arguments.hpp"

namespace softlimb::control {

VolumeTable::VolumeTable(std::vector<double> pressures, std::vector<double> volumes)
    : pressures_(std::move(pressures)), volumes_(std::move(volumes)), slopes_(pressures_.size()) {
    const std::size_t n = pressures_.size();
    if (n < 2 || volumes_.size() != n) reject("points of a volume table", n, "at least 2, with a volume each");
    for (std::size_t k = 0; k < n; ++k) {
        require_finite("pressure of a volume table", pressures_[k]);
        require_positive("volume of a volume table", volumes_[k]);
        if (k > 0 && !(pressures_[k] > pressures_[k - 1]))
            reject("pressures of a volume table", pressures_[k], "rising");
        if (k > 0 && volumes_[k] < volumes_[k - 1]) reject("volumes of a volume table", volumes_[k], "not falling");
    }
    const auto width = [&](std::size_t k) { return pressures_[k + 1] - pressures_[k]; };
    const auto chord = [&](std::size_t k) { return (volumes_[k + 1] - volumes_[k]) / width(k); };
    // At an end the parabola through the three last points, kept between flat and three times the chord.
    const auto end = [&](std::size_t first, std::size_t second) {
        const double a = width(first), b = width(second), near = chord(first);
        return std::clamp(((2.0 * a + b) * near - a * chord(second)) / (a + b), 0.0, 3.0 * near);
    };
    slopes_.front() = n > 2 ? end(0, 1) : chord(0);
    slopes_.back() = n > 2 ? end(n - 2, n - 3) : chord(0);
    for (std::size_t k = 1; k + 1 < n; ++k) {
        const double before = chord(k - 1), after = chord(k);
        if (before * after <= 0.0) continue;
        // Weighted harmonic mean: at most three times the smaller chord, so that the pieces stay monotone.
        const double a = 2.0 * width(k) + width(k - 1), b = width(k) + 2.0 * width(k - 1);
        slopes_[k] = (a + b) / (a / before + b / after);
    }
}

VolumeTable::Value VolumeTable::at(double pressure) const {
    const std::size_t n = pressures_.size();
    if (pressure <= pressures_.front() || pressure >= pressures_.back()) {
        const std::size_t end = pressure <= pressures_.front() ? 0 : n - 1;
        const double rate = slopes_[end] / volumes_[end];
        const double volume = volumes_[end] * std::exp(rate * (pressure - pressures_[end]));
        return {volume, rate * volume};
    }
    const std::size_t k = std::upper_bound(pressures_.begin(), pressures_.end(), pressure) - pressures_.begin() - 1;
    const double h = pressures_[k + 1] - pressures_[k], t = (pressure - pressures_[k]) / h;
    const double rise = volumes_[k + 1] - volumes_[k], a = h * slopes_[k] - rise, b = rise - h * slopes_[k + 1];
    // Hermite: the chord plus t (1 - t) times what the end slopes differ from it.
    const double bend = (1.0 - t) * a + t * b;
    const double volume = volumes_[k] + t * rise + t * (1.0 - t) * bend;
    const double slope = (rise + (1.0 - 2.0 * t) * bend + t * (1.0 - t) * (b - a)) / h;
    return {volume, slope};
}

}  // namespace softlimb::control
