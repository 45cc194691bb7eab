#include "softlimb/sweep/parameters.hpp"

#include <algorithm>
#include <array>

#include "softlimb/arguments.hpp"
#include "softlimb/materials/coefficients.hpp"

namespace softlimb::sweep {
namespace {

using actuator::TubeParameter;
using Kind = Parameter::Kind;

bool has(const actuator::Tube& tube, const TubeParameter& parameter) {
    const int layers = static_cast<int>(tube.layers().size()), number = parameter.number;
    switch (parameter.kind) {
        case TubeParameter::Kind::radius:
            return number >= 0 && number <= layers;
        case TubeParameter::Kind::mass:
            return tube.options().mass.has_value();
        case TubeParameter::Kind::angle:
        case TubeParameter::Kind::fraction:
        case TubeParameter::Kind::modulus:
        case TubeParameter::Kind::stiffness:
        case TubeParameter::Kind::coefficient:
        case TubeParameter::Kind::density: {
            if (parameter.layer < 0 || parameter.layer >= layers || number < 0) return false;
            const actuator::Layer& layer = tube.layers()[parameter.layer];
            if (parameter.kind == TubeParameter::Kind::density) return true;
            if (parameter.kind == TubeParameter::Kind::coefficient)
                return number < static_cast<int>(materials::coefficient_names(layer.law).size());
            const auto has_family = [&](int family) {
                if (family >= static_cast<int>(layer.fibres.size())) return false;
                const bool by_modulus = layer.fibres[family].modulus > 0.0;
                return parameter.kind == TubeParameter::Kind::angle ||
                       (parameter.kind == TubeParameter::Kind::stiffness) != by_modulus;
            };
            return has_family(number) && (parameter.twin < 0 || has_family(parameter.twin));
        }
        default:
            return true;
    }
}

/// Rate of a section as field `component` of it grows.
Section section_field(const Section& section, int component) {
    Section rate{};
    const std::array fields = {&Section::axial,          &Section::shear,           &Section::bending,
                               &Section::torsion,        &Section::mass_per_length, &Section::rest_twist,
                               &Section::extension_twist};
    rate.*fields[component] = 1.0;
    if (component == 0) rate.axial_law.coefficient[0] = -1.0 / (section.axial * section.axial);
    return rate;
}

constexpr int section_fields = 7;

}  // namespace

void check(const Parameters& parameters, const Members& members, const limb::Geometry& geometry) {
    for (const Parameter& p : parameters.list) {
        const bool of_plate = p.kind == Kind::plate_thickness || p.kind == Kind::plate_mass || p.kind == Kind::wrench;
        const int places = p.kind == Kind::gravity ? 1 : of_plate ? geometry.plates() : members.rods();
        if (p.place < 0 || p.place >= places) reject("place of a parameter", p.place, "one that the limb has");
        if (p.column < 0 || p.column >= parameters.columns)
            reject("column of a parameter", p.column, "below the number of columns");
        const int components = p.kind == Kind::rod_section                             ? section_fields
                               : p.kind == Kind::wrench                                ? 6
                               : p.kind == Kind::gravity || p.kind == Kind::line_force ? 3
                                                                                       : 1;
        if (p.component < 0 || p.component >= components)
            reject("component of a parameter", p.component, "below " + std::to_string(components));
        if (p.kind != Kind::tube && p.kind != Kind::rod_section && p.kind != Kind::rod_length) continue;
        const Member& member = members.all()[p.place];
        const bool known = p.kind == Kind::tube ? member.tube && has(*member.tube, p.tube) : !member.tube;
        if (!known) reject("parameter of member", p.place, "one that this member has");
    }
}

std::vector<limb::SceneRate> rates_of(const Parameters& parameters, const Members& members, const limb::Scene& scene,
                                      const double* pressures, actuator::SectionModel model, actuator::Valve valve) {
    std::vector<limb::SceneRate> rates(parameters.columns);
    std::vector<std::vector<TubeParameter>> asked(members.rods());
    for (const Parameter& p : parameters.list)
        if (p.kind == Kind::tube) asked[p.place].push_back(p.tube);
    std::vector<std::vector<actuator::SectionSlope>> slopes(members.rods());
    const std::vector<int>& driven = members.driven();
    for (std::size_t a = 0; a < driven.size(); ++a) {
        const int rod = driven[a];
        if (asked[rod].empty()) continue;
        const actuator::Tube& tube = *members.all()[rod].tube;
        std::size_t twin = 0;
        const auto equals = [&](std::size_t other) {
            const actuator::Tube& its = *members.all()[driven[other]].tube;
            return pressures[other] == pressures[a] && (&its == &tube || its == tube) &&
                   std::equal(asked[driven[other]].begin(), asked[driven[other]].end(), asked[rod].begin(),
                              asked[rod].end());
        };
        while (twin < a && !equals(twin)) ++twin;
        if (twin < a)
            slopes[rod] = slopes[driven[twin]];
        else
            tube.section_slopes(pressures[a], model, valve, asked[rod], slopes[rod]);
    }
    std::vector<std::size_t> next(members.rods(), 0);
    for (const Parameter& p : parameters.list) {
        limb::SceneRate& rate = rates[p.column];
        limb::RodRate rod;
        switch (p.kind) {
            case Kind::tube: {
                const actuator::SectionSlope& slope = slopes[p.place][next[p.place]++];
                rod.section = slope.section, rod.rest_length = slope.rest_length;
                rate.rod(p.place).add(p.factor, rod);
                break;
            }
            case Kind::rod_section:
                rod.section = section_field(scene.rods[p.place].section, p.component);
                rate.rod(p.place).add(p.factor, rod);
                break;
            case Kind::rod_length:
                rate.rod(p.place).rest_length += p.factor;
                break;
            case Kind::placement:
                rate.rod(p.place).base += p.factor * p.direction.head<6>();
                rate.rod(p.place).end += p.factor * p.direction.tail<6>();
                break;
            case Kind::line_force:
                rate.rod(p.place).line_force(p.component) += p.factor;
                break;
            case Kind::plate_thickness:
                rate.plate(p.place).thickness += p.factor;
                break;
            case Kind::plate_mass:
                rate.plate(p.place).mass += p.factor;
                break;
            case Kind::wrench:
                rate.plate(p.place).wrench(p.component) += p.factor;
                break;
            case Kind::gravity:
                rate.gravity(p.component) += p.factor;
                break;
        }
    }
    return rates;
}

}  // namespace softlimb::sweep
