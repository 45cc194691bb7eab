// Parts of a wall's energy at a given shape: what its derivatives to layers, fibres and laws are made of.
// Source: cpp/MECHANICS.md, "Derivatives".
#include <cmath>

#include "softlimb/actuator/wall.hpp"

namespace softlimb::actuator {
namespace {

/// The integrand of a layer's silicone at some points.
WallEnergy<double> silicone_at(const materials::AnyLaw& law, const WallLayer& layer,
                               const std::vector<WallPoint>& points, const Shape<double>& q) {
    WallEnergy<double> e;
    const detail::ShapeTerms<double> terms(q);
    std::visit(
        [&](const auto& l) {
            if (detail::exactly_zero(q.twist))
                detail::add_silicone<false>(l, layer, points, terms, e);
            else
                detail::add_silicone<true>(l, layer, points, terms, e);
        },
        law);
    return e;
}

}  // namespace

WallEnergy<double> Wall::silicone(int layer, const materials::AnyLaw& law, const Shape<double>& q) const {
    const WallLayer& at = layers_[layer];
    WallEnergy<double> part;
    part.add(1.0 / at.silicone, silicone_at(law, at, strained(q) ? at.fine_points : at.points, q));
    return part;
}

template <class S, class A>
WallEnergy<S> Wall::fibres(int layer, const A& cosine, const A& sine, const Shape<S>& q) const {
    const WallLayer& at = layers_[layer];
    const WallFamilyOf<A> family{cosine, sine, 1.0, false};
    WallEnergy<S> e;
    if (tension_only_) {
        add_partly_slack<true>(at, family, q, e);
        return e;
    }
    const detail::ShapeTerms<S> terms(q);
    for (const WallPoint& p : strained(detail::plain(q)) ? at.fine_points : at.points)
        detail::add_fibre<true>(terms, p.s, p.inverse_r, cosine, sine, p.weight, e);
    return e;
}

WallEnergy<double> Wall::fibres(int layer, double angle, const Shape<double>& q) const {
    return fibres(layer, std::cos(angle), std::sin(angle), q);
}

WallEnergy<double> Wall::fibres_by_angle(int layer, double angle, const Shape<double>& q) const {
    using S = Dual<1>;
    const double cosine = std::cos(angle), sine = std::sin(angle);
    const WallEnergy<S> e =
        fibres(layer, S(cosine, {-sine}), S(sine, {cosine}), Shape<S>{S(q.stretch), S(q.volume), S(q.twist)});
    return {e.value.slope[0], e.g_l.slope[0],  e.g_w.slope[0],  e.g_t.slope[0],  e.h_ll.slope[0],
            e.h_lw.slope[0],  e.h_lt.slope[0], e.h_ww.slope[0], e.h_wt.slope[0], e.h_tt.slope[0]};
}

WallEnergy<double> Wall::at_face(int layer, bool outer, const Shape<double>& q) const {
    // An integral over s changes with its end by the integrand there.
    const WallLayer& at = layers_[layer];
    const double s = outer ? at.s_out : at.s_in, x = outer ? at.x_out : at.x_in;
    WallEnergy<double> e = silicone_at(at.law, at, {{s, 1.0 / s, std::exp(-0.5 * x), 1.0}}, q);
    const detail::ShapeTerms<double> terms(q);
    for (const WallFamily& family : at.families)
        for (int side = 0; side < (family.mirrored ? 2 : 1); ++side) {
            const double sine = side == 0 ? family.sine : -family.sine;
            if (tension_only_) {
                double squared, slope;
                squared_stretch(WallFamily{family.cosine, sine, family.stiffness, false}, q, x, squared, slope);
                if (squared < 1.0) continue;
            }
            detail::add_fibre<true>(terms, s, std::exp(-0.5 * x), family.cosine, sine, family.stiffness, e);
        }
    return e;
}

}  // namespace softlimb::actuator
