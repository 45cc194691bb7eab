#include "softlimb/actuator/tube.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "softlimb/arguments.hpp"

namespace softlimb::actuator {

using solve::SolveStatus;

namespace {

using std::numbers::pi;

double max_strain(const materials::AnyLaw& law) {
    return std::visit([](const auto& l) { return l.max_strain; }, law);
}

// Radii that adjoin may differ by rounding when each was computed by itself.
std::vector<Layer> adjoining(std::vector<Layer> layers) {
    if (layers.empty()) throw std::invalid_argument("layers must hold at least one layer, got none");
    for (std::size_t i = 1; i < layers.size(); ++i) {
        const double gap = layers[i].inner - layers[i - 1].outer;
        if (std::abs(gap) > 1e-9 * layers[i].inner) {
            std::ostringstream text;
            text.precision(10);
            text << "layers must adjoin from inside out, but layer " << i << " begins at " << layers[i].inner
                 << " and layer " << i - 1 << " ends at " << layers[i - 1].outer;
            throw std::invalid_argument(text.str());
        }
        layers[i].inner = layers[i - 1].outer;
    }
    return layers;
}

double checked_length(double length) {
    require_positive("length", length);
    return length;
}

/// A few per cent of the pressure that strains the silicone alone by one.
double small_pressure(const std::vector<Layer>& layers) {
    double sum = 0.0;
    for (const Layer& layer : layers)
        sum += layer.silicone_fraction() * layer.shear_modulus() * std::log(layer.outer / layer.inner);
    return 0.02 * sum;
}

constexpr double locking_threshold = 0.1;  // share of the work worth a remark
constexpr double ballooning_margin = 0.9;  // of the limit pressure

}  // namespace

Tube::Tube(double length, std::vector<Layer> layers, const TubeOptions& options)
    : length_(checked_length(length)),
      layers_(adjoining(std::move(layers))),
      options_(options),
      wall_(layers_, options.tension_only),
      pressure_scale_(small_pressure(layers_)),
      path_(wall_, freedom(), pressure_scale_),
      table_(wall_, freedom(), pressure_scale_, path_) {
    if (options.mass) require_positive("mass", *options.mass);
    require_not_negative("cap_length", options.cap_length);
    if (!(2.0 * options.cap_length < length)) reject("cap_length", options.cap_length, "below half the length");
    area_scale_ = pi * inner_radius() * inner_radius();
    double silicone_mass = 0.0, smallest_range = 0.0;
    for (const Layer& layer : layers_) {
        const double modulus = layer.silicone_fraction() * layer.shear_modulus();
        linear_axial_ += 3.0 * modulus * layer.area();
        linear_shear_ += modulus * layer.area();
        linear_bending_ += 3.0 * modulus * layer.second_moment();
        silicone_mass += layer.density() * layer.area() * length;
        const double range = max_strain(layer.law);
        if (range > 0.0) smallest_range = smallest_range > 0.0 ? std::min(smallest_range, range) : range;
    }
    mass_ = options.mass.value_or(silicone_mass);
    largest_stretch_ = smallest_range > 0.0 ? 1.0 + smallest_range : 0.0;
    locking_share_ = measure_locking();
    rest_ = rest_state();
}

double Tube::measure_locking() const {
    if (options_.tension_only) return 0.0;
    const Shape<double> rest;
    double l = 0.0, w = 1.0, t = 0.0;  // response to the first pressure
    Factor(wall_.energy(rest), freedom()).solve(l, w, t);
    const double work = w;
    double wasted = 0.0;
    for (const WallLayer& layer : wall_.layers()) {
        for (const WallFamily& family : layer.families) {
            for (int side = 0; side < (family.mirrored ? 2 : 1); ++side) {
                const double sine = side == 0 ? family.sine : -family.sine, cosine = family.cosine;
                double volume = 0.0, sum = 0.0, squares = 0.0;
                for (const WallPoint& p : layer.points) {
                    const double hoop = 0.5 * (w * p.inverse_s - l), around = cosine / p.inverse_r;
                    const double strain = hoop * cosine * cosine + l * sine * sine + t * sine * around;
                    volume += p.weight, sum += p.weight * strain, squares += p.weight * strain * strain;
                }
                wasted += family.stiffness * (squares - sum * sum / volume);
            }
        }
    }
    return std::max(0.0, wasted / work);
}

double Tube::largest_strain_excess(const Shape<double>& q) const {
    double excess = -1.0;
    for (const WallLayer& layer : wall_.layers()) {
        const double range = max_strain(layer.law);
        if (!(range > 0.0)) continue;
        for (const double s : {layer.s_in, layer.s_out}) {
            const double e = s + q.volume - 1.0, a = s / (e * q.stretch);
            const double t = e / q.stretch * (1.0 / s + q.twist * q.twist) + q.stretch * q.stretch;
            const double in_surface = 0.5 * (t + std::sqrt(std::max(0.0, t * t - 4.0 / a)));
            excess = std::max(excess, std::sqrt(std::max(a, in_surface)) - 1.0 - range);
        }
    }
    return excess;
}

unsigned Tube::flags_of(const Shape<double>& q, double pressure) const {
    unsigned flags = 0;
    if (largest_strain_excess(q) > 0.0) flags |= law_out_of_range;
    if (locking_share_ > locking_threshold) flags |= locking;
    if (has_limit() && pressure > ballooning_margin * limit_pressure()) flags |= near_ballooning;
    if (pressure < 0.0) flags |= negative_pressure;
    for (const WallLayer& layer : wall_.layers())
        if (const auto* gent = std::get_if<materials::Gent>(&layer.law))
            if (wall_.largest_invariant(q) > 0.9 * gent->jm) flags |= near_law_limit;
    if (wall_.tension_only() && (pressure != 0.0 || q.stretch != 1.0 || q.twist != 0.0)) {
        for (const WallLayer& layer : wall_.layers())
            for (const WallFamily& family : layer.families)
                for (const double sine : {family.sine, family.mirrored ? -family.sine : family.sine})
                    if (!Wall::taut_parts(layer, {family.cosine, sine, family.stiffness, false}, q).whole)
                        flags |= slack_fibres;
    }
    return flags;
}

TubeState Tube::state_of(const Equilibrium& at, const WallLoads& loads) const {
    const WallEnergy<double>& e = at.energy;
    TubeState state;
    state.shape = at.shape;
    state.stretch = at.shape.stretch;
    state.inner_radius = inner_radius() * std::sqrt(at.shape.volume / at.shape.stretch);
    state.twist_rate = at.shape.twist / inner_radius();
    state.pressure = loads.pressure;
    state.axial_force = loads.force * area_scale_;
    state.torque = (options_.ends == Ends::free ? loads.torque : e.g_t) * area_scale_ * inner_radius();
    state.status = at.status;
    state.iterations = at.iterations;
    state.flags = flags_of(at.shape, loads.pressure);

    if (options_.ends == Ends::free && (e.h_lt != 0.0 || e.h_wt != 0.0)) {
        Eigen::Matrix3d h;
        h << e.h_ll, e.h_lw, e.h_lt, e.h_lw, e.h_ww, e.h_wt, e.h_lt, e.h_wt, e.h_tt;
        state.smallest_eigenvalue =
            Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(h, Eigen::EigenvaluesOnly).eigenvalues()(0);
    } else {
        const double mean = 0.5 * (e.h_ll + e.h_ww), half = 0.5 * (e.h_ll - e.h_ww);
        state.smallest_eigenvalue = mean - std::hypot(half, e.h_lw);
        if (options_.ends == Ends::free) state.smallest_eigenvalue = std::min(state.smallest_eigenvalue, e.h_tt);
    }
    state.smallest_eigenvalue *= area_scale_;
    state.stable = state.smallest_eigenvalue > 0.0;
    if (!state.stable) state.flags |= unstable;
    state.success = at.converged() && state.stable;
    return state;
}

namespace {

/// From a point on the path of given force and torque to a pressure, up or down, by steps of the volume.
Equilibrium follow(const Wall& wall, WallLoads loads, Freedom free, PathPoint from, double pressure_scale,
                   double& limit_pressure) {
    constexpr int most = 600;
    const double target = loads.pressure;
    Equilibrium at{from.shape, wall.energy(from.shape)};
    for (int count = 0; count < most; ++count) {
        const double direction = target >= from.pressure ? 1.0 : -1.0;
        double step = volume_step(from, pressure_scale);
        const double wanted = std::abs(target - from.pressure) / from.d_pressure;
        if (wanted <= step) {
            const double change = direction * wanted;
            const Shape<double> start{from.shape.stretch + from.d_stretch * change, from.shape.volume + change,
                                      from.shape.twist + from.d_twist * change};
            const Equilibrium near = relax(wall, loads, start, free);
            if (near.converged() && near.stable && std::abs(near.shape.volume - from.shape.volume) <= 2.0 * step)
                return near;
            step = 0.5 * std::min(step, wanted);
        }
        PathPoint next;
        bool found = false;
        for (int halving = 0; halving < 12 && !found; ++halving, step *= 0.5)
            found = advance(wall, loads, free, from, from.shape.volume + direction * step, next);
        if (!found) {
            at.status = SolveStatus::no_progress;
            at.shape = from.shape, at.energy = wall.energy(from.shape);
            return at;
        }
        if (!next.stable) {
            PathPoint good = from, bad = next;
            for (int i = 0; i < 60 && std::abs(bad.shape.volume - good.shape.volume) > 1e-13 * bad.shape.volume; ++i) {
                PathPoint middle;
                if (!advance(wall, loads, free, good, 0.5 * (good.shape.volume + bad.shape.volume), middle)) break;
                (middle.stable ? good : bad) = middle;
            }
            if (direction * (good.pressure - target) >= 0.0) {
                const Equilibrium near = relax(wall, loads, good.shape, free);
                if (near.converged() && near.stable) return near;
            }
            at.status = SolveStatus::limit_point;
            at.shape = good.shape, at.energy = wall.energy(good.shape);
            limit_pressure = good.pressure;
            return at;
        }
        from = next;
    }
    at.shape = from.shape, at.energy = wall.energy(from.shape);
    at.status = SolveStatus::max_iterations;
    return at;
}

}  // namespace

Shape<double> Tube::near(double pressure) const {
    UnloadedState<double> state;
    return table_.at(pressure, UnloadedTable::Part::shape, state) ? state.shape : path_.guess(pressure);
}

UnloadedState<double> Tube::rest_state() const {
    const Shape<double> rest;
    if (!wall_.tension_only()) return unloaded_state(wall_.energy(rest), rest);
    // Under a vanishing pressure some fibres are slack, in proportions that do not depend on how small it is.
    const Equilibrium near = solve_unloaded(smallest_pressure());
    UnloadedState<double> state = unloaded_state(near.energy, near.shape);
    state.shape = rest;
    return state;
}

UnloadedState<double> Tube::unloaded(double pressure, UnloadedTable::Part part, SolveStatus& status) const {
    status = SolveStatus::converged;
    if (pressure == 0.0) return rest_;
    UnloadedState<double> state{};
    const bool vanishing = wall_.tension_only() && std::abs(pressure) < smallest_pressure();
    if (!vanishing && table_.at(pressure, part, state)) return state;
    const Equilibrium at = solve_unloaded(pressure);
    status = at.converged() && !at.stable ? SolveStatus::singular_jacobian : at.status;
    // Once more at the very shape: `at` has the energy from before its last step, good for eight digits of a stiffness.
    state = vanishing ? rest_ : unloaded_state(wall_.energy(at.shape), at.shape);
    state.shape = at.shape;
    return state;
}

namespace {

/// The last digits of an unloaded state. A step that is negligible beside a stretch of one is not beside a strain of
/// 1e-9, and the slack parts of fibres are made of strains.
void polish(const Wall& wall, double pressure, Freedom free, Equilibrium& at) {
    double last = std::numeric_limits<double>::infinity();
    for (int i = 0; i < 8; ++i) {
        at.energy = wall.energy(at.shape);
        const WallEnergy<double>& e = at.energy;
        double l = -e.g_l, w = pressure - e.g_w, t = free.twist ? -e.g_t : 0.0;
        Factor(e, free).solve(l, w, t);
        const double size = std::max({std::abs(l), std::abs(w), std::abs(t)});
        if (!(size < 0.5 * last)) break;  // rounding
        at.shape = {at.shape.stretch + l, at.shape.volume + w, at.shape.twist + t};
        last = size;
    }
}

}  // namespace

Equilibrium Tube::solve_unloaded(double pressure, double* limit) const {
    const WallLoads loads{0.0, pressure, 0.0};
    if (pressure == 0.0) {
        const Shape<double> rest;
        return {rest, wall_.energy(rest), SolveStatus::converged, true, 0};
    }
    if (path_.covers(pressure)) {
        Equilibrium at = relax(wall_, loads, near(pressure), freedom());
        if (at.converged() && at.stable) {
            if (wall_.tension_only()) polish(wall_, pressure, freedom(), at);
            return at;
        }
    } else if (pressure > 0.0 && has_limit()) {
        const Shape<double> last = path_.last().shape;
        return {last, wall_.energy(last), SolveStatus::limit_point, true, 0};
    }
    double reached = 0.0;
    const PathPoint from = pressure > 0.0 && !path_.covers(pressure) ? path_.last() : path_.points().front();
    const Equilibrium at = follow(wall_, loads, freedom(), from, pressure_scale_, reached);
    if (limit && reached != 0.0) *limit = reached;
    return at;
}

bool Tube::loaded_rest(const WallLoads& loads, Equilibrium& at) const {
    double done = 0.0, step = 1.0;
    Shape<double> shape;
    while (done < 1.0) {
        step = std::min(step, 1.0 - done);
        const double part = done + step;
        at = relax(wall_, {part * loads.force, 0.0, part * loads.torque}, shape, freedom());
        if (at.converged() && at.stable) {
            shape = at.shape;
            done = part;
            step *= 2.0;
        } else {
            step *= 0.5;
            if (step < 1e-3) return false;
        }
    }
    return true;
}

TubeState Tube::inflate(double pressure, double axial_force, double torque) const {
    require_finite("pressure", pressure);
    require_finite("axial_force", axial_force);
    require_finite("torque", torque);
    if (options_.ends == Ends::bonded && torque != 0.0)
        reject("torque", torque, "zero: bonded ends do not turn and carry any torque themselves");
    const WallLoads loads{axial_force / area_scale_, pressure, torque / (area_scale_ * inner_radius())};
    if (axial_force == 0.0 && torque == 0.0) {
        double limit = has_limit() ? limit_pressure() : 0.0;
        TubeState state = state_of(solve_unloaded(pressure, &limit), loads);
        state.limit_pressure = limit;
        return state;
    }
    const Shape<double> start = path_.covers(pressure) ? near(pressure) : Shape<double>{};
    Equilibrium at = relax(wall_, loads, start, freedom());
    double limit = 0.0;
    if (!at.converged() || !at.stable) {
        if (loaded_rest(loads, at))
            at = follow(wall_, loads, freedom(), path_point(at, freedom()), pressure_scale_, limit);
        else
            at.status = SolveStatus::limit_point;
    }
    TubeState state = state_of(at, loads);
    state.limit_pressure = limit;
    return state;
}

TubeState Tube::paper_reduced(double pressure) const {
    require_finite("pressure", pressure);
    // With lambda_theta = 1 and r = R the hoop stress less the radial is constant over a layer, so that radial
    // equilibrium integrates to a sum of logarithms.
    const auto balance = [&](const Dual<1>& l) {
        Dual<1> sum(0.0);
        for (const WallLayer& layer : wall_.layers()) {
            const Dual<1> a = 1.0 / (l * l), t = 1.0 + l * l;
            Dual<1> difference(0.0);
            std::visit(
                [&](const auto& law) {
                    const auto w = law.derivatives(a, t);
                    difference += layer.silicone * 2.0 * (w.w_t - w.w_a * a);
                },
                layer.law);
            for (const WallFamily& family : layer.families) {
                const double c2 = family.cosine * family.cosine, s2 = family.sine * family.sine;
                // Stretch squared less one. Stiff fibres times the rounding of 1 - 1/stretch would hide pressures below
                // 1e-9 Pa from Newton's method; written so, nothing cancels near rest.
                const Dual<1> squared_less_one = (l - 1.0) * (l + 1.0) * s2;
                if (wall_.tension_only() && squared_less_one < Dual<1>(0.0)) continue;
                const Dual<1> stretch = sqrt(1.0 + squared_less_one);
                difference += (family.mirrored ? 2.0 : 1.0) * family.stiffness * c2 * squared_less_one /
                              (stretch * (1.0 + stretch));
            }
            sum += 0.5 * (layer.x_out - layer.x_in) * difference;  // x = 2 ln R
        }
        return sum;
    };
    TubeState state;
    state.model = TubeModel::paper_reduced;
    state.inner_radius = inner_radius();
    state.pressure = pressure;
    double l = 1.0, last_step = std::numeric_limits<double>::infinity();
    // The stretch is bounded by a factor of two a step; more than 2^40 is no answer.
    for (state.iterations = 1; state.iterations <= 200; ++state.iterations) {
        const Dual<1> p = balance(Dual<1>::variable(l, 0));
        double step = (pressure - p.value) / p.slope[0];
        if (!std::isfinite(step)) {
            state.status = SolveStatus::not_finite;
            break;
        }
        if (!(p.slope[0] > 0.0)) {
            state.status = SolveStatus::limit_point;
            break;
        }
        step = std::clamp(step, -0.25 * l, 0.25 * l);
        l += step;
        // Newton's method squares a small step: one that no longer shrinks is the rounding of the laws.
        const double size = std::abs(step);
        if (size < 1e-14 * l || (size < 1e-10 * l && size >= 0.5 * last_step)) {
            state.status = SolveStatus::converged;
            break;
        }
        last_step = size;
    }
    state.stretch = l;
    state.shape = {l, l, 0.0};
    state.success = state.stable = state.status == SolveStatus::converged;
    if (pressure < 0.0) state.flags |= negative_pressure;
    return state;
}

TubeState Tube::at_volume(double volume, double axial_force, double torque) const {
    require_positive("volume", volume);
    require_finite("axial_force", axial_force);
    require_finite("torque", torque);
    if (options_.ends == Ends::bonded && torque != 0.0)
        reject("torque", torque, "zero: bonded ends do not turn and carry any torque themselves");
    WallLoads loads{axial_force / area_scale_, 0.0, torque / (area_scale_ * inner_radius())};
    const double target = volume / (area_scale_ * length_);
    const Freedom free = freedom();
    PathPoint at = path_.points().front();
    Equilibrium rest{at.shape, wall_.energy(at.shape), SolveStatus::converged, true, 0};
    bool found = true;
    if (axial_force != 0.0 || torque != 0.0) {
        found = loaded_rest(loads, rest);
        at = path_point(rest, free);
    } else if (target > 1.0) {
        for (const PathPoint& point : path_.points())
            if (point.shape.volume <= target) at = point;
    }
    constexpr int most = 2000;
    for (int count = 0; found && at.shape.volume != target; ++count) {
        const double direction = target > at.shape.volume ? 1.0 : -1.0;
        double step = std::min(volume_step(at, pressure_scale_), std::abs(target - at.shape.volume));
        PathPoint next;
        found = false;
        for (int halving = 0; halving < 12 && !found; ++halving, step *= 0.5) {
            const double there = at.shape.volume + direction * step;
            found = advance(wall_, loads, free, at, step == std::abs(target - at.shape.volume) ? target : there, next);
        }
        if (found) at = next;
        if (count > most) found = false;
    }
    Equilibrium result{at.shape, wall_.energy(at.shape)};
    loads.pressure = result.energy.g_w;
    result.status = found ? SolveStatus::converged : SolveStatus::no_progress;
    TubeState state = state_of(result, loads);
    state.success = found && at.stable_at_volume;
    return state;
}

TubeState Tube::at_inner_radius(double radius, double axial_force, double torque) const {
    require_positive("inner_radius", radius);
    // r_i^2 = v/lz: Newton on the volume, starting from the volume at the undeformed length.
    const double target = radius * radius / (inner_radius() * inner_radius());
    double low = 0.0, high = 0.0, w = target;
    TubeState state;
    for (int i = 0; i < 100; ++i) {
        state = at_volume(w * area_scale_ * length_, axial_force, torque);
        if (state.status != SolveStatus::converged) return state;
        const double l = state.shape.stretch, excess = w / l - target;
        const Equilibrium here{state.shape, wall_.energy(state.shape)};
        const double slope = 1.0 / l - w / (l * l) * path_point(here, freedom()).d_stretch;
        (excess > 0.0 ? high : low) = w;
        const double step = -excess / slope;
        if (std::abs(step) <= 1e-13 * w) return state;
        double next = w + std::clamp(step, -0.3 * w, 0.3 * w);
        if (low > 0.0 && high > 0.0 && !((next - low) * (next - high) < 0.0)) next = 0.5 * (low + high);
        if (std::abs(next - w) <= 1e-15 * w) return state;
        w = next;
    }
    state.status = SolveStatus::max_iterations;
    state.success = false;
    return state;
}

namespace {

/// Volume between two path points at which the stretch, monotone there, is a given one: bisection on the cubic.
double volume_at_stretch(const PathPoint& a, const PathPoint& b, double stretch) {
    const double h = b.shape.volume - a.shape.volume;
    double low = 0.0, high = 1.0;
    const double rise = b.shape.stretch - a.shape.stretch, c = h * a.d_stretch, d = h * b.d_stretch;
    for (int i = 0; i < 40; ++i) {
        const double u = 0.5 * (low + high);
        const double value = a.shape.stretch + u * (c + u * ((3.0 * rise - 2.0 * c - d) + u * (c + d - 2.0 * rise)));
        ((value < stretch) == (rise > 0.0) ? low : high) = u;
    }
    return a.shape.volume + 0.5 * (low + high) * h;
}

bool between(double value, double a, double b) { return (value - a) * (value - b) <= 0.0; }

}  // namespace

TubeState Tube::at_stretch(double stretch) const {
    require_positive("stretch", stretch);
    const Freedom free = freedom();
    const auto& points = path_.points();
    if (stretch == 1.0) return inflate(0.0);
    std::size_t nearest = 0;
    for (std::size_t i = 0; i + 1 < points.size(); ++i) {
        const PathPoint &a = points[i], &b = points[i + 1];
        if (std::abs(b.shape.stretch - stretch) < std::abs(points[nearest].shape.stretch - stretch)) nearest = i + 1;
        if (i == 0 && stretch == a.shape.stretch) continue;
        if (!between(stretch, a.shape.stretch, b.shape.stretch)) continue;
        const double volume = volume_at_stretch(a, b, stretch);
        PathPoint start = a;
        if (!advance(wall_, {}, free, a, volume, start)) continue;
        WallLoads loads{0.0, start.pressure, 0.0};
        const Equilibrium at = actuator::at_stretch(wall_, stretch, loads, start.shape, free);
        if (at.converged() && at.shape.volume > 0.0) return state_of(at, loads);
        // Next to a turning point of the stretch the pressure is not determined to the last digits.
        Equilibrium near{start.shape, wall_.energy(start.shape), SolveStatus::converged, true, at.iterations};
        if (std::abs(start.shape.stretch - stretch) < 1e-12) {
            loads.pressure = start.pressure;
            return state_of(near, loads);
        }
    }
    if (path_.end() == PathEnd::out_of_scope &&
        (stretch - points.back().shape.stretch) * points.back().d_stretch > 0.0 && stretch < 10.0 && stretch > 0.1) {
        // Beyond the stored path: follow it further.
        PathPoint from = points.back(), next;
        for (int count = 0; count < 400; ++count) {
            if (!advance(wall_, {}, free, from, from.shape.volume + volume_step(from, pressure_scale_), next)) break;
            if (!next.stable || next.d_stretch * from.d_stretch < 0.0) break;
            if (between(stretch, from.shape.stretch, next.shape.stretch)) {
                WallLoads loads{0.0, from.pressure, 0.0};
                const Equilibrium at = actuator::at_stretch(wall_, stretch, loads, from.shape, free);
                if (at.converged()) return state_of(at, loads);
                break;
            }
            from = next;
        }
    }
    const PathPoint& best = points[nearest];
    Equilibrium at{best.shape, wall_.energy(best.shape), SolveStatus::no_progress, true, 0};
    TubeState state = state_of(at, {0.0, best.pressure, 0.0});
    state.success = false;
    return state;
}

std::vector<double> Tube::pressures_at_stretch(double stretch) const {
    std::vector<double> pressures;
    const auto& points = path_.points();
    for (std::size_t i = 0; i + 1 < points.size(); ++i) {
        const PathPoint &a = points[i], &b = points[i + 1];
        if (!between(stretch, a.shape.stretch, b.shape.stretch) || stretch == b.shape.stretch) continue;
        PathPoint near;
        if (!advance(wall_, {}, freedom(), a, volume_at_stretch(a, b, stretch), near)) continue;
        WallLoads loads{0.0, near.pressure, 0.0};
        const Equilibrium at = actuator::at_stretch(wall_, stretch, loads, near.shape, freedom());
        pressures.push_back(at.converged() ? loads.pressure : near.pressure);
    }
    if (!pressures.empty()) pressures.erase(pressures.begin());
    return pressures;
}

double Tube::outer_radius(const TubeState& state) const {
    const double s = std::exp(wall_.layers().back().x_out);
    return inner_radius() * std::sqrt((s + state.shape.volume - 1.0) / state.shape.stretch);
}

}  // namespace softlimb::actuator
