#pragma once
// A tube under pressure alone: its shape and its stiffness along the axis as functions of the pressure. A section
// follows from these numbers without another solve. Source: cpp/MECHANICS.md, "Tables".
#include "softlimb/actuator/equilibrium.hpp"
#include "softlimb/actuator/piecewise.hpp"
#include "softlimb/actuator/wall.hpp"
#include "softlimb/dual.hpp"

namespace softlimb::actuator {

/// Hessian in (stretch, twist) where the volume is condensed (constant pressure) or held [Pa].
template <class S>
struct AxialStiffness {
    S ll, lt, tt;
};

template <class S>
struct UnloadedState {
    Shape<S> shape;
    AxialStiffness<S> open, locked;  // at constant pressure, at constant volume
};

template <class S>
UnloadedState<S> unloaded_state(const WallEnergy<S>& e, const Shape<S>& q) {
    const S by_pressure = 1.0 / e.h_ww;
    return {q,
            {e.h_ll - e.h_lw * e.h_lw * by_pressure, e.h_lt - e.h_lw * e.h_wt * by_pressure,
             e.h_tt - e.h_wt * e.h_wt * by_pressure},
            {e.h_ll, e.h_lt, e.h_tt}};
}

/// Unloaded states from rest up to where the wall's finer quadrature takes over, or the path ends.
class UnloadedTable {
public:
    /// `pressure_scale` [Pa] is a small pressure of the tube.
    UnloadedTable(const Wall& wall, Freedom free, double pressure_scale, const Path& path);

    /// The state at a pressure, or the part of it that is wanted; false where the table has none, and a solve must find
    /// it.
    enum class Part { shape, open, all };  // each with those before it
    bool at(double pressure, Part part, UnloadedState<double>& state) const;
    /// With its slope to the pressure.
    bool at(double pressure, Part part, UnloadedState<Dual<1>>& state) const;

private:
    Piecewise<9> curves_;
};

}  // namespace softlimb::actuator
