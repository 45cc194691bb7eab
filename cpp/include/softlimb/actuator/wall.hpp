#pragma once
// Energy of a thick-walled tube that is stretched, inflated and twisted evenly, with its gradient and Hessian.
//
// Scaled: lengths by the inner radius R_i, so that the unknowns q = (lz, w, gamma) are
//   lz    : axial stretch,
//   w     : volume over undeformed volume, v / R_i^2 = lz (r_i / R_i)^2,
//   gamma : twist per reference length times R_i.
// With s = (R/R_i)^2 as coordinate through the wall, incompressibility gives (r/R_i)^2 = rho = (s + w - 1)/lz, and
//   a = s / ((s + w - 1) lz),  t = rho (1/s + gamma^2) + lz^2,                       for the silicone's W(a, t)
//   I4 = rho (cos(alpha)/sqrt(s) + gamma sin(alpha))^2 + lz^2 sin^2(alpha)            for a fibre family.
// energy = integral of W ds [Pa]; the energy per reference length is pi R_i^2 times that. Its gradient balances
//   (F / (pi R_i^2), P, M / (pi R_i^3)).
// Source: cpp/MECHANICS.md, "Actuator".
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <variant>
#include <vector>

#include "softlimb/actuator/layer.hpp"
#include "softlimb/dual.hpp"
#include "softlimb/gauss.hpp"

namespace softlimb::actuator {

/// Unknowns of a tube, scaled as above.
template <class S>
struct Shape {
    S stretch{1.0}, volume{1.0}, twist{0.0};
};

/// Energy [Pa] with gradient and Hessian in (stretch, volume, twist).
template <class S>
struct WallEnergy {
    S value{0.0}, g_l{0.0}, g_w{0.0}, g_t{0.0};
    S h_ll{0.0}, h_lw{0.0}, h_lt{0.0}, h_ww{0.0}, h_wt{0.0}, h_tt{0.0};

    /// Adds `factor` times another, number by number.
    void add(const S& factor, const WallEnergy& other) {
        value += factor * other.value;
        g_l += factor * other.g_l, g_w += factor * other.g_w, g_t += factor * other.g_t;
        h_ll += factor * other.h_ll, h_lw += factor * other.h_lw, h_lt += factor * other.h_lt;
        h_ww += factor * other.h_ww, h_wt += factor * other.h_wt, h_tt += factor * other.h_tt;
    }
};

/// A fibre family in scaled form. A `mirrored` family stands for two, at +angle and -angle: without twist both have
/// the same stretch, so one evaluation serves both.
template <class A>
struct WallFamilyOf {
    A cosine, sine;
    double stiffness;
    bool mirrored;
};
using WallFamily = WallFamilyOf<double>;

/// Quadrature point: s, 1/s, 1/sqrt(s), and the weight ds.
struct WallPoint {
    double s, inverse_s, inverse_r, weight;
};

struct WallLayer {
    materials::AnyLaw law;
    double silicone;     // fraction of the volume
    double x_in, x_out;  // ln s at its faces
    double s_in, s_out;
    std::vector<WallPoint> points, fine_points;
    std::vector<WallFamily> families;
};

class Wall {
public:
    /// Layers from inside out, adjoining. `points` a layer; 0 chooses by thickness, see `points_for`.
    Wall(const std::vector<Layer>& layers, bool tension_only, int points = 0);

    template <class S>
    WallEnergy<S> energy(const Shape<S>& q) const;

    const std::vector<WallLayer>& layers() const { return layers_; }
    bool tension_only() const { return tension_only_; }
    /// True when every family has its mirror image: such a tube does not twist by itself.
    bool balanced() const { return balanced_; }

    /// Larger one of I1 - 3 at the two faces of the tube.
    double largest_invariant(const Shape<double>& q) const {
        const auto at = [&](double s) {
            const double e = s + q.volume - 1.0;
            return s / (e * q.stretch) + e / q.stretch * (1.0 / s + q.twist * q.twist) + q.stretch * q.stretch - 3.0;
        };
        return std::max(at(1.0), at(s_out_));
    }

    /// Parts of the energy, for its derivatives to what the wall is made of (wall_slopes.cpp). A layer filled with a
    /// silicone alone; one family alone, of unit stiffness at `angle`, and its derivative to the angle; all that a
    /// layer holds at one of its faces, per change of s there.
    WallEnergy<double> silicone(int layer, const materials::AnyLaw& law, const Shape<double>& q) const;
    WallEnergy<double> fibres(int layer, double angle, const Shape<double>& q) const;
    WallEnergy<double> fibres_by_angle(int layer, double angle, const Shape<double>& q) const;
    WallEnergy<double> at_face(int layer, bool outer, const Shape<double>& q) const;

    /// True where the strain asks for the finer set of points.
    bool strained(const Shape<double>& q) const { return !(largest_invariant(q) < fine_from_); }
    /// Gauss points for a layer between ln s = x_in and x_out.
    static int points_for(double x_in, double x_out);

    /// I4 of a family at ln s = x, and its derivative in x.
    template <class S, class A>
    static void squared_stretch(const WallFamilyOf<A>& family, const Shape<S>& q, const S& x, S& squared, S& slope);

    /// Parts of a layer where a family is taut, as pairs of ln s; at most `max_parts`.
    static constexpr int max_parts = 4;
    struct TautParts {
        int count = 0;
        bool whole = false;  // taut throughout the layer
        double from[max_parts], to[max_parts];
        bool moving_from[max_parts], moving_to[max_parts];  // a slack boundary, not a face of the layer
    };
    static TautParts taut_parts(const WallLayer& layer, const WallFamily& family, const Shape<double>& q);

private:
    template <bool twisted, class S>
    WallEnergy<S> sum(const Shape<S>& q) const;
    template <bool twisted, class S, class A>
    void add_partly_slack(const WallLayer& layer, const WallFamilyOf<A>& family, const Shape<S>& q,
                          WallEnergy<S>& e) const;
    template <class S, class A>
    WallEnergy<S> fibres(int layer, const A& cosine, const A& sine, const Shape<S>& q) const;

    std::vector<WallLayer> layers_;
    bool tension_only_;
    bool balanced_ = true;
    double s_out_, fine_from_;  // I1 - 3 from which the finer points serve
    GaussRule slack_rule_, fine_slack_rule_;
};

namespace detail {

inline Shape<double> plain(const Shape<double>& q) { return q; }
template <int N>
Shape<double> plain(const Shape<Dual<N>>& q) {
    return {q.stretch.value, q.volume.value, q.twist.value};
}
inline bool exactly_zero(double x) { return x == 0.0; }
template <int N>
bool exactly_zero(const Dual<N>& x) {
    for (double slope : x.slope)
        if (slope != 0.0) return false;
    return x.value == 0.0;
}

/// Terms that depend on the shape alone.
template <class S>
struct ShapeTerms {
    S l, inverse_l, l_squared, d, twist, twist_squared;
    explicit ShapeTerms(const Shape<S>& q)
        : l(q.stretch),
          inverse_l(1.0 / q.stretch),
          l_squared(q.stretch * q.stretch),
          d(q.volume - 1.0),
          twist(q.twist),
          twist_squared(q.twist * q.twist) {}
};

/// Silicone of one layer. The chain rule from (a, t) to (lz, w, gamma), written out.
template <bool twisted, class Law, class S>
inline void add_silicone(const Law& law, const WallLayer& layer, const std::vector<WallPoint>& points,
                         const ShapeTerms<S>& q, WallEnergy<S>& e) {
    const S two_l = 2.0 * q.l;
    for (const WallPoint& p : points) {
        const double weight = p.weight * layer.silicone;
        const S inverse_e = 1.0 / (q.d + p.s);
        const S rho = (q.d + p.s) * q.inverse_l;
        S m(p.inverse_s);
        if constexpr (twisted) m += q.twist_squared;
        const S a = p.s * q.inverse_l * inverse_e, t = rho * m + q.l_squared;
        const materials::EnergyDerivatives<S> w = law.derivatives(a, t);

        const S a_l = -a * q.inverse_l, a_w = -a * inverse_e;
        const S t_w = m * q.inverse_l, t_l = two_l - rho * t_w;
        const S along_a = weight * w.w_a, along_t = weight * w.w_t;
        const S pa_l = w.w_aa * a_l + w.w_at * t_l, pt_l = w.w_at * a_l + w.w_tt * t_l;
        const S pa_w = w.w_aa * a_w + w.w_at * t_w, pt_w = w.w_at * a_w + w.w_tt * t_w;

        e.value += weight * w.w;
        e.g_l += along_a * a_l + along_t * t_l;
        e.g_w += along_a * a_w + along_t * t_w;
        e.h_ll += weight * (pa_l * a_l + pt_l * t_l) - 2.0 * along_a * a_l * q.inverse_l +
                  2.0 * along_t * (rho * t_w * q.inverse_l + 1.0);
        e.h_lw += weight * (pa_l * a_w + pt_l * t_w) - along_a * a_w * q.inverse_l - along_t * t_w * q.inverse_l;
        e.h_ww += weight * (pa_w * a_w + pt_w * t_w) - 2.0 * along_a * a_w * inverse_e;
        e.h_tt += 2.0 * along_t * rho;
        if constexpr (twisted) {
            const S t_t = 2.0 * rho * q.twist;
            e.g_t += along_t * t_t;
            e.h_lt += weight * pt_l * t_t - along_t * t_t * q.inverse_l;
            e.h_wt += weight * pt_w * t_t + 2.0 * along_t * q.twist * q.inverse_l;
            e.h_tt += weight * w.w_tt * t_t * t_t;
        }
    }
}

/// One fibre family at one point; `force` is weight times k.
template <bool twisted, class S, class P, class A>
inline void add_fibre(const ShapeTerms<S>& q, const P& s, const P& inverse_r, const A& cosine, const A& sine,
                      const P& force, WallEnergy<S>& e) {
    using std::sqrt;
    const S rho = (q.d + s) * q.inverse_l;
    S c(cosine * inverse_r);
    if constexpr (twisted) c += q.twist * sine;
    const A sine_squared = sine * sine;
    const S i_w = c * c * q.inverse_l;
    const S rho_i_w = rho * i_w;  // rho c^2 / l
    const S squared = rho_i_w * q.l + q.l_squared * sine_squared;
    const S i_l = 2.0 * sine_squared * q.l - rho_i_w;
    const S i_t = 2.0 * sine * rho * c;

    const S inverse = 1.0 / sqrt(squared), stretch = squared * inverse;
    const S first = 0.5 * force * (1.0 - inverse), second = 0.25 * force * inverse * inverse * inverse;
    e.value += 0.5 * force * (stretch - 1.0) * (stretch - 1.0);
    e.g_l += first * i_l;
    e.g_w += first * i_w;
    e.g_t += first * i_t;
    e.h_ll += second * i_l * i_l + 2.0 * first * (rho_i_w * q.inverse_l + sine_squared);
    e.h_lw += second * i_l * i_w - first * i_w * q.inverse_l;
    e.h_lt += second * i_l * i_t - first * i_t * q.inverse_l;
    e.h_ww += second * i_w * i_w;
    e.h_wt += second * i_w * i_t + 2.0 * sine * first * c * q.inverse_l;
    e.h_tt += second * i_t * i_t + 2.0 * sine_squared * first * rho;
}

/// A family or, when mirrored, both; without twist the pair's couplings to the twist cancel exactly.
template <bool twisted, class S, class P>
inline void add_family(const ShapeTerms<S>& q, const P& s, const P& inverse_r, const WallFamily& f, const P& force,
                       WallEnergy<S>& e) {
    if (!f.mirrored) {
        add_fibre<twisted>(q, s, inverse_r, f.cosine, f.sine, force, e);
    } else if constexpr (twisted) {
        add_fibre<twisted>(q, s, inverse_r, f.cosine, f.sine, force, e);
        add_fibre<twisted>(q, s, inverse_r, f.cosine, -f.sine, force, e);
    } else {
        const S g_t = e.g_t, h_lt = e.h_lt, h_wt = e.h_wt;
        add_fibre<twisted>(q, s, inverse_r, f.cosine, f.sine, P(2.0 * force), e);
        e.g_t = g_t, e.h_lt = h_lt, e.h_wt = h_wt;
    }
}

}  // namespace detail

template <class S, class A>
void Wall::squared_stretch(const WallFamilyOf<A>& family, const Shape<S>& q, const S& x, S& squared, S& slope) {
    using std::exp;
    const S s = exp(x), inverse_r = exp(-0.5 * x);
    const S rho = (s + q.volume - 1.0) / q.stretch;
    const S around = family.cosine * inverse_r, c = around + family.sine * q.twist;
    squared = rho * c * c + q.stretch * q.stretch * (family.sine * family.sine);
    slope = c * (s * c / q.stretch - rho * around);
}

// Where a fibre goes slack inside a layer, its energy (a squared stretch) and the gradient vanish at the slack
// boundary, so that gradient and Hessian are the integrals over the taut part alone. The boundary moves with the
// shape; carried in S it gives the Hessian's derivative exactly too.
template <bool twisted, class S, class A>
void Wall::add_partly_slack(const WallLayer& layer, const WallFamilyOf<A>& family, const Shape<S>& q,
                            WallEnergy<S>& e) const {
    using std::exp;
    const Shape<double> at = detail::plain(q);
    const WallFamily plain{value_of(family.cosine), value_of(family.sine), family.stiffness, family.mirrored};
    const TautParts parts = taut_parts(layer, plain, at);
    const detail::ShapeTerms<S> terms(q);
    if (parts.whole) {
        for (const WallPoint& p : strained(at) ? layer.fine_points : layer.points)
            detail::add_fibre<true>(terms, p.s, p.inverse_r, family.cosine, family.sine, family.stiffness * p.weight,
                                    e);
        return;
    }
    const auto boundary = [&](double x, bool moving) {
        S end(x);
        if (moving) {
            S squared, slope;
            squared_stretch(family, q, S(x), squared, slope);
            end -= (squared - 1.0) / value_of(slope);
        }
        return end;
    };
    const GaussRule& rule = strained(at) ? fine_slack_rule_ : slack_rule_;
    for (int part = 0; part < parts.count; ++part) {
        const S from = boundary(parts.from[part], parts.moving_from[part]);
        const S to = boundary(parts.to[part], parts.moving_to[part]);
        const S middle = 0.5 * (from + to), half = 0.5 * (to - from);
        for (int i = 0; i < rule.points; ++i) {
            const S x = middle + half * rule.node[i];
            const S s = exp(x), inverse_r = exp(-0.5 * x);
            const S force = family.stiffness * rule.weight[i] * half * s;
            detail::add_fibre<true>(terms, s, inverse_r, family.cosine, family.sine, force, e);
        }
    }
}

template <bool twisted, class S>
WallEnergy<S> Wall::sum(const Shape<S>& q) const {
    WallEnergy<S> e;
    const detail::ShapeTerms<S> terms(q);
    const bool fine = strained(detail::plain(q));
    for (const WallLayer& layer : layers_) {
        const std::vector<WallPoint>& points = fine ? layer.fine_points : layer.points;
        std::visit([&](const auto& law) { detail::add_silicone<twisted>(law, layer, points, terms, e); }, layer.law);
        for (const WallFamily& family : layer.families) {
            if (!tension_only_) {
                for (const WallPoint& p : points)
                    detail::add_family<twisted>(terms, p.s, p.inverse_r, family, family.stiffness * p.weight, e);
            } else if (!family.mirrored) {
                add_partly_slack<twisted>(layer, family, q, e);
            } else {
                WallFamily single = family;
                single.mirrored = false;
                if constexpr (twisted) {
                    add_partly_slack<twisted>(layer, single, q, e);
                    single.sine = -single.sine;
                    add_partly_slack<twisted>(layer, single, q, e);
                } else {
                    const S g_t = e.g_t, h_lt = e.h_lt, h_wt = e.h_wt;
                    single.stiffness *= 2.0;
                    add_partly_slack<twisted>(layer, single, q, e);
                    e.g_t = g_t, e.h_lt = h_lt, e.h_wt = h_wt;
                }
            }
        }
    }
    return e;
}

template <class S>
WallEnergy<S> Wall::energy(const Shape<S>& q) const {
    return detail::exactly_zero(q.twist) ? sum<false>(q) : sum<true>(q);
}

// Compiled once, in wall.cpp: every law and both kinds of twist for each scalar.
extern template WallEnergy<double> Wall::energy(const Shape<double>& q) const;
extern template WallEnergy<Dual<1>> Wall::energy(const Shape<Dual<1>>& q) const;
extern template WallEnergy<Dual<2>> Wall::energy(const Shape<Dual<2>>& q) const;

}  // namespace softlimb::actuator
