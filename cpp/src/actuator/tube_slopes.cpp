// Derivatives of a tube's section to the numbers that the tube is made of: the equilibrium of its wall, differentiated.
// Source: cpp/MECHANICS.md, "Derivatives".
#include <cmath>
#include <numbers>
#include <optional>

#include "softlimb/actuator/section_values.hpp"
#include "softlimb/actuator/tube.hpp"
#include "softlimb/materials/coefficients.hpp"

namespace softlimb::actuator {

using solve::SolveStatus;

namespace {

using std::numbers::pi;

/// Every number of an energy, turned by `take` into a plain one.
template <class S, class Take>
WallEnergy<double> taken(const WallEnergy<S>& e, Take&& take) {
    return {take(e.value), take(e.g_l),  take(e.g_w),  take(e.g_t),  take(e.h_ll),
            take(e.h_lw),  take(e.h_lt), take(e.h_ww), take(e.h_wt), take(e.h_tt)};
}

double families_in(const TubeParameter& parameter) { return parameter.twin >= 0 ? 2.0 : 1.0; }

Dual<1> moving(double value, double slope) { return {value, {slope}}; }

SectionConstants<Dual<1>> moving(const SectionConstants<double>& c, const SectionConstants<double>& d) {
    // With caps: at none the formula is the same, and its derivative to their length is in it.
    return {moving(c.length, d.length),
            moving(c.active, d.active),
            moving(c.inner_radius, d.inner_radius),
            moving(c.area_scale, d.area_scale),
            moving(c.mass, d.mass),
            moving(c.linear_axial, d.linear_axial),
            moving(c.linear_bending, d.linear_bending),
            moving(c.linear_shear, d.linear_shear),
            c.twist_free,
            c.locked,
            true};
}

}  // namespace

void Tube::write_slope(const SectionValues<Dual<1>>& s, const SectionConstants<double>& d_constants, SectionModel model,
                       SectionSlope& slope) const {
    const double axial = model == SectionModel::paper ? linear_axial_ : s.axial.value;
    Section& out = slope.section;
    slope.rest_length = s.rest_length.slope[0];
    out.mass_per_length = s.mass_per_length.slope[0], out.stretch = s.stretch.slope[0];
    if (model == SectionModel::paper) {
        out.axial = d_constants.linear_axial, out.bending = d_constants.linear_bending,
        out.shear = d_constants.linear_shear;
        out.torsion = 2.0 * d_constants.linear_bending / 3.0;
    } else {
        out.axial = s.axial.slope[0], out.shear = s.shear.slope[0], out.bending = s.bending.slope[0];
        out.torsion = s.torsion.slope[0], out.rest_twist = s.rest_twist.slope[0];
        out.extension_twist = s.extension_twist.slope[0];
    }
    out.axial_law.coefficient[0] = -out.axial / (axial * axial);
}

SectionSlope Tube::section_slope(double pressure, SectionModel model, Valve valve) const {
    // Out of the table where it reaches. At rest a tension-only tube has a corner, and its first piece begins there.
    UnloadedState<Dual<1>> state{};
    if (model != SectionModel::nonlinear && std::abs(pressure) > smallest_pressure() &&
        table_.at(pressure, part_for(valve), state)) {
        SectionSlope slope;
        const SectionConstants<double> unmoved{};
        write_slope(section_values(moving(constants(valve), unmoved), state), unmoved, model, slope);
        return slope;
    }
    std::vector<SectionSlope> slopes;
    section_slopes(pressure, model, valve, {{TubeParameter::Kind::pressure}}, slopes);
    return slopes[0];
}

void Tube::section_slopes(double pressure, SectionModel model, Valve valve,
                          const std::vector<TubeParameter>& parameters, std::vector<SectionSlope>& slopes) const {
    slopes.assign(parameters.size(), {});
    const SectionConstants<double> c = constants(valve);
    Section section;
    double rest_length;
    if (linear_section(pressure, model, valve, section, rest_length) == SolveStatus::not_finite) return;
    const Equilibrium rest = solve_unloaded(pressure);
    const bool vanishing = wall_.tension_only() && std::abs(pressure) < smallest_pressure();
    const Shape<double> q = vanishing ? solve_unloaded(smallest_pressure()).shape : rest.shape;
    // Values and slopes to stretch and volume, at the very shape. Those to the twist only where something twists.
    const WallEnergy<Dual<2>> third =
        wall_.energy(Shape<Dual<2>>{Dual<2>::variable(q.stretch, 0), Dual<2>::variable(q.volume, 1), Dual<2>(q.twist)});
    std::optional<WallEnergy<double>> by_twist;
    const auto add_along = [&](const Shape<double>& d, WallEnergy<double>& change) {
        change.add(1.0, taken(third, [&](const Dual<2>& x) { return x.slope[0] * d.stretch + x.slope[1] * d.volume; }));
        if (d.twist == 0.0) return;
        if (!by_twist)
            by_twist = taken(wall_.energy(Shape<Dual<1>>{q.stretch, q.volume, Dual<1>::variable(q.twist, 0)}),
                             [](const Dual<1>& x) { return x.slope[0]; });
        change.add(d.twist, *by_twist);
    };
    const WallEnergy<double> e = taken(third, [](const Dual<2>& x) { return x.value; });
    const Freedom free = freedom();
    const Factor factor(e, free);
    AxialNodes nodes;
    std::vector<WallEnergy<double>> at_node;
    if (model == SectionModel::nonlinear) {
        nodes = nonlinear_law(rest, pressure, valve, rest_length, section);
        for (int i = 0; i < nodes.count; ++i) at_node.push_back(wall_.energy(nodes.shape[i]));
    }

    for (std::size_t i = 0; i < parameters.size(); ++i) {
        // The balance of the wall, gradient = (0, P, 0), as shape and parameter move together.
        const TubeParameter& parameter = parameters[i];
        const double d_pressure = parameter.kind == TubeParameter::Kind::pressure ? 1.0 : 0.0;
        WallEnergy<double> change = energy_slope(parameter, q);
        Shape<double> d{-change.g_l, d_pressure - change.g_w, free.twist ? -change.g_t : 0.0};
        factor.solve(d.stretch, d.volume, d.twist);
        add_along(d, change);
        const WallEnergy<Dual<1>> moved{moving(e.value, change.value), moving(e.g_l, change.g_l),
                                        moving(e.g_w, change.g_w),     moving(e.g_t, change.g_t),
                                        moving(e.h_ll, change.h_ll),   moving(e.h_lw, change.h_lw),
                                        moving(e.h_lt, change.h_lt),   moving(e.h_ww, change.h_ww),
                                        moving(e.h_wt, change.h_wt),   moving(e.h_tt, change.h_tt)};
        const Shape<Dual<1>> shape{moving(q.stretch, d.stretch), moving(q.volume, d.volume), moving(q.twist, d.twist)};
        const SectionConstants<double> dc = constants_slope(parameter);
        const SectionValues<Dual<1>> s = section_values(moving(c, dc), unloaded_state(moved, shape));

        write_slope(s, dc, model, slopes[i]);
        Section& out = slopes[i].section;
        if (nodes.count == 0) continue;

        const Freedom loaded{true, valve == Valve::open, free.twist};
        const double share = c.active / rest_length;
        const double d_share = share * (dc.active / c.active - slopes[i].rest_length / rest_length);
        // The nodes stand at shares of a stiffness, and move with it.
        const double d_range =
            out.bending / section.bending + dc.linear_axial / c.linear_axial - dc.linear_bending / c.linear_bending;
        AxialNodes::Values d_value{};
        for (int k = 0; k < nodes.count; ++k) {
            if (k == nodes.rest) {
                d_value[k] = out.axial_law.coefficient[0];
                continue;
            }
            const WallEnergy<double>& there = at_node[k];
            const WallEnergy<double> by = energy_slope(parameter, nodes.shape[k]);
            const double d_force = -nodes.force[k] * dc.area_scale / (c.area_scale * c.area_scale);
            double l = d_force - by.g_l, w = d_pressure - by.g_w, t = free.twist ? -by.g_t : 0.0;
            if (!loaded.volume) {  // the locked volume moves as that of the unloaded tube
                l -= there.h_lw * d.volume, w = 0.0;
                if (free.twist) t -= there.h_wt * d.volume;
            }
            Factor(there, loaded).solve(l, w, t);
            d_value[k] =
                ((l - d.stretch) * share + (nodes.shape[k].stretch - rest.shape.stretch) * d_share) / nodes.force[k];
            double along = 1.0, w_along = 0.0, t_along = 0.0;
            Factor(there, loaded).solve(along, w_along, t_along);
            d_value[k] += d_range * (along * share / c.area_scale - nodes.value[k]);
        }
        const AxialLaw& law = section.axial_law;
        out.axial_law.degree = law.degree;
        out.axial_law.coefficient = coefficients_of(d_value);
        out.axial_law.centre = d_range * law.centre, out.axial_law.half_range = d_range * law.half_range;
    }
}

SectionConstants<double> Tube::constants_slope(const TubeParameter& parameter) const {
    using Kind = TubeParameter::Kind;
    SectionConstants<double> d{};
    double d_silicone_mass = 0.0;
    const auto stiffen = [&](const Layer& layer, double modulus) {
        d.linear_axial += 3.0 * modulus * layer.area(), d.linear_shear += modulus * layer.area();
        d.linear_bending += 3.0 * modulus * layer.second_moment();
    };
    // The face at a radius grows by 2 pi r, outwards of a layer as `side` = 1, inwards as -1.
    const auto widen = [&](const Layer& layer, double r, double side) {
        const double modulus = layer.silicone_fraction() * layer.shear_modulus(), area = side * 2.0 * pi * r;
        d.linear_axial += 3.0 * modulus * area, d.linear_shear += modulus * area;
        d.linear_bending += 3.0 * modulus * 0.5 * area * r * r;
        d_silicone_mass += layer.density() * area * length_;
    };
    switch (parameter.kind) {
        case Kind::length:
            d.length = d.active = 1.0, d_silicone_mass = mass_ / length_;
            break;
        case Kind::mass:
            d.mass = 1.0;
            break;
        case Kind::cap_length:
            d.active = -2.0;
            break;
        case Kind::radius: {
            const std::size_t face = parameter.number;
            if (face == 0) d.inner_radius = 1.0, d.area_scale = 2.0 * pi * inner_radius();
            if (face > 0) widen(layers_[face - 1], layers_[face - 1].outer, 1.0);
            if (face < layers_.size()) widen(layers_[face], layers_[face].inner, -1.0);
            break;
        }
        case Kind::fraction:
            stiffen(layers_[parameter.layer], -families_in(parameter) * layers_[parameter.layer].shear_modulus());
            break;
        case Kind::coefficient: {
            const Layer& layer = layers_[parameter.layer];
            const double modulus = materials::by_coefficient(layer.law, parameter.number, 1.0, [](const auto& law) {
                return std::visit([](const auto& l) { return l.shear_modulus(); }, law);
            });
            stiffen(layer, layer.silicone_fraction() * modulus);
            break;
        }
        case Kind::density:
            d_silicone_mass = layers_[parameter.layer].area() * length_;
            break;
        default:  // the pressure, and fibres beside the silicone
            break;
    }
    if (!options_.mass) d.mass += d_silicone_mass;
    return d;
}

WallEnergy<double> Tube::energy_slope(const TubeParameter& parameter, const Shape<double>& q) const {
    using Kind = TubeParameter::Kind;
    WallEnergy<double> d;
    const int layer = parameter.layer;
    const auto each_family = [&](auto&& use) {
        use(layers_[layer].fibres[parameter.number], 1.0);
        if (parameter.twin >= 0) use(layers_[layer].fibres[parameter.twin], -1.0);
    };
    switch (parameter.kind) {
        case Kind::radius: {
            // Scaled by the inner radius: s = (R/R_i)^2 of one face moves, or with R_i those of all faces.
            const double r = inner_radius();
            const auto move_face = [&](std::size_t face, double by) {
                d.add(by, wall_.at_face(static_cast<int>(face) - 1, true, q));
                if (face < layers_.size()) d.add(-by, wall_.at_face(static_cast<int>(face), false, q));
            };
            if (parameter.number > 0) {
                move_face(parameter.number, 2.0 * layers_[parameter.number - 1].outer / (r * r));
            } else {
                for (std::size_t face = 1; face <= layers_.size(); ++face)
                    move_face(face, -2.0 * wall_.layers()[face - 1].s_out / r);
            }
            break;
        }
        case Kind::angle:
            each_family([&](const Fibres& family, double sign) {
                d.add(sign * family.stiffness, wall_.fibres_by_angle(layer, family.angle, q));
            });
            break;
        case Kind::fraction:
            each_family(
                [&](const Fibres& family, double) { d.add(family.modulus, wall_.fibres(layer, family.angle, q)); });
            d.add(-families_in(parameter), wall_.silicone(layer, layers_[layer].law, q));
            break;
        case Kind::modulus:
            each_family(
                [&](const Fibres& family, double) { d.add(family.fraction, wall_.fibres(layer, family.angle, q)); });
            break;
        case Kind::stiffness:
            each_family([&](const Fibres& family, double) { d.add(1.0, wall_.fibres(layer, family.angle, q)); });
            break;
        case Kind::coefficient: {
            const materials::AnyLaw& law = layers_[layer].law;
            // Gent's law ends where I1 - 3 reaches its limit, an exponent's singularity is zero.
            double reach = materials::coefficient(law, parameter.number);
            if (std::holds_alternative<materials::Gent>(law)) reach -= wall_.largest_invariant(q);
            d.add(layers_[layer].silicone_fraction(),
                  materials::by_coefficient(law, parameter.number, reach, [&](const materials::AnyLaw& changed) {
                      return wall_.silicone(layer, changed, q);
                  }));
            break;
        }
        default:  // no part of the wall
            break;
    }
    return d;
}

}  // namespace softlimb::actuator
