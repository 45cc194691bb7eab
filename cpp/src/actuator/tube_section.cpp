// The section that a tube hands to a rod. Source: cpp/MECHANICS.md, "Section".
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "softlimb/actuator/section_values.hpp"
#include "softlimb/actuator/tube.hpp"

namespace softlimb::actuator {

using solve::SolveStatus;

namespace {

using std::numbers::pi;

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

/// Shape at node i; `half_range` is the force [as of the slopes] from the middle of the nodes to their end.
template <class Nodes>
Shape<double> foretold(const Interpolation::Forecast& forecast, const Nodes& nodes, double half_range) {
    Shape<double> sum{0.0, 0.0, 0.0};
    for (int a = 0; a < forecast.known; ++a) {
        const Shape<double>&shape = nodes.shape[forecast.node[a]], &along = nodes.along[forecast.node[a]];
        const double value = forecast.of_value[a], slope = forecast.of_slope[a] * half_range;
        sum.stretch += value * shape.stretch + slope * along.stretch;
        sum.volume += value * shape.volume + slope * along.volume;
        sum.twist += value * shape.twist + slope * along.twist;
    }
    return sum;
}

const Interpolation& interpolation() {
    static const Interpolation rule(law_degree);
    return rule;
}

}  // namespace

Tube::AxialNodes::Values Tube::coefficients_of(const AxialNodes::Values& value) {
    const Interpolation& rule = interpolation();
    AxialNodes::Values coefficient{};
    for (int k = 0; k < rule.count; ++k)
        for (int i = 0; i < rule.count; ++i) coefficient[k] += rule.power[k][i] * value[i];
    return coefficient;
}

SectionConstants<double> Tube::constants(Valve valve) const {
    return {length_,
            length_ - 2.0 * options_.cap_length,
            inner_radius(),
            area_scale_,
            mass_,
            linear_axial_,
            linear_bending_,
            linear_shear_,
            options_.ends == Ends::free,
            valve == Valve::locked,
            options_.cap_length != 0.0};
}

SolveStatus Tube::linear_section(double pressure, SectionModel model, Valve valve, Section& section,
                                 double& rest_length) const {
    section = Section{};
    rest_length = std::numeric_limits<double>::quiet_NaN();
    if (!std::isfinite(pressure)) return SolveStatus::not_finite;
    SolveStatus status;
    const SectionValues<double> values = section_values(constants(valve), unloaded(pressure, part_for(valve), status));
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
    const SolveStatus status = linear_section(pressure, model, valve, section, rest_length);
    if (model == SectionModel::nonlinear && status == SolveStatus::converged)
        nonlinear_law(solve_unloaded(pressure), pressure, valve, rest_length, section);
    return status;
}

SectionAtPressure Tube::section(double pressure, SectionModel model, Valve valve, bool derivative) const {
    SectionAtPressure out;
    out.status = section(pressure, model, valve, out.section, out.rest_length);
    if (!derivative || out.status == SolveStatus::not_finite) return out;
    const SectionSlope slope = section_slope(pressure, model, valve);
    out.d_section = slope.section, out.d_rest_length = slope.rest_length;
    return out;
}

Tube::AxialNodes Tube::nonlinear_law(const Equilibrium& rest, double pressure, Valve valve, double rest_length,
                                     Section& section) const {
    const Freedom free{true, valve == Valve::open, options_.ends == Ends::free};
    const double active = length_ - 2.0 * options_.cap_length;
    // Stretch of the rod less one, over the force.
    const double rest_stretch = rest.shape.stretch, share = active / rest_length;
    const auto along = [&](const WallEnergy<double>& e) {
        Shape<double> slope{1.0, 0.0, 0.0};
        Factor(e, free).solve(slope.stretch, slope.volume, slope.twist);
        return slope;
    };
    // A step of 1e-7 need not be looked at again: it leaves less than 1e-12.
    const auto solve_at = [&](double force, const Shape<double>& start) {
        return relax(wall_, {force / area_scale_, pressure, 0.0}, start, free, 1e-7);
    };
    const auto value_at = [&](double force, const Equilibrium& at) {
        return (at.shape.stretch - rest_stretch) * share / force;
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
        AxialNodes nodes;
        nodes.count = rule.count, nodes.rest = rule.rest;
        nodes.value[rule.rest] = section.axial_law.coefficient[0];
        nodes.shape[rule.rest] = rest.shape, nodes.along[rule.rest] = along(rest.energy);
        bool reached = true;
        for (const int direction : {1, -1})
            for (int i = rule.rest + direction; reached && i >= 0 && i < rule.count; i += direction) {
                Shape<double> start = foretold(rule.forecast[i], nodes, half_range / area_scale_);
                if (!free.volume) start.volume = rest.shape.volume;  // what is held is no forecast
                if (!free.twist) start.twist = rest.shape.twist;
                nodes.force[i] = centre + half_range * rule.node[i];
                const Equilibrium at = solve_at(nodes.force[i], start);
                nodes.value[i] = value_at(nodes.force[i], at);
                nodes.shape[i] = at.shape, nodes.along[i] = along(at.energy);
                reached = at.converged() && at.stable;
            }
        if (!reached) continue;
        AxialLaw law;
        law.degree = law_degree, law.centre = centre, law.half_range = half_range;
        law.coefficient = coefficients_of(nodes.value);
        if (may_be_rough && half_range * 0.6 > shortest * scale) {
            // Halfway between the outermost nodes an interpolation is worst.
            double error = 0.0;
            for (const int i : {0, rule.count - 2}) {
                const double force = centre + half_range * 0.5 * (rule.node[i] + rule.node[i + 1]);
                const double exact = value_at(force, solve_at(force, nodes.shape[i]));
                double strain, compliance;
                axial_strain(law, force, strain, compliance);
                error = std::max(error, std::abs(strain / (force * exact) - 1.0));
            }
            constexpr double tolerable = 1e-3;
            if (!(error <= tolerable)) continue;
        }
        section.axial_law = law;
        return nodes;
    }
    return {};
}

}  // namespace softlimb::actuator
