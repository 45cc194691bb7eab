#pragma once
// The rod equations and their variations, for one scalar S (double, a pack of lanes, Dual). Nothing here allocates,
// calls virtually, or knows of plates. Source: Zhang et al. eq. 4-6; cpp/MECHANICS.md, "Rod".
//
// Only the tangent t = R e3 enters, because the section is transversely isotropic:
//   p' = a n + k t,      k = 1 + strain(n3) + c12 m3 - a n3,        n3 = t.n,  m3 = t.m
//   w  = c m + q t,      q = u3* + c12 n3 + m3/GJ - c m3            (rate of rotation, base axes)
//   t' = w x t = c m x t,   m' = -p' x n - l = -k t x n - l,        n(s) = n(0) - s f
// with a = 1/GA, c = 1/EI. A second director d carries the spin: d' = w x d.
#include <array>

#include "softlimb/dual.hpp"
#include "softlimb/section.hpp"
#include "softlimb/vec3.hpp"

namespace softlimb::rod {

/// Compliances of a section as the right-hand side uses them.
template <class S>
struct Compliances {
    S shear, bending, torsion, coupling, rest_twist;
    const AxialLaw* axial_law;

    explicit Compliances(const Section& section)
        : shear(1.0 / section.shear),
          bending(1.0 / section.bending),
          torsion(1.0 / section.torsion),
          coupling(section.extension_twist),
          rest_twist(section.rest_twist),
          axial_law(&section.axial_law) {}

    void axial(const S& force, S& strain, S& compliance) const { axial_strain(*axial_law, force, strain, compliance); }
};

/// The same with the derivative to one parameter, of which the section's derivative is given field by field.
template <>
struct Compliances<Dual<1>> {
    Dual<1> shear, bending, torsion, coupling, rest_twist;
    const AxialLaw* axial_law;
    AxialLaw axial_law_slope;  // centre and half_range of the law, coefficients of the derivative

    Compliances(const Section& section, const Section& derivative)
        : shear(inverse(section.shear, derivative.shear)),
          bending(inverse(section.bending, derivative.bending)),
          torsion(inverse(section.torsion, derivative.torsion)),
          coupling(section.extension_twist, {derivative.extension_twist}),
          rest_twist(section.rest_twist, {derivative.rest_twist}),
          axial_law(&section.axial_law),
          axial_law_slope(section.axial_law) {
        axial_law_slope.coefficient = derivative.axial_law.coefficient;
    }

    void axial(const Dual<1>& force, Dual<1>& strain, Dual<1>& compliance) const {
        axial_strain(*axial_law, force, strain, compliance);
        double strain_slope, compliance_slope;
        axial_strain(axial_law_slope, force.value, strain_slope, compliance_slope);
        strain.slope[0] += strain_slope;
        compliance.slope[0] += compliance_slope;
    }

private:
    static Dual<1> inverse(double stiffness, double slope) {
        return {1.0 / stiffness, {-slope / (stiffness * stiffness)}};
    }
};

/// Loads per rest length, constant along a rod: force [N/m] and moment [N], base axes, dead.
template <class S>
struct LineLoad {
    Vec3<S> force{}, moment{};
};

/// State along a rod: position, tangent t = R e3, director d = R e1, internal moment. The internal force is known
/// in advance: n(s) = n(0) - s f.
template <class S>
struct RodState {
    Vec3<S> position, tangent, director, moment;
};

/// What the variations need of one evaluation of the right-hand side.
template <class S>
struct Linearisation {
    Vec3<S> n, m, t, velocity;  // velocity = p'
    S axial_compliance;         // d v3 / d n3
};

template <class S>
inline RodState<S> rate(const Compliances<S>& k, const RodState<S>& y, const Vec3<S>& n, const Vec3<S>& line_moment,
                        Linearisation<S>& at) {
    const S n3 = dot(y.tangent, n), m3 = dot(y.tangent, y.moment);
    S strain, axial_compliance;
    k.axial(n3, strain, axial_compliance);
    const S along = S(1.0) + strain + k.coupling * m3 - k.shear * n3;
    const S spin = k.rest_twist + k.coupling * n3 + k.torsion * m3 - k.bending * m3;
    const Vec3<S> velocity = k.shear * n + along * y.tangent;
    const Vec3<S> bend = k.bending * y.moment;
    at = {n, y.moment, y.tangent, velocity, axial_compliance};
    return {velocity, cross(bend, y.tangent), cross(bend + spin * y.tangent, y.director),
            -along * cross(y.tangent, n) - line_moment};
}

/// C variations side by side: of position, rotation (base axes) and moment; the variation of n is constant, `force`.
template <class S, int C>
struct Columns {
    using Row = std::array<S, C>;
    std::array<Row, 3> position{}, rotation{}, moment{}, force{};
};

/// Rates of the variations. With x = dn - dtheta x n and y = dm - dtheta x m (changes seen in the section):
///   dtheta' = c y + [(1/GJ - c) t.y + c12 t.x] t
///   dp'     = dtheta x p' + a x + [(dv3/dn3 - a) t.x + c12 t.y] t
///   dm'     = -dp' x n - p' x dn
template <class S, int C>
inline void vary(const Compliances<S>& k, const Linearisation<S>& at, const std::array<std::array<S, C>, 3>& rotation,
                 const std::array<std::array<S, C>, 3>& moment, const std::array<std::array<S, C>, 3>& force,
                 Columns<S, C>& out) {
    const auto& [n, m, t, v, axial] = at;
    const S a = k.shear, c = k.bending, axial_less_a = axial - k.shear, torsion_less_c = k.torsion - k.bending;
    for (int i = 0; i < C; ++i) {
        const S qx = rotation[0][i], qy = rotation[1][i], qz = rotation[2][i];
        const S fx = force[0][i], fy = force[1][i], fz = force[2][i];
        const S xx = fx - (qy * n.z - qz * n.y), xy = fy - (qz * n.x - qx * n.z), xz = fz - (qx * n.y - qy * n.x);
        const S yx = moment[0][i] - (qy * m.z - qz * m.y), yy = moment[1][i] - (qz * m.x - qx * m.z),
                yz = moment[2][i] - (qx * m.y - qy * m.x);
        const S tx = t.x * xx + t.y * xy + t.z * xz, ty = t.x * yx + t.y * yy + t.z * yz;
        const S bend = torsion_less_c * ty + k.coupling * tx, pull = axial_less_a * tx + k.coupling * ty;
        out.rotation[0][i] = c * yx + bend * t.x;
        out.rotation[1][i] = c * yy + bend * t.y;
        out.rotation[2][i] = c * yz + bend * t.z;
        const S px = qy * v.z - qz * v.y + a * xx + pull * t.x, py = qz * v.x - qx * v.z + a * xy + pull * t.y,
                pz = qx * v.y - qy * v.x + a * xz + pull * t.z;
        out.position[0][i] = px, out.position[1][i] = py, out.position[2][i] = pz;
        out.moment[0][i] = -(py * n.z - pz * n.y) - (v.y * fz - v.z * fy);
        out.moment[1][i] = -(pz * n.x - px * n.z) - (v.z * fx - v.x * fz);
        out.moment[2][i] = -(px * n.y - py * n.x) - (v.x * fy - v.y * fx);
    }
}

/// No variations: the state alone.
template <class S>
struct Columns<S, 0> {};

/// Advances state, force and variations over `length` in `steps` equal steps of the explicit tableau `Method`.
template <class Method, int C, class S>
inline void advance(const Compliances<S>& k, const LineLoad<S>& load, const S& length, int steps, Vec3<S>& n,
                    RodState<S>& y, Columns<S, C>& z) {
    constexpr int stages = Method::stages;
    const S h = length * (1.0 / steps);
    std::array<RodState<S>, stages> dy;
    [[maybe_unused]] std::array<Columns<S, C>, stages> dz;
    for (int step = 0; step < steps; ++step) {
        for (int i = 0; i < stages; ++i) {
            RodState<S> at = y;
            for (int j = 0; j < i; ++j) {
                if (Method::a[i][j] == 0.0) continue;
                const S w = h * S(Method::a[i][j]);
                at.tangent += w * dy[j].tangent, at.director += w * dy[j].director, at.moment += w * dy[j].moment;
            }
            Linearisation<S> linear;
            dy[i] = rate(k, at, n - (h * S(Method::c[i])) * load.force, load.moment, linear);
            if constexpr (C > 0) {
                std::array<std::array<S, C>, 3> rotation = z.rotation, moment = z.moment;
                for (int j = 0; j < i; ++j) {
                    if (Method::a[i][j] == 0.0) continue;
                    const S w = h * S(Method::a[i][j]);
                    for (int r = 0; r < 3; ++r)
                        for (int column = 0; column < C; ++column) {
                            rotation[r][column] += w * dz[j].rotation[r][column];
                            moment[r][column] += w * dz[j].moment[r][column];
                        }
                }
                vary<S, C>(k, linear, rotation, moment, z.force, dz[i]);
            }
        }
        for (int i = 0; i < stages; ++i) {
            if (Method::b[i] == 0.0) continue;
            const S w = h * S(Method::b[i]);
            y.position += w * dy[i].position, y.tangent += w * dy[i].tangent;
            y.director += w * dy[i].director, y.moment += w * dy[i].moment;
            if constexpr (C > 0)
                for (int r = 0; r < 3; ++r)
                    for (int column = 0; column < C; ++column) {
                        z.position[r][column] += w * dz[i].position[r][column];
                        z.rotation[r][column] += w * dz[i].rotation[r][column];
                        z.moment[r][column] += w * dz[i].moment[r][column];
                    }
        }
        n += -h * load.force;
    }
    // The directors leave orthonormality only by the integration error: take it out.
    y.tangent = normalised(y.tangent);
    y.director = normalised(y.director - dot(y.director, y.tangent) * y.tangent);
}

}  // namespace softlimb::rod
