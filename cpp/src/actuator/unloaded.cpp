#include "softlimb/actuator/unloaded.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <type_traits>

namespace softlimb::actuator {
namespace {

using Curves = Piecewise<9>;

Curves::Values numbers_of(const UnloadedState<double>& s) {
    return {s.shape.stretch, s.shape.volume, s.shape.twist, s.open.ll,  s.open.lt,
            s.open.tt,       s.locked.ll,    s.locked.lt,   s.locked.tt};
}

/// The inverse, of as many numbers as there are.
template <class S, std::size_t count>
void put(const std::array<S, count>& n, UnloadedState<S>& state) {
    state.shape = {n[0], n[1], n[2]};
    if constexpr (count > 3) state.open = {n[3], n[4], n[5]};
    if constexpr (count > 6) state.locked = {n[6], n[7], n[8]};
}

/// Calls `get` with how many numbers a part has.
template <class Get>
bool of_part(UnloadedTable::Part part, Get&& get) {
    using enum UnloadedTable::Part;
    if (part == shape) return get(std::integral_constant<std::size_t, 3>{});
    if (part == open) return get(std::integral_constant<std::size_t, 6>{});
    return get(std::integral_constant<std::size_t, 9>{});
}

// Digits that an interpolation keeps; the solves behind it have one or two more.
constexpr double relative = 2e-13;

/// How far a table may be from a state. What is left of a stiffness after condensing is known to the rounding of the
/// fibres' stiffness only, which may be a million times as large.
Curves::Values allowed_at(const WallEnergy<double>& e, const UnloadedState<double>& s) {
    const double rounding = std::numeric_limits<double>::epsilon();
    const double all = std::abs(e.h_ll) + std::abs(e.h_ww) + std::abs(e.h_tt);
    const double shape = relative, ll = std::max(relative * s.open.ll, rounding * all);
    const double tt = std::max(relative * s.open.tt, rounding * all), lt = std::sqrt(ll * tt);
    return {shape, shape, shape, ll, lt, tt, relative * all, relative * all, relative * all};
}

}  // namespace

UnloadedTable::UnloadedTable(const Wall& wall, Freedom free, double pressure_scale, const Path& path) {
    // Three times what the reference limb is made for; the path goes on to where nothing is left of a tube.
    constexpr double largest_pressure = 300.0;  // of the pressure scale
    // A smooth tube takes fifty to a hundred. What takes more is solved for when it is asked.
    constexpr int most_samples = 300;
    // The finer points change the energy by what the fewer ones miss: a corner, if a small one.
    double end = path.last().pressure;
    if (wall.strained(path.last().shape)) {
        double low = 0.0;
        while (end - low > 1e-3 * end) {
            const double middle = 0.5 * (low + end);
            (wall.strained(path.guess(middle)) ? end : low) = middle;
        }
        end = low;
    }
    end = std::min(end, largest_pressure * pressure_scale);
    curves_.fit(0.0, end, most_samples, [&](double pressure, const Curves::Values* near, Curves::Sample& sample) {
        const Shape<double> start = near ? Shape<double>{(*near)[0], (*near)[1], (*near)[2]} : path.guess(pressure);
        const Equilibrium at = relax(wall, {0.0, pressure, 0.0}, start, free);
        if (!at.converged() || !at.stable || wall.strained(at.shape)) return false;
        // Once more at the very shape: `at` has the energy from before its last step.
        const WallEnergy<double> e = wall.energy(at.shape);
        const UnloadedState<double> state = unloaded_state(e, at.shape);
        sample.value = numbers_of(state), sample.allowed = allowed_at(e, state);
        return true;
    });
}

bool UnloadedTable::at(double pressure, Part part, UnloadedState<double>& state) const {
    return of_part(part, [&](auto count) {
        std::array<double, count> numbers;
        if (!curves_.at(pressure, numbers)) return false;
        put(numbers, state);
        return true;
    });
}

bool UnloadedTable::at(double pressure, Part part, UnloadedState<Dual<1>>& state) const {
    return of_part(part, [&](auto count) {
        std::array<double, count> numbers, slopes;
        if (!curves_.at(pressure, numbers, slopes)) return false;
        std::array<Dual<1>, count> moving;
        for (std::size_t i = 0; i < count; ++i) moving[i] = {numbers[i], {slopes[i]}};
        put(moving, state);
        return true;
    });
}

}  // namespace softlimb::actuator
