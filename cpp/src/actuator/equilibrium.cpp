#include "softlimb/actuator/equilibrium.hpp"

#include <algorithm>
#include <cmath>

namespace softlimb::actuator {

using solve::SolveStatus;

Factor::Factor(const WallEnergy<double>& e, Freedom free, double shift) {
    const double ll = free.stretch ? e.h_ll + shift : 1.0, ww = free.volume ? e.h_ww + shift : 1.0;
    const double tt = free.twist ? e.h_tt + shift : 1.0;
    const double lw = free.stretch && free.volume ? e.h_lw : 0.0;
    const double lt = free.stretch && free.twist ? e.h_lt : 0.0;
    const double wt = free.volume && free.twist ? e.h_wt : 0.0;
    d_l = ll;
    wl = lw / d_l, tl = lt / d_l;
    d_w = ww - wl * lw;
    tw = (wt - tl * lw) / d_w;
    d_t = tt - tl * lt - tw * tw * d_w;
    positive = d_l > 0.0 && d_w > 0.0 && d_t > 0.0;
}

void Factor::solve(double& l, double& w, double& t) const {
    w -= wl * l;
    t -= tl * l + tw * w;
    l /= d_l, w /= d_w, t /= d_t;
    w -= tw * t;
    l -= wl * w + tl * t;
}

namespace {

bool finite(const WallEnergy<double>& e) {
    return std::isfinite(e.value + e.g_l + e.g_w + e.g_t + e.h_ll + e.h_lw + e.h_lt + e.h_ww + e.h_wt + e.h_tt);
}

double potential(const WallEnergy<double>& e, const WallLoads& loads, const Shape<double>& q) {
    return e.value - loads.force * q.stretch - loads.pressure * q.volume - loads.torque * q.twist;
}

// Below this step the energies differ by rounding only: comparing them would reject good steps.
constexpr double too_small_to_compare = 1e-5;

}  // namespace

Equilibrium relax(const Wall& wall, const WallLoads& loads, const Shape<double>& start, Freedom free,
                  double last_step) {
    constexpr int max_iterations = 60;
    Equilibrium at{start, wall.energy(start)};
    if (!finite(at.energy)) {
        at.status = SolveStatus::not_finite;
        return at;
    }
    for (at.iterations = 1; at.iterations <= max_iterations; ++at.iterations) {
        const WallEnergy<double>& e = at.energy;
        Factor factor(e, free);
        at.stable = factor.positive;
        // Far from a minimum the Hessian may be indefinite; a shift makes the step a descent again.
        for (double shift = 1e-3 * (std::abs(e.h_ll) + std::abs(e.h_ww) + std::abs(e.h_tt)); !factor.positive;
             shift *= 4.0) {
            factor = Factor(e, free, shift);
            if (!std::isfinite(shift)) break;
        }
        double l = free.stretch ? loads.force - e.g_l : 0.0, w = free.volume ? loads.pressure - e.g_w : 0.0;
        double t = free.twist ? loads.torque - e.g_t : 0.0;
        const double r_l = l, r_w = w, r_t = t;
        factor.solve(l, w, t);
        const double size = std::max({std::abs(l) / at.shape.stretch, std::abs(w) / at.shape.volume, std::abs(t)});
        if (!std::isfinite(size)) {
            at.status = SolveStatus::singular_jacobian;
            return at;
        }
        if (size <= last_step) {
            at.shape.stretch += l, at.shape.volume += w, at.shape.twist += t;
            at.status = SolveStatus::converged;
            return at;
        }
        constexpr double longest_step = 0.25;  // keeps stretch and volume positive, and the iterates on their branch
        double part = std::min(1.0, longest_step / size);
        const double before = potential(e, loads, at.shape), slope = -(r_l * l + r_w * w + r_t * t);
        bool accepted = false;
        for (int halving = 0; halving < 40 && !accepted; ++halving, part *= 0.5) {
            const Shape<double> trial{at.shape.stretch + part * l, at.shape.volume + part * w,
                                      at.shape.twist + part * t};
            const WallEnergy<double> there = wall.energy(trial);
            if (!finite(there)) continue;
            if (size * part > too_small_to_compare && potential(there, loads, trial) > before + 1e-4 * part * slope)
                continue;
            at.shape = trial, at.energy = there;
            accepted = true;
        }
        if (!accepted) {
            at.status = SolveStatus::no_progress;
            return at;
        }
    }
    at.status = SolveStatus::max_iterations;
    return at;
}

Equilibrium at_stretch(const Wall& wall, double stretch, WallLoads& loads, const Shape<double>& start, Freedom free) {
    constexpr int max_iterations = 40;
    Equilibrium at{start, {}};
    for (at.iterations = 1; at.iterations <= max_iterations; ++at.iterations) {
        at.energy = wall.energy(at.shape);
        const WallEnergy<double>& e = at.energy;
        if (!finite(e)) {
            at.status = SolveStatus::not_finite;
            return at;
        }
        const Factor factor(e, free);
        at.stable = factor.positive;
        double l = loads.force - e.g_l, w = loads.pressure - e.g_w, t = free.twist ? loads.torque - e.g_t : 0.0;
        factor.solve(l, w, t);
        double l_p = 0.0, w_p = 1.0, t_p = 0.0;  // shape over pressure
        factor.solve(l_p, w_p, t_p);
        const double pressure = (stretch - at.shape.stretch - l) / l_p;
        l += pressure * l_p, w += pressure * w_p, t += pressure * t_p;
        const double size = std::max({std::abs(l) / at.shape.stretch, std::abs(w) / at.shape.volume, std::abs(t)});
        if (!std::isfinite(size)) {
            at.status = SolveStatus::singular_jacobian;
            return at;
        }
        constexpr double longest_step = 0.25;
        const double part = std::min(1.0, longest_step / size);
        at.shape.stretch += part * l, at.shape.volume += part * w, at.shape.twist += part * t;
        loads.pressure += part * pressure;
        if (size <= negligible_step) {
            at.status = SolveStatus::converged;
            return at;
        }
    }
    at.status = SolveStatus::max_iterations;
    return at;
}

PathPoint path_point(const Equilibrium& at, Freedom free) {
    const WallEnergy<double>& e = at.energy;
    const Factor inner(e, {true, false, free.twist});
    double l = -e.h_lw, w = 0.0, t = free.twist ? -e.h_wt : 0.0;
    inner.solve(l, w, t);
    PathPoint point{at.shape, e.g_w, e.h_ww + e.h_lw * l + e.h_wt * t, l, t, false, inner.positive};
    point.stable = inner.positive && point.d_pressure > 0.0;
    return point;
}

namespace {

/// Cubic through two values with their slopes, a distance apart, at a share of it: beyond one an extrapolation.
double hermite(double share, double distance, double y0, double slope0, double y1, double slope1) {
    const double rise = y1 - y0, c = distance * slope0, d = distance * slope1;
    return y0 + share * (c + share * ((3.0 * rise - 2.0 * c - d) + share * (c + d - 2.0 * rise)));
}

}  // namespace

bool advance(const Wall& wall, const WallLoads& loads, Freedom free, const PathPoint& from, double volume,
             PathPoint& to, const PathPoint* before) {
    const double step = volume - from.shape.volume;
    Shape<double> start{from.shape.stretch + from.d_stretch * step, volume, from.shape.twist + from.d_twist * step};
    if (!(start.stretch > 0.2 * from.shape.stretch)) start.stretch = from.shape.stretch;
    if (before) {
        const double distance = from.shape.volume - before->shape.volume, share = 1.0 + step / distance;
        if (share < 2.5)  // farther out a cubic is worse than the tangent
            start = {
                hermite(share, distance, before->shape.stretch, before->d_stretch, from.shape.stretch, from.d_stretch),
                volume, hermite(share, distance, before->shape.twist, before->d_twist, from.shape.twist, from.d_twist)};
    }
    const Equilibrium at = relax(wall, loads, start, {true, false, free.twist});
    if (!at.converged()) return false;
    to = path_point(at, free);
    return std::isfinite(to.pressure + to.d_pressure + to.d_stretch + to.d_twist);
}

double volume_step(const PathPoint& at, double pressure_scale) {
    // Cubic interpolation between points this far apart is good to about 1e-6, see the test of Path::guess.
    constexpr double change = 0.04, pressure_change = 0.15;
    double step = change * at.shape.volume;
    step = std::min(step, 0.5 * change * at.shape.stretch / (std::abs(at.d_stretch) + 1e-300));
    step = std::min(step, change / (std::abs(at.d_twist) + 1e-300));
    const double pressure = pressure_change * (std::abs(at.pressure) + pressure_scale);
    return std::min(step, pressure / (std::abs(at.d_pressure) + 1e-300));
}

Path::Path(const Wall& wall, Freedom free, double pressure_scale) {
    const Shape<double> rest;
    Equilibrium at{rest, wall.energy(rest), SolveStatus::converged, true, 0};
    PathPoint first = path_point(at, free);
    if (wall.tension_only()) {
        // At rest every fibre counts as taut, but under the smallest pressure some are slack, in proportions that do
        // not depend on how small it is: the tangent at rest is the limit from above.
        PathPoint near;
        for (double volume = 1.0 + 1e-7; volume < 1.0 + 1e-5; volume += 2e-7) {
            if (!advance(wall, {}, free, first, volume, near)) break;
            first.d_pressure = near.d_pressure, first.d_stretch = near.d_stretch, first.d_twist = near.d_twist;
            break;
        }
    }
    first.pressure = 0.0;
    points_.push_back(first);
    constexpr std::size_t most = 160;
    constexpr double largest_stretch = 4.0, largest_pressure = 1000.0;  // of the pressure scale
    while (points_.size() < most) {
        const PathPoint& from = points_.back();
        double step = volume_step(from, pressure_scale);
        PathPoint next;
        bool found = false;
        for (int halving = 0; halving < 12; ++halving, step *= 0.5) {
            const PathPoint* before = points_.size() > 1 && halving == 0 ? &points_[points_.size() - 2] : nullptr;
            found = advance(wall, {}, free, from, from.shape.volume + step, next, before);
            // A pressure that jumps by much more than its slope promised: the step was too long.
            if (found && std::abs(next.pressure - from.pressure) <= 0.4 * (std::abs(from.pressure) + pressure_scale))
                break;
            found = false;
        }
        if (!found) {
            end_ = PathEnd::no_solution;
            return;
        }
        if (!next.stable) {
            // Bisection on the volume for where stability is lost.
            PathPoint good = from, bad = next;
            for (int i = 0; i < 60 && bad.shape.volume - good.shape.volume > 1e-13 * bad.shape.volume; ++i) {
                PathPoint middle;
                if (!advance(wall, {}, free, good, 0.5 * (good.shape.volume + bad.shape.volume), middle)) break;
                (middle.stable ? good : bad) = middle;
            }
            end_ = bad.stable_at_volume ? PathEnd::limit_point : PathEnd::instability;
            if (good.shape.volume > from.shape.volume) {
                add_turning_point(wall, free, good);
                points_.push_back(good);
            }
            return;
        }
        add_turning_point(wall, free, next);
        points_.push_back(next);
        const double around = std::sqrt(next.shape.volume / next.shape.stretch);
        if (std::max({next.shape.stretch, 1.0 / next.shape.stretch, around}) > largest_stretch ||
            next.pressure > largest_pressure * pressure_scale) {
            end_ = PathEnd::out_of_scope;
            return;
        }
    }
}

// Where extension turns into contraction (or back) the path gets a point of its own, so that between two points the
// stretch is monotone and its inverse unique.
void Path::add_turning_point(const Wall& wall, Freedom free, const PathPoint& next) {
    const PathPoint from = points_.back();
    // Rest under a vanishing pressure has no direction when the slope is rounding only.
    if (!(from.d_stretch * next.d_stretch < 0.0)) return;
    PathPoint left = from, right = next, middle = next;
    for (int i = 0; i < 60 && right.shape.volume - left.shape.volume > 1e-12 * right.shape.volume; ++i) {
        if (!advance(wall, {}, free, left, 0.5 * (left.shape.volume + right.shape.volume), middle)) return;
        (middle.d_stretch * from.d_stretch > 0.0 ? left : right) = middle;
    }
    points_.push_back(middle);
}

Shape<double> Path::guess(double pressure) const {
    if (points_.size() == 1) return points_.front().shape;  // a law that ends at once: rest is all there is
    const auto above = std::lower_bound(points_.begin() + 1, points_.end() - 1, pressure,
                                        [](const PathPoint& p, double value) { return p.pressure < value; });
    const PathPoint &b = *above, &a = *(above - 1);
    const double h = b.shape.volume - a.shape.volume;
    const auto cubic = [&](double u, double y0, double m0, double y1, double m1) {
        return hermite(u, h, y0, m0, y1, m1);
    };
    const auto slope = [&](double u, double y0, double m0, double y1, double m1) {
        const double rise = y1 - y0, c = h * m0, d = h * m1;
        return c + u * (2.0 * (3.0 * rise - 2.0 * c - d) + 3.0 * u * (c + d - 2.0 * rise));
    };
    double u = (pressure - a.pressure) / (b.pressure - a.pressure), low = 0.0, high = 1.0;
    for (int i = 0; i < 30; ++i) {
        const double excess = cubic(u, a.pressure, a.d_pressure, b.pressure, b.d_pressure) - pressure;
        (excess > 0.0 ? high : low) = u;
        double next = u - excess / slope(u, a.pressure, a.d_pressure, b.pressure, b.d_pressure);
        if (!(next >= low && next <= high)) next = 0.5 * (low + high);
        const bool close = std::abs(next - u) < 1e-9;
        u = next;
        if (close) break;
    }
    return {cubic(u, a.shape.stretch, a.d_stretch, b.shape.stretch, b.d_stretch), a.shape.volume + u * h,
            cubic(u, a.shape.twist, a.d_twist, b.shape.twist, b.d_twist)};
}

}  // namespace softlimb::actuator
