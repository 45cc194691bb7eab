// The section that a tube hands to a rod. Source: cpp/MECHANICS.md, "Section".
#include <array>
#include <cmath>
#include <numbers>

#include "softlimb/actuator/tube.hpp"

namespace softlimb::actuator {

using solve::SolveStatus;

namespace {

constexpr double pi = std::numbers::pi;

/// Constants of the tube that the section's formulas need.
struct SectionConstants {
    double length, active, inner_radius, area_scale, mass;
    double linear_axial, linear_bending, linear_shear;
    bool twist_free, locked;
};

template <class S>
struct SectionValues {
    S rest_length, axial, shear, bending, torsion, mass_per_length, rest_twist, extension_twist, stretch;
};

/// The formulas, for double and for dual numbers alike.
template <class S>
SectionValues<S> section_values(const SectionConstants& c, const WallEnergy<S>& e, const Shape<S>& q) {
    const S& l = q.stretch;
    // Stiffness in (lz, gamma) at constant pressure: the volume condensed.
    const S p_ll = e.h_ll - e.h_lw * e.h_lw / e.h_ww, p_lt = e.h_lt - e.h_lw * e.h_wt / e.h_ww;
    const S p_tt = e.h_tt - e.h_wt * e.h_wt / e.h_ww;
    const S k_ll = c.locked ? e.h_ll : p_ll, k_lt = c.locked ? e.h_lt : p_lt, k_tt = c.locked ? e.h_tt : p_tt;
    const S open = c.twist_free ? p_ll - p_lt * p_lt / p_tt : p_ll;
    const S axial = c.twist_free ? k_ll - k_lt * k_lt / k_tt : k_ll;
    const S torsion = c.twist_free ? k_tt - k_lt * k_lt / k_ll : k_tt;

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
    if (c.twist_free) s.extension_twist = -k_lt / ((k_ll * k_tt - k_lt * k_lt) * scale * c.inner_radius);
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

/// Degrees that the nonlinear law tries in turn.
constexpr std::array<int, 3> degrees{7, 11, 15};
// The law covers -0.3 to 0.5 EA: more than a rod meets in a limb, short of where a tube folds.
constexpr double lowest = -0.3, highest = 0.5;
constexpr double node_of_rest = -(highest + lowest) / (highest - lowest);

/// Nodes on [-1, 1] with the unloaded tube among them, and the matrix that takes values at the nodes to coefficients
/// of powers. Chebyshev's nodes, the one nearest to the unloaded tube moved there: so v3'(0) = 1/EA holds exactly.
struct Interpolation {
    int count = 0;
    std::array<double, AxialLaw::max_degree + 1> node{};
    std::array<std::array<double, AxialLaw::max_degree + 1>, AxialLaw::max_degree + 1> power{};  // [power][node]
    int rest = 0;

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
        }
    }
};

const std::array<Interpolation, degrees.size()>& interpolations() {
    static const std::array<Interpolation, degrees.size()> all{Interpolation(degrees[0]), Interpolation(degrees[1]),
                                                               Interpolation(degrees[2])};
    return all;
}

}  // namespace

SectionAtPressure Tube::section(double pressure, SectionModel model, Valve valve, bool derivative) const {
    SectionAtPressure out;
    const double nan = std::numeric_limits<double>::quiet_NaN();
    out.rest_length = nan;
    if (!std::isfinite(pressure)) {
        out.status = SolveStatus::not_finite;
        return out;
    }
    Equilibrium at = solve_unloaded(pressure);
    out.status = at.status;
    out.flags = flags_of(at.shape, pressure);
    if (at.converged() && !at.stable) out.status = SolveStatus::singular_jacobian;

    WallEnergy<double> energy = at.energy;
    Shape<double> tangent_at = at.shape;
    if (wall_.tension_only() && std::abs(pressure) < smallest_pressure()) {
        // Under a vanishing pressure some fibres are slack, in proportions that do not depend on how small it is.
        const Equilibrium near = solve_unloaded(smallest_pressure());
        energy = near.energy, tangent_at = near.shape;
    }
    const double active = length_ - 2.0 * options_.cap_length;
    const SectionConstants constants{length_, active, inner_radius(), area_scale_, mass_, linear_axial_,
                                     linear_bending_, linear_shear_, options_.ends == Ends::free,
                                     valve == Valve::locked};
    SectionValues<double> values = section_values(constants, energy, at.shape);
    Section& section = out.section;
    fill(section, values);
    section.largest_stretch = largest_stretch_;
    out.rest_length = values.rest_length;

    if (model == SectionModel::paper) {
        section.axial = linear_axial_, section.bending = linear_bending_, section.shear = linear_shear_;
        section.torsion = 2.0 * linear_bending_ / 3.0;  // G J with G = E/3 and J = 2 I
        section.rest_twist = section.extension_twist = 0.0;
        section.axial_law.coefficient[0] = 1.0 / section.axial;
    }
    if (derivative) {
        double l = 0.0, w = 1.0, t = 0.0;
        Factor(energy, freedom()).solve(l, w, t);
        const auto moving = [](double value, double slope) { return Dual<1>(value, {slope}); };
        const Shape<Dual<1>> shape{moving(tangent_at.stretch, l), moving(tangent_at.volume, w),
                                   moving(tangent_at.twist, t)};
        const SectionValues<Dual<1>> s = section_values(constants, wall_.energy(shape), shape);
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
        nonlinear_law(at, pressure, valve, derivative, out);
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
    struct Node {
        double value, slope;
        Shape<double> shape;
        bool good;
    };
    const auto solve_at = [&](double force, const Shape<double>& start) {
        const WallLoads loads{force / area_scale_, pressure, 0.0};
        const Equilibrium at = relax(wall_, loads, start, free);
        Node node{0.0, 0.0, at.shape, at.converged() && at.stable};
        node.value = (at.shape.stretch - rest_stretch) * share / force;
        if (derivative) {
            double l = 0.0, w = 0.0, t = 0.0;
            if (free.volume) {
                w = 1.0;
            } else {  // the locked volume itself moves with the pressure
                l = -at.energy.h_lw * d_rest_volume, t = free.twist ? -at.energy.h_wt * d_rest_volume : 0.0;
            }
            Factor(at.energy, free).solve(l, w, t);
            node.slope = ((l - d_rest_stretch) * share - node.value * force * out.d_rest_length / out.rest_length) / force;
        }
        return node;
    };

    const double start_l = section.axial_law.coefficient[0], start_slope = out.d_section.axial_law.coefficient[0];
    for (double half_range = 0.5 * (highest - lowest) * section.axial; half_range > 1e-3 * section.axial;
         half_range *= 0.6) {
        const double centre = -node_of_rest * half_range;
        bool reached = true;
        for (const Interpolation& rule : interpolations()) {
            std::array<double, AxialLaw::max_degree + 1> value{}, slope{};
            std::array<Node, AxialLaw::max_degree + 1> nodes;
            value[rule.rest] = start_l, slope[rule.rest] = start_slope;
            nodes[rule.rest] = {start_l, start_slope, rest.shape, true};
            // Outwards from the unloaded tube, each start extrapolated from the two nodes before it.
            for (const int direction : {1, -1}) {
                for (int i = rule.rest + direction; reached && i >= 0 && i < rule.count; i += direction) {
                    const Node& last = nodes[i - direction];
                    Shape<double> start = last.shape;
                    const int before = i - 2 * direction;
                    if ((i - direction) != rule.rest) {
                        const double ratio = (rule.node[i] - rule.node[i - direction]) /
                                             (rule.node[i - direction] - rule.node[before]);
                        const Shape<double>& b = nodes[before].shape;
                        start.stretch += ratio * (start.stretch - b.stretch);
                        start.volume += ratio * (start.volume - b.volume);
                        start.twist += ratio * (start.twist - b.twist);
                    }
                    nodes[i] = solve_at(centre + half_range * rule.node[i], start);
                    value[i] = nodes[i].value, slope[i] = nodes[i].slope;
                    reached = nodes[i].good;
                }
            }
            if (!reached) break;
            AxialLaw law;
            law.degree = rule.count - 1, law.centre = centre, law.half_range = half_range;
            AxialLaw d_law = law;
            for (int k = 0; k < rule.count; ++k) {
                double sum = 0.0, d_sum = 0.0;
                for (int i = 0; i < rule.count; ++i) {
                    sum += rule.power[k][i] * value[i];
                    d_sum += rule.power[k][i] * slope[i];
                }
                law.coefficient[k] = sum, d_law.coefficient[k] = d_sum;
            }
            // Two forces between nodes near the ends, where an interpolation is worst, judge it.
            double error = 0.0;
            for (const int i : {0, rule.count - 2}) {
                const double force = centre + half_range * 0.5 * (rule.node[i] + rule.node[i + 1]);
                double strain, compliance;
                axial_strain(law, force, strain, compliance);
                error = std::max(error, std::abs(strain - force * solve_at(force, nodes[i].shape).value));
            }
            out.section.axial_law = law;
            if (derivative) out.d_section.axial_law = d_law;
            if (error <= 1e-10) return;
        }
        // A tube that folds inside the range gets a shorter one; one that only needs a higher degree keeps the last.
        if (reached) return;
    }
}

}  // namespace softlimb::actuator
