#pragma once
// The section of a rod from the state of an unloaded tube. Source: cpp/MECHANICS.md, "Section".
#include "softlimb/actuator/unloaded.hpp"

namespace softlimb::actuator {

/// What the formulas need of a tube beside its state. `active` is the length between its caps, `area_scale` pi R_i^2,
/// and the linear stiffnesses are those of the undeformed silicone.
template <class S>
struct SectionConstants {
    S length, active, inner_radius, area_scale, mass;
    S linear_axial, linear_bending, linear_shear;
    bool twist_free, locked, capped;
};

template <class S>
struct SectionValues {
    S rest_length, axial, shear, bending, torsion, mass_per_length, rest_twist, extension_twist, stretch;
};

/// The formulas, for double and for dual numbers alike. Source: cpp/MECHANICS.md, "Section".
template <class S>
SectionValues<S> section_values(const SectionConstants<S>& c, const UnloadedState<S>& at) {
    const Shape<S>& q = at.shape;
    const S& l = q.stretch;
    const AxialStiffness<S>&p = at.open, &k = c.locked ? at.locked : at.open;
    const S open = c.twist_free ? p.ll - p.lt * p.lt / p.tt : p.ll;
    const S axial = c.twist_free ? k.ll - k.lt * k.lt / k.tt : k.ll;
    const S torsion = c.twist_free ? k.tt - k.lt * k.lt / k.ll : k.tt;

    SectionValues<S> s;
    // Caps keep part of the length at rest: the rod of length l is then stiffer by l / (its active part).
    s.rest_length = l * c.active + (c.length - c.active);
    const S per_length = c.capped ? s.rest_length / c.active : l;
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

}  // namespace softlimb::actuator
