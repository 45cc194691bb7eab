#pragma once
// Explicit Runge-Kutta integration of the rod equations and of C variations, for one scalar S (double, Dual, the
// number of an instruction set): the plain version, for which any method of the list serves. The lanes (rod/lanes/)
// integrate many pieces side by side with the same equations. Source: cpp/MECHANICS.md, "Rod".
#include <array>

#include "softlimb/dual.hpp"
#include "softlimb/rod/equations.hpp"
#include "softlimb/section.hpp"
#include "softlimb/unrolled.hpp"

namespace softlimb::rod {

/// Compliances of a section as the right-hand side uses them.
template <class S>
struct Compliances {
    S unit{1.0};  // everything is per rest length
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
    Dual<1> unit{1.0};
    Dual<1> shear, bending, torsion, coupling, rest_twist;
    const AxialLaw *axial_law, *axial_law_rate;

    Compliances(const Section& section, const Section& derivative)
        : shear(inverse(section.shear, derivative.shear)),
          bending(inverse(section.bending, derivative.bending)),
          torsion(inverse(section.torsion, derivative.torsion)),
          coupling(section.extension_twist, {derivative.extension_twist}),
          rest_twist(section.rest_twist, {derivative.rest_twist}),
          axial_law(&section.axial_law),
          axial_law_rate(&derivative.axial_law) {}

    void axial(const Dual<1>& force, Dual<1>& strain, Dual<1>& compliance) const {
        axial_strain(*axial_law, force, strain, compliance);
        double strain_rate, compliance_rate;
        axial_strain_rate(*axial_law, *axial_law_rate, force.value, strain_rate, compliance_rate);
        strain.slope[0] += strain_rate;
        compliance.slope[0] += compliance_rate;
    }

private:
    static Dual<1> inverse(double stiffness, double slope) {
        return {1.0 / stiffness, {-slope / (stiffness * stiffness)}};
    }
};

/// C variations and the constant variation of n that belongs to each.
template <class S, int C>
struct Columns {
    std::array<Variation<S>, C> column{};
    std::array<Vec3<S>, C> force{};
};

/// y + w dy: of what rates depend on, and with the position.
template <class S>
SOFTLIMB_ALWAYS_INLINE void add_but_position(AxisState<S>& y, const S& w, const AxisState<S>& dy) {
    y.tangent += w * dy.tangent, y.moment += w * dy.moment;
}
template <class S>
SOFTLIMB_ALWAYS_INLINE void add_but_position(RodState<S>& y, const S& w, const RodState<S>& dy) {
    y.tangent += w * dy.tangent, y.director += w * dy.director, y.moment += w * dy.moment;
}
template <class S, template <class> class State>
SOFTLIMB_ALWAYS_INLINE void add(State<S>& y, const S& w, const State<S>& dy) {
    y.position += w * dy.position;
    add_but_position(y, w, dy);
}

/// Directors leave orthonormality only by the integration error: takes it out.
template <class S>
SOFTLIMB_ALWAYS_INLINE void orthonormalise(AxisState<S>& y) {
    y.tangent = normalised(y.tangent);
}
template <class S>
SOFTLIMB_ALWAYS_INLINE void orthonormalise(RodState<S>& y) {
    y.tangent = normalised(y.tangent);
    y.director = normalised(y.director - dot(y.director, y.tangent) * y.tangent);
}

/// Advances state, force and variations over `length` in `steps` equal steps of the explicit tableau `Method`.
template <class Method, int C, class S, template <class> class State>
inline void advance(const Compliances<S>& k, const LineLoad<S>& load, const S& length, int steps, Vec3<S>& n,
                    State<S>& y, Columns<S, C>& z) {
    constexpr int stages = Method::stages;
    const S h = length * (1.0 / steps);
    std::array<State<S>, stages> dy;
    std::array<std::array<Variation<S>, C>, stages> dz;
    for (int step = 0; step < steps; ++step) {
        unrolled<0, stages>([&](auto stage) SOFTLIMB_LAMBDA_INLINE {
            constexpr int i = stage;
            State<S> at = y;
            std::array<Variation<S>, C> varied = z.column;
            unrolled<0, i>([&](auto before) SOFTLIMB_LAMBDA_INLINE {
                constexpr int j = before;
                if constexpr (Method::a[i][j] != 0.0) {
                    const S w = h * S(Method::a[i][j]);
                    add_but_position(at, w, dy[j]);
                    for (int c = 0; c < C; ++c)
                        varied[c].rotation += w * dz[j][c].rotation, varied[c].moment += w * dz[j][c].moment;
                }
            });
            Linearisation<S> linear;
            dy[i] = rate(k, at, n - (h * S(Method::c[i])) * load.force, load.moment, linear);
            for (int c = 0; c < C; ++c) dz[i][c] = vary(k, linear, varied[c].rotation, varied[c].moment, z.force[c]);
        });
        unrolled<0, stages>([&](auto stage) SOFTLIMB_LAMBDA_INLINE {
            constexpr int i = stage;
            if constexpr (Method::b[i] != 0.0) {
                const S w = h * S(Method::b[i]);
                add(y, w, dy[i]);
                for (int c = 0; c < C; ++c) {
                    Variation<S>& out = z.column[c];
                    out.position += w * dz[i][c].position, out.rotation += w * dz[i][c].rotation;
                    out.moment += w * dz[i][c].moment;
                }
            }
        });
        n += -h * load.force;
    }
    orthonormalise(y);
}

}  // namespace softlimb::rod
