#pragma once
// The rod equations and their variations at one point of the rod, for one scalar S (double, a pack of lanes, Dual).
// Nothing here allocates, calls virtually, or knows of steps, plates or Eigen. Source: Zhang et al. eq. 4-6;
// cpp/MECHANICS.md, "Rod".
//
// Only the tangent t = R e3 enters, because the section is transversely isotropic:
//   p' = a n + k t,      k = 1 + strain(n3) + c12 m3 - a n3,        n3 = t.n,  m3 = t.m
//   w  = c m + q t,      q = u3* + c12 n3 + m3/GJ - c m3            (rate of rotation, base axes)
//   t' = w x t = c m x t,   m' = -p' x n - l = -k t x n - l,        n(s) = n(0) - s f
// with a = 1/GA, c = 1/EI. A second director d carries the spin: d' = w x d.
#include "softlimb/always_inline.hpp"
#include "softlimb/vec3.hpp"

namespace softlimb::rod {

/// Loads per rest length, constant along a rod: force [N/m] and moment [N], base axes, dead.
template <class S>
struct LineLoad {
    Vec3<S> force{}, moment{};
};
inline bool is_zero(const LineLoad<double>& load) { return is_zero(load.force) && is_zero(load.moment); }

/// State along a rod: position, tangent t = R e3, director d = R e1, internal moment. The internal force is known
/// in advance: n(s) = n(0) - s f.
template <class S>
struct RodState {
    Vec3<S> position, tangent, director, moment;
};

/// The same of a rod that nothing turns about its tangent (no moment along it, no rest twist, no coupling), or whose
/// spin is not asked for yet: without the director.
template <class S>
struct AxisState {
    Vec3<S> position, tangent, moment;
};

/// What the variations need of one evaluation of the right-hand side.
template <class S>
struct Linearisation {
    Vec3<S> n, m, t, velocity;  // velocity = p'
    S axial_compliance;         // d v3 / d n3
};

/// `K` gives the compliances shear = 1/GA, bending = 1/EI, torsion = 1/GJ, coupling, rest_twist, and the axial law as
/// axial(force, strain, compliance), all over a `unit` of rest length, which rates, and `line_moment`, are then per.
/// `coupled` is what a moment along the tangent adds to the stretch.
template <class S, class K>
SOFTLIMB_ALWAYS_INLINE AxisState<S> axis_rate(const K& k, const Vec3<S>& tangent, const Vec3<S>& moment,
                                              const Vec3<S>& n, const Vec3<S>& line_moment, const S& coupled,
                                              Linearisation<S>& at) {
    const S n3 = dot(tangent, n);
    S strain, axial_compliance;
    k.axial(n3, strain, axial_compliance);
    const S along = k.unit + strain + coupled - k.shear * n3;
    const Vec3<S> velocity = k.shear * n + along * tangent;
    at = {n, moment, tangent, velocity, axial_compliance};
    return {velocity, cross(k.bending * moment, tangent), -along * cross(tangent, n) - line_moment};
}

template <class S, class K>
SOFTLIMB_ALWAYS_INLINE AxisState<S> rate(const K& k, const AxisState<S>& y, const Vec3<S>& n,
                                         const Vec3<S>& line_moment, Linearisation<S>& at) {
    return axis_rate(k, y.tangent, y.moment, n, line_moment, S{}, at);
}

template <class S, class K>
SOFTLIMB_ALWAYS_INLINE RodState<S> rate(const K& k, const RodState<S>& y, const Vec3<S>& n, const Vec3<S>& line_moment,
                                        Linearisation<S>& at) {
    const S n3 = dot(y.tangent, n), m3 = dot(y.tangent, y.moment);
    const S spin = k.rest_twist + k.coupling * n3 + k.torsion * m3 - k.bending * m3;
    const AxisState<S> axis = axis_rate(k, y.tangent, y.moment, n, line_moment, k.coupling * m3, at);
    const Vec3<S> turn = k.bending * y.moment + spin * y.tangent;
    return {axis.position, axis.tangent, cross(turn, y.director), axis.moment};
}

/// A variation: of position, of rotation (base axes) and of moment; that of n is constant along the rod.
template <class S>
struct Variation {
    Vec3<S> position{}, rotation{}, moment{};
};

/// What the changes x and y seen in the section, of force and moment, make of a variation's rate: see `vary`.
template <class S, class K>
SOFTLIMB_ALWAYS_INLINE Variation<S> vary_seen(const K& k, const Linearisation<S>& at, const Vec3<S>& rotation,
                                              const Vec3<S>& x, const Vec3<S>& y) {
    const S tx = dot(at.t, x), ty = dot(at.t, y);
    const S bend = (k.torsion - k.bending) * ty + k.coupling * tx;
    const S pull = (at.axial_compliance - k.shear) * tx + k.coupling * ty;
    const Vec3<S> position = cross(rotation, at.velocity) + k.shear * x + pull * at.t;
    return {position, k.bending * y + bend * at.t, cross(at.n, position)};
}

/// Rate of a variation. With x = dn - dtheta x n and y = dm - dtheta x m (changes seen in the section):
///   dtheta' = c y + [(1/GJ - c) t.y + c12 t.x] t
///   dp'     = dtheta x p' + a x + [(dv3/dn3 - a) t.x + c12 t.y] t
///   dm'     = -dp' x n - p' x dn
template <class S, class K>
SOFTLIMB_ALWAYS_INLINE Variation<S> vary(const K& k, const Linearisation<S>& at, const Vec3<S>& rotation,
                                         const Vec3<S>& moment, const Vec3<S>& force) {
    Variation<S> z = vary_seen(k, at, rotation, force - cross(rotation, at.n), moment - cross(rotation, at.m));
    z.moment += cross(force, at.velocity);
    return z;
}

/// The same where dn is zero.
template <class S, class K>
SOFTLIMB_ALWAYS_INLINE Variation<S> vary(const K& k, const Linearisation<S>& at, const Vec3<S>& rotation,
                                         const Vec3<S>& moment) {
    return vary_seen(k, at, rotation, cross(at.n, rotation), moment - cross(rotation, at.m));
}

}  // namespace softlimb::rod
