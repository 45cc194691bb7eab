// The section that a tube hands to a rod. Source: cpp/MECHANICS.md, "Section".
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "softlimb/actuator/tube.hpp"

namespace softlimb::actuator {

using solve::SolveStatus;

namespace {

constexpr double pi = std::numbers::pi;

template <class S>
struct SectionValues {
    S rest_length, axial, shear, bending, torsion, mass_per_length, rest_twist, extension_twist, stretch;
};

/// The formulas, for double and for dual numbers alike.
template <class S>
SectionValues<S> section_values(const SectionConstants& c, const UnloadedState<S>& at) {
    const Shape<S>& q = at.shape;
    const S& l = q.stretch;
    const AxialStiffness<S>&p = at.open, &k = c.locked ? at.locked : at.open;
    const S open = c.twist_free ? p.ll - p.lt * p.lt / p.tt : p.ll;
    const S axial = c.twist_free ? k.ll - k.lt * k.lt / k.tt : k.ll;
    const S torsion = c.twist_free ? k.tt - k.lt * k.lt / k.ll : k.tt;

    SectionValues<S> s;
    // Caps keep part of the length at rest: the rod of length l is then stiffer by l / (its active part).
    s.rest_length = l * c.active + (c.length - c.active);
    const S per_length = c.active == c.length ? l : s.rest_length / c.active;
    const S scale = per_length * c.area_scale;
    s.axial = scale * axial;
    s.torsion = scale * (c.inner_radius * c.inner_radius) * torsion;
    const S ratio = per_length * (open * (c.area_scale / c.linear_axial));
    s.bending = ratio * c.linear_bending;
    s.shear = ratio * c.linear_shear;
    s.rest_twist = q.twist / (c.inner_radius * per_length);
    s.extension_twist = S(0.0);
    if (c.twist_free) s.extension_twist = -k.lt / ((k.ll * k.tt - k.lt * k.lt) * scale * c.inner_radius);
    s.mass_per_length = c.mass / s.rest_length;
    s.stretch = s.rest_length / c.length;
    return s;
}

void fill(Section& section, const SectionValues<double>& s) {
    section.axial = s.axial, section.shear = s.shear, section.bending = s.bending, section.torsion = s.torsion;
    section.mass_per_length = s.mass_per_length, section.rest_twist = s.rest_twist;
    section.extension_twist = s.extension_twist, section.stretch = s.stretch;
    section.axial_law.coefficient[0] = 1.0 / s.axial;
}

// The law covers -0.12 to 0.2 EA, strains of about -0.1 to 0.23: more than a rod meets in a limb (0.054 in the paper's
// complex posture). Degree 12 then leaves about 1e-10 of strain; twice the range would leave 1e-6.
constexpr int law_degree = 12;
constexpr double lowest = -0.12, highest = 0.2;
constexpr double node_of_rest = -(highest + lowest) / (highest - lowest);

/// Nodes on [-1, 1] with the unloaded tube among them, and the matrix that takes values at the nodes to coefficients
/// of powers. Chebyshev's nodes, the one nearest to the unloaded tube moved there: so v3'(0) = 1/EA holds exactly.
struct Interpolation {
    int count = 0;
    std::array<double, AxialLaw::max_degree + 1> node{};
    std::array<std::array<double, AxialLaw::max_degree + 1>, AxialLaw::max_degree + 1> power{};  // [power][node]
    int rest = 0;
    /// Foretells the shape at a node from shapes and slopes at up to four that are solved before it: first those above
    /// the unloaded tube, upwards, then those below, downwards.
    struct Forecast {
        static constexpr int most = 4;
        int known = 0;
        std::array<int, most> node{};
        std::array<double, most> of_value{}, of_slope{};
    };
    std::array<Forecast, AxialLaw::max_degree + 1> forecast{};

    explicit Interpolation(int degree) : count(degree + 1) {
        for (int i = 0; i < count; ++i) node[i] = -std::cos(pi * (i + 0.5) / count);
        for (int i = 0; i < count; ++i)
            if (std::abs(node[i] - node_of_rest) < std::abs(node[rest] - node_of_rest)) rest = i;
        node[rest] = node_of_rest;
        for (int i = 0; i < count; ++i) {
            std::array<long double, AxialLaw::max_degree + 2> basis{};
            basis[0] = 1.0L;
            int size = 1;
            for (int j = 0; j < count; ++j) {
                if (j == i) continue;
                const long double difference = static_cast<long double>(node[i]) - node[j];
                for (int k = size; k >= 0; --k)
                    basis[k] = ((k > 0 ? basis[k - 1] : 0.0L) - node[j] * basis[k]) / difference;
                ++size;
            }
            for (int k = 0; k < count; ++k) power[k][i] = static_cast<double>(basis[k]);
            forecast[i] = forecast_of(i);
        }
    }

    /// Hermite's polynomial at node i.
    Forecast forecast_of(int i) const {
        Forecast f;
        if (i == rest) return f;
        const int towards = i > rest ? -1 : 1, end = i > rest ? rest : count - 1;
        for (int j = i + towards; f.known < Forecast::most && (end - j) * towards >= 0; j += towards)
            f.node[f.known++] = j;
        for (int a = 0; a < f.known; ++a) {
            double basis = 1.0, slope = 0.0;
            for (int b = 0; b < f.known; ++b) {
                if (b == a) continue;
                const double apart = node[f.node[a]] - node[f.node[b]];
                basis *= (node[i] - node[f.node[b]]) / apart;
                slope += 1.0 / apart;
            }
            const double away = node[i] - node[f.node[a]];
            f.of_value[a] = (1.0 - 2.0 * away * slope) * basis * basis, f.of_slope[a] = away * basis * basis;
        }
        return f;
    }
};

struct Node {
    double value, slope;         // strain over force, and its derivative to the pressure
    Shape<double> shape, along;  // and derivative to the force
    bool good;
};

using Nodes = std::array<Node, AxialLaw::max_degree + 1>;

/// Shape at node i; `half_range` is the force [as of the slopes] from the middle of the nodes to their end.
Shape<double> foretold(const Interpolation::Forecast& forecast, const Nodes& nodes, double half_range) {
    Shape<double> sum{0.0, 0.0, 0.0};
    for (int a = 0; a < forecast.known; ++a) {
        const Node& at = nodes[forecast.node[a]];
        const double value = forecast.of_value[a], slope = forecast.of_slope[a] * half_range;
        sum.stretch += value * at.shape.stretch + slope * at.along.stretch;
        sum.volume += value * at.shape.volume + slope * at.along.volume;
        sum.twist += value * at.shape.twist + slope * at.along.twist;
    }
    return sum;
}

const Interpolation& interpolation() {
    static const Interpolation rule(law_degree);
    return rule;
}

}  // namespace

SectionConstants Tube::constants(Valve valve) const {
    return {length_,
            length_ - 2.0 * options_.cap_length,
            inner_radius(),
            area_scale_,
            mass_,
            linear_axial_,
            linear_bending_,
            linear_shear_,
            options_.ends == Ends::free,
            valve == Valve::locked};
}

SolveStatus Tube::linear_section(double pressure, SectionModel model, Valve valve, Section& section,
                                 double& rest_length) const {
    section = Section{};
    rest_length = std::numeric_limits<double>::quiet_NaN();
    if (!std::isfinite(pressure)) return SolveStatus::not_finite;
    SolveStatus status;
    const SectionValues<double> values = section_values(constants(valve), unloaded(pressure, status));
    fill(section, values);
    section.largest_stretch = largest_stretch_;
    rest_length = values.rest_length;
    if (model == SectionModel::paper) {
        section.axial = linear_axial_, section.bending = linear_bending_, section.shear = linear_shear_;
        section.torsion = 2.0 * linear_bending_ / 3.0;  // G J with G = E/3 and J = 2 I
        section.rest_twist = section.extension_twist = 0.0;
        section.axial_law.coefficient[0] = 1.0 / section.axial;
    }
    return status;
}

SolveStatus Tube::section(double pressure, SectionModel model, Valve valve, Section& section,
                          double& rest_length) const {
    if (model != SectionModel::nonlinear) return linear_section(pressure, model, valve, section, rest_length);
    const SectionAtPressure at = this->section(pressure, model, valve);
    section = at.section, rest_length = at.rest_length;
    return at.status;
}

SectionAtPressure Tube::section(double pressure, SectionModel model, Valve valve, bool derivative) const {
    SectionAtPressure out;
    Section& section = out.section;
    out.status = linear_section(pressure, model, valve, section, out.rest_length);
    if (out.status == SolveStatus::not_finite || (!derivative && model != SectionModel::nonlinear)) return out;
    const Equilibrium state = solve_unloaded(pressure);
    if (derivative) {
        const bool vanishing = wall_.tension_only() && std::abs(pressure) < smallest_pressure();
        const Equilibrium tangent = vanishing ? solve_unloaded(smallest_pressure()) : state;
        double l = 0.0, w = 1.0, t = 0.0;
        Factor(tangent.energy, freedom()).solve(l, w, t);
        const auto moving = [](double value, double slope) { return Dual<1>(value, {slope}); };
        const Shape<Dual<1>> shape{moving(tangent.shape.stretch, l), moving(tangent.shape.volume, w),
                                   moving(tangent.shape.twist, t)};
        const SectionValues<Dual<1>> s = section_values(constants(valve), unloaded_state(wall_.energy(shape), shape));
        Section& d = out.d_section;
        d = Section{};
        out.d_rest_length = s.rest_length.slope[0];
        d.mass_per_length = s.mass_per_length.slope[0], d.stretch = s.stretch.slope[0];
        if (model != SectionModel::paper) {
            d.axial = s.axial.slope[0], d.shear = s.shear.slope[0], d.bending = s.bending.slope[0];
            d.torsion = s.torsion.slope[0], d.rest_twist = s.rest_twist.slope[0];
            d.extension_twist = s.extension_twist.slope[0];
            d.axial_law.coefficient[0] = -d.axial / (section.axial * section.axial);
        }
    }
    if (model == SectionModel::nonlinear && out.status == SolveStatus::converged)
        nonlinear_law(state, pressure, valve, derivative, out);
    return out;
}

void Tube::nonlinear_law(const Equilibrium& rest, double pressure, Valve valve, bool derivative,
                         SectionAtPressure& out) const {
    const Section& section = out.section;
    const Freedom free{true, valve == Valve::open, options_.ends == Ends::free};
    const double active = length_ - 2.0 * options_.cap_length;
    // Stretch of the rod less one, over the force, and its derivative to the pressure.
    const double rest_stretch = rest.shape.stretch, share = active / out.rest_length;
    double l_p = 0.0, w_p = 1.0, t_p = 0.0;
    if (derivative) Factor(rest.energy, freedom()).solve(l_p, w_p, t_p);
    const double d_rest_stretch = l_p, d_rest_volume = w_p;
    const auto along = [&](const WallEnergy<double>& e) {
        Shape<double> slope{1.0, 0.0, 0.0};
        Factor(e, free).solve(slope.stretch, slope.volume, slope.twist);
        return slope;
    };
    const auto solve_at = [&](double force, const Shape<double>& start) {
        const WallLoads loads{force / area_scale_, pressure, 0.0};
        // Where the tangent is not asked for, a step of 1e-7 need not be looked at again: it leaves less than 1e-12.
        const Equilibrium at = relax(wall_, loads, start, free, derivative ? negligible_step : 1e-7);
        Node node{0.0, 0.0, at.shape, along(at.energy), at.converged() && at.stable};
        node.value = (at.shape.stretch - rest_stretch) * share / force;
        if (derivative) {
            double l = 0.0, w = 0.0, t = 0.0;
            if (free.volume) {
                w = 1.0;
            } else {  // the locked volume itself moves with the pressure
                l = -at.energy.h_lw * d_rest_volume, t = free.twist ? -at.energy.h_wt * d_rest_volume : 0.0;
            }
            Factor(at.energy, free).solve(l, w, t);
            node.slope =
                ((l - d_rest_stretch) * share - node.value * force * out.d_rest_length / out.rest_length) / force;
        }
        return node;
    };

    const Interpolation& rule = interpolation();
    constexpr double shortest = 1e-3;
    // Fibres that go slack give the curve corners in its third derivative, and a tube locked in volume may be close to
    // another mode of instability: there the range shrinks until the interpolation is good.
    const bool may_be_rough = wall_.tension_only() || valve == Valve::locked;
    // A tube that folds inside the range gets a shorter one; the stiffness at rest remains if none is short enough.
    // Measured by EA at constant pressure: locked in volume a tube is many times stiffer, but the forces are the
    // limb's.
    const double scale = section.bending * linear_axial_ / linear_bending_;
    for (double half_range = 0.5 * (highest - lowest) * scale; half_range > shortest * scale; half_range *= 0.6) {
        const double centre = -node_of_rest * half_range;
        Nodes nodes;
        nodes[rule.rest] = {section.axial_law.coefficient[0], out.d_section.axial_law.coefficient[0], rest.shape,
                            along(rest.energy), true};
        bool reached = true;
        for (const int direction : {1, -1})
            for (int i = rule.rest + direction; reached && i >= 0 && i < rule.count; i += direction) {
                Shape<double> start = foretold(rule.forecast[i], nodes, half_range / area_scale_);
                if (!free.volume) start.volume = rest.shape.volume;  // what is held is no forecast
                if (!free.twist) start.twist = rest.shape.twist;
                nodes[i] = solve_at(centre + half_range * rule.node[i], start);
                reached = nodes[i].good;
            }
        if (!reached) continue;
        AxialLaw law, d_law;
        law.degree = law_degree, law.centre = centre, law.half_range = half_range;
        d_law = law;
        for (int k = 0; k < rule.count; ++k)
            for (int i = 0; i < rule.count; ++i) {
                law.coefficient[k] += rule.power[k][i] * nodes[i].value;
                if (derivative) d_law.coefficient[k] += rule.power[k][i] * nodes[i].slope;
            }
        if (may_be_rough && half_range * 0.6 > shortest * scale) {
            // Halfway between the outermost nodes an interpolation is worst.
            double error = 0.0;
            for (const int i : {0, rule.count - 2}) {
                const double force = centre + half_range * 0.5 * (rule.node[i] + rule.node[i + 1]);
                const Node exact = solve_at(force, nodes[i].shape);
                double strain, compliance;
                axial_strain(law, force, strain, compliance);
                error = std::max(error, std::abs(strain / (force * exact.value) - 1.0));
            }
            constexpr double tolerable = 1e-3;
            if (!(error <= tolerable)) continue;
        }
        out.section.axial_law = law;
        if (derivative) out.d_section.axial_law = d_law;
        return;
    }
}

}  // namespace softlimb::actuator
