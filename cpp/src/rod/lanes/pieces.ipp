// The kernel of rod/lanes/pieces.hpp for one instruction set: included by one source a set, which defines
// SOFTLIMB_INSTRUCTION_SET (a namespace) and SOFTLIMB_LANES. Everything here is inlined into the functions at the end
// or lives in that namespace, so that nothing compiled for a newer machine can be linked into the rest of the library.
#ifdef __AVX512F__
#include <immintrin.h>
#endif

#include <cmath>
#include <type_traits>

#include "softlimb/always_inline.hpp"
#include "softlimb/rod/equations.hpp"
#include "softlimb/rod/geodesic.hpp"
#include "softlimb/rod/integrators/rk4.hpp"
#include "softlimb/rod/integrators/rk8.hpp"
#include "softlimb/rod/kernel.hpp"
#include "softlimb/rod/lanes/pieces.hpp"
#include "softlimb/solve/newton_numbers.hpp"
#include "softlimb/unrolled.hpp"

namespace softlimb::rod::lanes::SOFTLIMB_INSTRUCTION_SET {
namespace {

#include "softlimb/rod/lanes/pack.hpp"

using Method = Rk8;
constexpr int stages = Method::stages;
constexpr int W = Pack::lanes;
using V = Vec3<Pack>;

SOFTLIMB_ALWAYS_INLINE void set(V& v, int lane, const double* x) {
    v.x.set(lane, x[0]), v.y.set(lane, x[1]), v.z.set(lane, x[2]);
}

/// Compliances of W sections. The axial law of every lane is v3 - 1 = n g((n - centre)/half_range) inside its range and
/// the second-order Taylor polynomial at the range's end outside (section.hpp), of the largest degree in the pack.
struct LaneCompliances {
    static constexpr bool linear = false;
    Pack unit, shear, bending, torsion, coupling, rest_twist;  // all per `unit` of rest length
    Pack coefficient[AxialLaw::max_degree + 1];
    Pack centre, half_range, per_range;
    int degree = 0;

    /// The same over a step: rates by them are changes over it, and need no scaling of their own.
    SOFTLIMB_ALWAYS_INLINE LaneCompliances over(const Pack& step) const {
        LaneCompliances k;
        k.unit = step * unit, k.shear = step * shear, k.bending = step * bending, k.torsion = step * torsion;
        k.coupling = step * coupling, k.rest_twist = step * rest_twist;
        k.degree = degree;
        for (int i = 0; i <= degree; ++i) k.coefficient[i] = step * coefficient[i];
        if (degree > 0) k.centre = centre, k.half_range = half_range, k.per_range = per_range;
        return k;
    }

    /// Puts a section into a lane; `degree` is known.
    SOFTLIMB_ALWAYS_INLINE void put(int lane, const Section& s) {
        unit = Pack(1.0);
        shear.set(lane, 1.0 / s.shear), bending.set(lane, 1.0 / s.bending);
        torsion.set(lane, 1.0 / s.torsion), coupling.set(lane, s.extension_twist);
        rest_twist.set(lane, s.rest_twist);
        const double* c = &s.axial_law.coefficient.front();
        for (int i = 0; i <= degree; ++i) coefficient[i].set(lane, i <= s.axial_law.degree ? c[i] : 0.0);
        if (degree == 0) return;
        // A linear law among others holds everywhere, and to the bits of one among its own.
        const bool linear = s.axial_law.degree == 0;
        centre.set(lane, linear ? 0.0 : s.axial_law.centre);
        half_range.set(lane, linear ? 1e300 : s.axial_law.half_range);
        per_range.set(lane, linear ? 0.0 : 1.0 / s.axial_law.half_range);
    }

    SOFTLIMB_ALWAYS_INLINE void axial(const Pack& force, Pack& strain, Pack& compliance) const {
        if (degree == 0) {
            strain = force * coefficient[0];
            compliance = coefficient[0];
            return;
        }
        const Pack away = force - centre;
        const Pack inside = select(half_range < away, half_range, select(away < -half_range, -half_range, away));
        const Pack x = inside * per_range, at = centre + inside, beyond = away - inside;
        Pack g = coefficient[degree], dg(0.0), half_ddg(0.0);
        for (int i = degree; i-- > 0;) {
            half_ddg = half_ddg * x + dg;
            dg = dg * x + g;
            g = g * x + coefficient[i];
        }
        const Pack slope = g + at * dg * per_range;
        const Pack curvature = Pack(2.0) * per_range * (dg + at * half_ddg * per_range);
        strain = at * g + beyond * (slope + Pack(0.5) * curvature * beyond);
        compliance = slope + curvature * beyond;
    }
};

/// The same where every lane's axial law is linear, as most are: steps have a third less code, which leaves room for
/// more in the nearest cache.
struct LinearCompliances {
    static constexpr bool linear = true;
    const LaneCompliances& all;
    const Pack &unit = all.unit, &shear = all.shear, &bending = all.bending, &torsion = all.torsion;
    const Pack &coupling = all.coupling, &rest_twist = all.rest_twist;

    SOFTLIMB_ALWAYS_INLINE explicit LinearCompliances(const LaneCompliances& of) : all(of) {}
    SOFTLIMB_ALWAYS_INLINE void axial(const Pack& force, Pack& strain, Pack& compliance) const {
        strain = force * all.coefficient[0];
        compliance = all.coefficient[0];
    }
};

/// What W pieces are made of; lanes beyond `count` repeat the last piece.
struct Material {
    LaneCompliances k;
    LineLoad<Pack> load;
    Pack length;

    SOFTLIMB_ALWAYS_INLINE Material() {}
    SOFTLIMB_ALWAYS_INLINE Material(const Start* starts, int count) {
        for (int lane = 0; lane < W; ++lane) {
            const Start& p = starts[lane < count ? lane : count - 1];
            if (p.section->axial_law.degree > k.degree) k.degree = p.section->axial_law.degree;
        }
        for (int lane = 0; lane < W; ++lane) {
            const Start& p = starts[lane < count ? lane : count - 1];
            k.put(lane, *p.section);
            set(load.force, lane, p.force), set(load.moment, lane, p.moment);
            length.set(lane, p.length);
        }
    }
};

/// The same over a step.
struct StepOf {
    LaneCompliances k;
    V force, moment;

    SOFTLIMB_ALWAYS_INLINE StepOf(const Material& of, int steps) : StepOf(of, of.length * Pack(1.0 / steps)) {}
    SOFTLIMB_ALWAYS_INLINE StepOf(const Material& of, const Pack& step)
        : k(of.k.over(step)), force(step * of.load.force), moment(step * of.load.moment) {}
};

/// Where W pieces are: positions are relative to their bases.
struct Pieces {
    V n;
    RodState<Pack> y;

    SOFTLIMB_ALWAYS_INLINE Pieces() {}
    SOFTLIMB_ALWAYS_INLINE Pieces(const Start* starts, int count) {
        y.position = V{Pack(0.0), Pack(0.0), Pack(0.0)};
        for (int lane = 0; lane < W; ++lane) {
            const Start& p = starts[lane < count ? lane : count - 1];
            set(n, lane, p.wrench), set(y.moment, lane, p.wrench + 3);
            set(y.tangent, lane, p.rotation + 6), set(y.director, lane, p.rotation);
        }
    }
};

/// How W pieces change with a parameter each: slopes of the compliances, of n(s) by s, and of the length.
struct Parameter {
    LaneCompliances k;
    V force;
    Pack length, growth;  // of the law's range, relative

    SOFTLIMB_ALWAYS_INLINE Parameter(const Start* starts, const Slope* slopes, int count, const Material& of) {
        k.unit = Pack(0.0), k.degree = of.k.degree;
        k.centre = of.k.centre, k.half_range = of.k.half_range, k.per_range = of.k.per_range;
        for (int lane = 0; lane < W; ++lane) {
            const int i = lane < count ? lane : count - 1;
            const Section &s = *starts[i].section, &d = *slopes[i].section;
            k.shear.set(lane, -d.shear), k.bending.set(lane, -d.bending), k.torsion.set(lane, -d.torsion);
            k.coupling.set(lane, d.extension_twist), k.rest_twist.set(lane, d.rest_twist);
            const double* c = &d.axial_law.coefficient.front();
            for (int j = 0; j <= k.degree; ++j) k.coefficient[j].set(lane, j <= s.axial_law.degree ? c[j] : 0.0);
            growth.set(lane, range_growth(s.axial_law, d.axial_law));
            length.set(lane, slopes[i].length);
            const double* f = slopes[i].force;
            force.x.set(lane, -f[0]), force.y.set(lane, -f[1]), force.z.set(lane, -f[2]);
        }
        // Of compliances, from those of stiffnesses.
        k.shear = k.shear * (of.k.shear * of.k.shear), k.bending = k.bending * (of.k.bending * of.k.bending);
        k.torsion = k.torsion * (of.k.torsion * of.k.torsion);
    }

    /// The same over a step.
    SOFTLIMB_ALWAYS_INLINE Parameter(const Parameter& p, const Pack& step)
        : k(p.k.over(step)), force(step * p.force), length(p.length), growth(p.growth) {}

    /// `vary` at this dn, with strains and curvatures that move by themselves too, as `K` of the compliances says.
    template <class K>
    SOFTLIMB_ALWAYS_INLINE Variation<Pack> vary_with(const LaneCompliances& of, const Linearisation<Pack>& at,
                                                     const V& rotation, const V& moment, const V& dn) const {
        const V x = dn - cross(rotation, at.n), y = moment - cross(rotation, at.m);
        const Pack n3 = dot(at.t, at.n), m3 = dot(at.t, at.m), tx = dot(at.t, x), ty = dot(at.t, y);
        Pack strain, ignored;
        static_cast<K>(k).axial(n3, strain, ignored);
        if constexpr (!std::remove_cvref_t<K>::linear) {
            const Pack known = dot(at.t, at.velocity) - of.unit - of.coupling * m3;
            strain = strain + growth * (known - n3 * at.axial_compliance);
        }
        const Pack bend = (of.torsion - of.bending) * ty + of.coupling * tx + (k.torsion - k.bending) * m3 +
                          k.coupling * n3 + k.rest_twist;
        const Pack pull =
            (at.axial_compliance - of.shear) * tx + of.coupling * ty + strain + k.coupling * m3 - k.shear * n3;
        const V position = cross(rotation, at.velocity) + of.shear * x + k.shear * at.n + pull * at.t;
        return {position, of.bending * y + k.bending * at.m + bend * at.t,
                cross(at.n, position) + cross(dn, at.velocity)};
    }
};

/// One step of the state, with compliances as a `K`; `seen(stage, linearisation)` looks at each stage.
template <class K, class Seen>
SOFTLIMB_ALWAYS_INLINE void step_state(Pieces& p, const StepOf& over, Seen&& seen) {
    const K k(over.k);
    RodState<Pack> dy[stages];
    const RodState<Pack> from = p.y;
    unrolled<0, stages>([&](auto stage) SOFTLIMB_LAMBDA_INLINE {
        constexpr int i = stage;
        RodState<Pack> at = from;
        unrolled<0, i>([&](auto before) SOFTLIMB_LAMBDA_INLINE {
            constexpr int j = before;
            if constexpr (Method::a[i][j] != 0.0) {
                const Pack a(Method::a[i][j]);
                at.tangent += a * dy[j].tangent, at.director += a * dy[j].director, at.moment += a * dy[j].moment;
            }
        });
        Linearisation<Pack> linear;
        const RodState<Pack> d = rate(k, at, p.n - Pack(Method::c[i]) * over.force, over.moment, linear);
        if constexpr (Method::b[i] != 0.0) p.y.position += Pack(Method::b[i]) * d.position;
        dy[i].tangent = d.tangent, dy[i].director = d.director, dy[i].moment = d.moment;
        seen(stage, linear);
    });
    unrolled<0, stages>([&](auto stage) SOFTLIMB_LAMBDA_INLINE {
        constexpr int i = stage;
        if constexpr (Method::b[i] != 0.0) {
            const Pack b(Method::b[i]);
            p.y.tangent += b * dy[i].tangent, p.y.director += b * dy[i].director, p.y.moment += b * dy[i].moment;
        }
    });
    p.n = p.n - over.force;
}

SOFTLIMB_ALWAYS_INLINE void make_orthonormal(RodState<Pack>& y) {
    y.tangent = normalised(y.tangent);
    y.director = normalised(y.director - dot(y.director, y.tangent) * y.tangent);
}

/// Advances the pieces. Not inlined, as those below: its name is this instruction set's own, and compiled once it is
/// compiled fast.
template <class K>
SOFTLIMB_NEVER_INLINE void steps_alone(Pieces& p, const StepOf& over, int steps) {
    for (int step = 0; step < steps; ++step)
        step_state<K>(p, over, [](auto, const Linearisation<Pack>&) SOFTLIMB_LAMBDA_INLINE {});
}
void advance(Pieces& p, const StepOf& over, int steps) {
    if (over.k.degree == 0)
        steps_alone<LinearCompliances>(p, over, steps);
    else
        steps_alone<const LaneCompliances&>(p, over, steps);
    make_orthonormal(p.y);
}

/// One step of one variation, whose rate at a stage is `rate(stage, rotation, moment)`.
template <class Rate>
SOFTLIMB_ALWAYS_INLINE void step_column(Variation<Pack>& z, Rate&& rate) {
    V rotation_rate[stages], moment_rate[stages];
    const Variation<Pack> from = z;
    unrolled<0, stages>([&](auto stage) SOFTLIMB_LAMBDA_INLINE {
        constexpr int i = stage;
        V rotation = from.rotation, moment = from.moment;
        unrolled<0, i>([&](auto before) SOFTLIMB_LAMBDA_INLINE {
            constexpr int j = before;
            if constexpr (Method::a[i][j] != 0.0) {
                const Pack a(Method::a[i][j]);
                rotation += a * rotation_rate[j], moment += a * moment_rate[j];
            }
        });
        const Variation<Pack> d = rate(stage, rotation, moment);
        if constexpr (Method::b[i] != 0.0) z.position += Pack(Method::b[i]) * d.position;
        rotation_rate[i] = d.rotation, moment_rate[i] = d.moment;
    });
    unrolled<0, stages>([&](auto stage) SOFTLIMB_LAMBDA_INLINE {
        constexpr int i = stage;
        if constexpr (Method::b[i] != 0.0) {
            const Pack b(Method::b[i]);
            z.rotation += b * rotation_rate[i], z.moment += b * moment_rate[i];
        }
    });
}

/// One step of the variation with a change of the base force, or without.
SOFTLIMB_NEVER_INLINE void step_forced(Variation<Pack>& z, const LaneCompliances& k, const Linearisation<Pack>* linear,
                                       const V& force) {
    step_column(z, [&](auto stage, const V& rotation, const V& moment)
                       SOFTLIMB_LAMBDA_INLINE { return vary(k, linear[stage], rotation, moment, force); });
}
SOFTLIMB_NEVER_INLINE void step_free(Variation<Pack>& z, const LaneCompliances& k, const Linearisation<Pack>* linear) {
    step_column(z, [&](auto stage, const V& rotation, const V& moment)
                       SOFTLIMB_LAMBDA_INLINE { return vary(k, linear[stage], rotation, moment); });
}

/// One step of the state, whose stages are written down for those of the variations.
template <class K>
SOFTLIMB_NEVER_INLINE void step_recorded_as(Pieces& p, const StepOf& over, Linearisation<Pack>* linear) {
    step_state<K>(p, over, [&](auto stage, const Linearisation<Pack>& l) SOFTLIMB_LAMBDA_INLINE { linear[stage] = l; });
}
SOFTLIMB_ALWAYS_INLINE void step_recorded(Pieces& p, const StepOf& over, Linearisation<Pack>* linear) {
    if (over.k.degree == 0)
        step_recorded_as<LinearCompliances>(p, over, linear);
    else
        step_recorded_as<const LaneCompliances&>(p, over, linear);
}

/// Advances the pieces and `columns` variations, of which the first three are those of the base force.
void advance_with(Pieces& p, const StepOf& over, int steps, Variation<Pack>* z, int columns) {
    const Pack zero(0.0), one(1.0);
    Linearisation<Pack> linear[stages];
    for (int step = 0; step < steps; ++step) {
        step_recorded(p, over, linear);
        // Column by column: the stages of one fit the nearest cache.
        for (int c = 0; c < 3; ++c)
            step_forced(z[c], over.k, linear, {c == 0 ? one : zero, c == 1 ? one : zero, c == 2 ? one : zero});
        for (int c = 3; c < columns; ++c) step_free(z[c], over.k, linear);
    }
    make_orthonormal(p.y);
}

/// One step of the variation with a parameter, `before` steps behind it.
template <class K>
SOFTLIMB_NEVER_INLINE void step_with(Variation<Pack>& z, const LaneCompliances& k, const Linearisation<Pack>* linear,
                                     const Parameter& over, int before) {
    step_column(z, [&](auto stage, const V& rotation, const V& moment) SOFTLIMB_LAMBDA_INLINE {
        const V dn = Pack(before + Method::c[stage]) * over.force;
        return over.vary_with<K>(k, linear[stage], rotation, moment, dn);
    });
}

/// Advances the pieces and their variation with a parameter; `dn` is that of the end's force.
void advance_with(Pieces& p, const Material& of, int steps, const Parameter& parameter, Variation<Pack>& z, V& dn) {
    const StepOf over(of, steps);
    const Parameter over_step(parameter, of.length * Pack(1.0 / steps));
    Linearisation<Pack> linear[stages];
    for (int step = 0; step < steps; ++step) {
        step_recorded(p, over, linear);
        if (over.k.degree == 0)
            step_with<LinearCompliances>(z, over.k, linear, over_step, step);
        else
            step_with<const LaneCompliances&>(z, over.k, linear, over_step, step);
    }
    make_orthonormal(p.y);
    // A longer piece goes on as it ends.
    Linearisation<Pack> end;
    const RodState<Pack> d = rate(of.k, p.y, p.n, of.load.moment, end);
    const Pack n3 = dot(end.t, end.n), m3 = dot(end.t, end.m);
    const Pack spin = of.k.rest_twist + of.k.coupling * n3 + (of.k.torsion - of.k.bending) * m3;
    z.position += parameter.length * d.position;
    z.rotation += parameter.length * (of.k.bending * end.m + spin * end.t);
    z.moment += parameter.length * d.moment;
    dn = of.length * parameter.force - parameter.length * of.load.force;
}

SOFTLIMB_ALWAYS_INLINE void put(double* out, const V& v, int lane) {
    out[0] = v.x.get(lane), out[1] = v.y.get(lane), out[2] = v.z.get(lane);
}

SOFTLIMB_ALWAYS_INLINE void write_end(const Pieces& p, const V& binormal, const double* from, const End& end,
                                      int lane) {
    put(end.position, p.y.position, lane);
    for (int i = 0; i < 3; ++i) end.position[i] += from[i];
    put(end.rotation, p.y.director, lane);
    put(end.rotation + 3, binormal, lane);
    put(end.rotation + 6, p.y.tangent, lane);
    put(end.wrench, p.n, lane);
    put(end.wrench + 3, p.y.moment, lane);
}

/// A 6 x 6 matrix a lane, by columns.
struct M6 {
    Pack m[6][6];
    SOFTLIMB_ALWAYS_INLINE Pack& operator()(int row, int column) { return m[column][row]; }
    SOFTLIMB_ALWAYS_INLINE const Pack& operator()(int row, int column) const { return m[column][row]; }
};

/// A 3 x 3 matrix a lane, by columns.
struct M3 {
    V column[3];

    SOFTLIMB_ALWAYS_INLINE friend V operator*(const M3& a, const V& v) {
        return v.x * a.column[0] + v.y * a.column[1] + v.z * a.column[2];
    }
    SOFTLIMB_ALWAYS_INLINE friend M3 operator*(const M3& a, const M3& b) {
        return {{a * b.column[0], a * b.column[1], a * b.column[2]}};
    }
    SOFTLIMB_ALWAYS_INLINE friend M3 operator-(const M3& a, const M3& b) {
        return {{a.column[0] - b.column[0], a.column[1] - b.column[1], a.column[2] - b.column[2]}};
    }
    SOFTLIMB_ALWAYS_INLINE friend M3 operator-(const M3& a) { return {{-a.column[0], -a.column[1], -a.column[2]}}; }
};

SOFTLIMB_ALWAYS_INLINE M3 inverse_of(const M3& a) {
    const V *c = a.column, x = cross(c[1], c[2]), y = cross(c[2], c[0]), z = cross(c[0], c[1]);
    const Pack per = Pack(1.0) / dot(c[0], x);
    return {{per * V{x.x, y.x, z.x}, per * V{x.y, y.y, z.y}, per * V{x.z, y.z, z.z}}};
}

SOFTLIMB_ALWAYS_INLINE M3 part(const M6& a, int row, int column) {
    const auto one = [&](int c) { return V{a(row, c), a(row + 1, c), a(row + 2, c)}; };
    return {{one(column), one(column + 1), one(column + 2)}};
}
SOFTLIMB_ALWAYS_INLINE void put(M6& a, int row, int column, const M3& b) {
    for (int c = 0; c < 3; ++c) {
        const V& v = b.column[c];
        a(row, column + c) = v.x, a(row + 1, column + c) = v.y, a(row + 2, column + c) = v.z;
    }
}

/// Inverse of [p, r; q, s], whose last block must be regular: turns by moments (of a piece that no moment buckles), or
/// moments by turns. Its blocks have units of their own, so no length is needed to compare them.
SOFTLIMB_ALWAYS_INLINE void invert(const M3& p, const M3& q, const M3& r, const M3& s, M6& inverse) {
    const M3 per_s = inverse_of(s), by_s = r * per_s, q_by_s = per_s * q;
    const M3 per_p = inverse_of(p - by_s * q), low = -(q_by_s * per_p);
    put(inverse, 0, 0, per_p), put(inverse, 0, 3, -(per_p * by_s));
    put(inverse, 3, 0, low), put(inverse, 3, 3, per_s - low * by_s);
}
SOFTLIMB_ALWAYS_INLINE void invert(const M6& a, M6& inverse) {
    invert(part(a, 0, 0), part(a, 3, 0), part(a, 0, 3), part(a, 3, 3), inverse);
}

/// Rotation vector of a b^T, where columns of the two rotations are given: small for pieces that nearly meet their
/// node.
SOFTLIMB_ALWAYS_INLINE V turn_between(const V* a, const V* b) {
    // The skew part of a b^T is the sum of the columns' cross products; its length is twice the sine.
    const V twice = cross(b[0], a[0]) + cross(b[1], a[1]) + cross(b[2], a[2]);
    const V s = Pack(0.5) * twice;
    const Pack z = dot(s, s);
    // asin(x)/x in z = x^2; below 0.02 the terms left out are under 1e-17.
    Pack factor = Pack(46189.0 / 5505024.0);
    constexpr double terms[] = {12155.0 / 1245184.0, 6435.0 / 557056.0, 143.0 / 10240.0, 231.0 / 13312.0, 63.0 / 2816.0,
                                35.0 / 1152.0,       5.0 / 112.0,       3.0 / 40.0,      1.0 / 6.0,       1.0};
    for (const double term : terms) factor = factor * z + Pack(term);
    const Pack cosine = Pack(0.5) * (dot(a[0], b[0]) + dot(a[1], b[1]) + dot(a[2], b[2]) - Pack(1.0));
    for (int lane = 0; lane < W; ++lane) {
        const double square = z.get(lane), c = cosine.get(lane);
        if (square < 0.02 && c > 0.0) continue;
        const double sine = __builtin_sqrt(square);
        // Within 1e-6 of half a turn the axis drowns in rounding; no piece misses its node by that and is on its way.
        factor.set(lane, sine > 0.0 ? std::atan2(sine, c) / sine : 0.0);
    }
    return factor * s;
}

SOFTLIMB_ALWAYS_INLINE V gather(const double* const* from, int offset) {
    V v;
    for (int lane = 0; lane < W; ++lane)
        v.x.set(lane, from[lane][offset]), v.y.set(lane, from[lane][offset + 1]), v.z.set(lane, from[lane][offset + 2]);
    return v;
}

/// W pieces linearised: what `Linear` holds, before it is handed out.
struct Linearised {
    V binormal;  // of the end
    Pack gap[6];
    M6 by_first, inverse, end_by_first, by_second;  // stiffness: by_first, -inverse; end_by_first, by_second
    Variation<Pack> by_turn[3];                     // of the end pose, and end moment, by the base rotation
    Pack moment_by_wrench[6][3];
    Pack force[12];
    Pack sum;  // zero where everything is finite
};

/// Advances the pieces, which start at `from`, and linearises them against their second nodes.
void linearise_pieces(Pieces& p, const V& line_force, const StepOf& over, int steps, const V& from, const V& node,
                      const V* node_axes, Loads loads, Linearised& l) {
    const int columns = loads == Loads::none ? 6 : loads == Loads::force ? 8 : 9;
    const Pack zero(0.0), one(1.0);
    const V nothing{zero, zero, zero};
    const V n0 = p.n, m0 = p.y.moment;
    Variation<Pack> z[9];
    for (int c = 0; c < columns; ++c) z[c] = {nothing, nothing, nothing};
    z[3].moment.x = one, z[4].moment.y = one, z[5].moment.z = one;
    // Base rotations that are integrated: two across a dead force, or all three.
    V axis[3];
    if (loads == Loads::force) {
        const Pack norm = sqrt(dot(line_force, line_force));
        // A piece without load among loaded ones: any axis serves.
        const Mask loaded = zero < norm;
        const V f{select(loaded, line_force.x, zero), select(loaded, line_force.y, zero),
                  select(loaded, line_force.z, one)};
        axis[2] = (one / select(loaded, norm, one)) * f;
        // Across it: with the base axis that it leans on least.
        const Pack ax = absolute(axis[2].x), ay = absolute(axis[2].y), az = absolute(axis[2].z);
        const Mask x_least = ax < ay, x_less = ax < az, y_less = ay < az;
        const Pack ex = select(x_least, select(x_less, one, zero), zero);
        const Pack ey = select(x_least, zero, select(y_less, one, zero));
        const V e{ex, ey, one - ex - ey};
        axis[0] = normalised(cross(e, axis[2]));
        axis[1] = cross(axis[2], axis[0]);
        z[6].rotation = axis[0], z[7].rotation = axis[1];
    } else if (loads == Loads::any) {
        z[6].rotation.x = one, z[7].rotation.y = one, z[8].rotation.z = one;
    }
    advance_with(p, over, steps, z, columns);

    // End pose (dp, dtheta) and end moment by base wrench.
    M6& inverse = l.inverse;
    invert({{z[0].position, z[1].position, z[2].position}}, {{z[0].rotation, z[1].rotation, z[2].rotation}},
           {{z[3].position, z[4].position, z[5].position}}, {{z[3].rotation, z[4].rotation, z[5].rotation}}, inverse);
    Pack(&moment_by_wrench)[6][3] = l.moment_by_wrench;
    for (int c = 0; c < 6; ++c) {
        moment_by_wrench[c][0] = z[c].moment.x, moment_by_wrench[c][1] = z[c].moment.y;
        moment_by_wrench[c][2] = z[c].moment.z;
    }

    // By base rotation. Turning everything, wrench and loads with the base, turns the end; the wrench is turned back by
    // its own columns, and a turn about the dead force needs no turning back of the load.
    Variation<Pack>(&by_turn)[3] = l.by_turn;
    const auto turned_about = [&](const V& a) SOFTLIMB_LAMBDA_INLINE {
        const V dn = cross(a, n0), dm = cross(a, m0);
        const Pack w[6] = {dn.x, dn.y, dn.z, dm.x, dm.y, dm.z};
        Variation<Pack> v{cross(a, p.y.position), a, cross(a, p.y.moment)};
        for (int c = 0; c < 6; ++c) {
            v.position = v.position - w[c] * z[c].position;
            v.rotation = v.rotation - w[c] * z[c].rotation;
            v.moment = v.moment - w[c] * z[c].moment;
        }
        return v;
    };
    if (loads == Loads::any) {
        for (int i = 0; i < 3; ++i) by_turn[i] = z[6 + i];
    } else if (loads == Loads::none) {
        for (int i = 0; i < 3; ++i) {
            V e = nothing;
            (i == 0 ? e.x : i == 1 ? e.y : e.z) = one;
            by_turn[i] = turned_about(e);
        }
    } else {
        const Variation<Pack> about = turned_about(axis[2]);
        const auto share = [](const V& v, int i) SOFTLIMB_LAMBDA_INLINE { return i == 0 ? v.x : i == 1 ? v.y : v.z; };
        for (int i = 0; i < 3; ++i) {
            const Pack a = share(axis[0], i), b = share(axis[1], i), c = share(axis[2], i);
            by_turn[i] = {a * z[6].position + b * z[7].position + c * about.position,
                          a * z[6].rotation + b * z[7].rotation + c * about.rotation,
                          a * z[6].moment + b * z[7].moment + c * about.moment};
        }
    }

    // Gap to the second node.
    l.binormal = cross(p.y.tangent, p.y.director);
    const V end_axes[3] = {p.y.director, l.binormal, p.y.tangent};
    const V gap_position = p.y.position + (from - node);
    const V gap_turn = turn_between(end_axes, node_axes);
    Pack(&gap)[6] = l.gap;
    gap[0] = gap_position.x, gap[1] = gap_position.y, gap[2] = gap_position.z;
    gap[3] = gap_turn.x, gap[4] = gap_turn.y, gap[5] = gap_turn.z;

    // w = w0 + B^-1 (x2 - A x1 - gap),  w_end = w_end0 + D x1 + E (w - w0)
    M6& by_first = l.by_first;  // B^-1 A: A's first three columns are those of the identity
    for (int r = 0; r < 6; ++r) {
        for (int c = 0; c < 3; ++c) by_first(r, c) = inverse(r, c);
        for (int c = 0; c < 3; ++c) {
            const Variation<Pack>& a = by_turn[c];
            by_first(r, 3 + c) = inverse(r, 0) * a.position.x + inverse(r, 1) * a.position.y +
                                 inverse(r, 2) * a.position.z + inverse(r, 3) * a.rotation.x +
                                 inverse(r, 4) * a.rotation.y + inverse(r, 5) * a.rotation.z;
        }
    }
    // E has the identity and zero in its first three rows, and the moment's columns below.
    M6 &by_second = l.by_second, &end_by_first = l.end_by_first;  // E B^-1, and D - E B^-1 A
    const auto moment_of = [&](const M6& wrench, int c, int r) {
        Pack m = moment_by_wrench[0][r] * wrench(0, c);
        for (int k = 1; k < 6; ++k) m = m + moment_by_wrench[k][r] * wrench(k, c);
        return m;
    };
    for (int c = 0; c < 6; ++c)
        for (int r = 0; r < 3; ++r) {
            by_second(r, c) = inverse(r, c), by_second(3 + r, c) = moment_of(inverse, c, r);
            end_by_first(r, c) = -by_first(r, c);
            end_by_first(3 + r, c) = c < 3 ? -by_second(3 + r, c) : -moment_of(by_first, c, r);
        }
    for (int c = 0; c < 3; ++c) {
        end_by_first(3, 3 + c) = end_by_first(3, 3 + c) + by_turn[c].moment.x;
        end_by_first(4, 3 + c) = end_by_first(4, 3 + c) + by_turn[c].moment.y;
        end_by_first(5, 3 + c) = end_by_first(5, 3 + c) + by_turn[c].moment.z;
    }
    const Pack start_wrench[6] = {n0.x, n0.y, n0.z, m0.x, m0.y, m0.z};
    const Pack end_wrench[6] = {p.n.x, p.n.y, p.n.z, p.y.moment.x, p.y.moment.y, p.y.moment.z};
    Pack(&force)[12] = l.force;
    Pack& sum = l.sum;
    sum = zero;
    for (int r = 0; r < 6; ++r) {
        Pack first = inverse(r, 0) * gap[0], second = by_second(r, 0) * gap[0];
        for (int c = 1; c < 6; ++c) first = first + inverse(r, c) * gap[c], second = second + by_second(r, c) * gap[c];
        force[r] = first - start_wrench[r];
        force[6 + r] = end_wrench[r] - second;
        // Zero times a number is zero, and NaN times an infinity or a NaN.
        sum = sum + zero * (force[r] + force[6 + r] + gap[r]);
        for (int c = 0; c < 6; ++c) sum = sum + zero * (inverse(r, c) + end_by_first(r, c));
    }
}

void linearise_pack(const Start* starts, const Linear* out, int count, int steps, Loads loads) {
    Pieces p(starts, count);
    const Material of(starts, count);
    const double *from[W], *position[W], *rotation[W];
    for (int lane = 0; lane < W; ++lane) {
        const int i = lane < count ? lane : count - 1;
        from[lane] = starts[i].position;
        position[lane] = out[i].second_position, rotation[lane] = out[i].second_rotation;
    }
    const V node_axes[3] = {gather(rotation, 0), gather(rotation, 3), gather(rotation, 6)};
    Linearised l;
    linearise_pieces(p, of.load.force, StepOf(of, steps), steps, gather(from, 0), gather(position, 0), node_axes, loads,
                     l);

    for (int lane = 0; lane < count; ++lane) {
        const Linear& o = out[lane];
        write_end(p, l.binormal, starts[lane].position, o.end, lane);
        for (int r = 0; r < 6; ++r) o.gap[r] = l.gap[r].get(lane);
        for (int r = 0; r < 12; ++r) o.force[r] = l.force[r].get(lane);
        for (int c = 0; c < 6; ++c) {
            for (int r = 0; r < 6; ++r) {
                const double b = l.inverse(r, c).get(lane);
                o.inverse[6 * c + r] = b;
                o.stiffness[12 * c + r] = l.by_first(r, c).get(lane);
                o.stiffness[12 * c + 6 + r] = l.end_by_first(r, c).get(lane);
                o.stiffness[12 * (6 + c) + r] = -b;
                o.stiffness[12 * (6 + c) + 6 + r] = l.by_second(r, c).get(lane);
            }
            for (int r = 0; r < 3; ++r) {
                o.wrench_by_wrench[6 * c + r] = r == c ? 1.0 : 0.0;
                o.wrench_by_wrench[6 * c + 3 + r] = l.moment_by_wrench[c][r].get(lane);
            }
        }
        for (int c = 0; c < 3; ++c) {
            for (int r = 0; r < 6; ++r) o.end_by_pose[6 * c + r] = r == c ? 1.0 : 0.0;
            put(o.end_by_pose + 6 * (3 + c), l.by_turn[c].position, lane);
            put(o.end_by_pose + 6 * (3 + c) + 3, l.by_turn[c].rotation, lane);
        }
        *o.regular = l.sum.get(lane) == 0.0;
    }
}

void shoot(const Start* starts, const End* ends, int count, int steps) {
    for (int first = 0; first < count; first += W) {
        const int here = count - first < W ? count - first : W;
        Pieces p(starts + first, here);
        advance(p, StepOf(Material(starts + first, here), steps), steps);
        const V binormal = cross(p.y.tangent, p.y.director);
        for (int lane = 0; lane < here; ++lane)
            write_end(p, binormal, starts[first + lane].position, ends[first + lane], lane);
    }
}

void differentiate(const Start* starts, const Slope* slopes, const EndSlopes* out, int count, int steps) {
    const Pack zero(0.0);
    for (int first = 0; first < count; first += W) {
        const int here = count - first < W ? count - first : W;
        Pieces p(starts + first, here);
        const Material of(starts + first, here);
        const V nothing{zero, zero, zero};
        Variation<Pack> z{nothing, nothing, nothing};
        V force;
        advance_with(p, of, steps, Parameter(starts + first, slopes + first, here, of), z, force);
        for (int lane = 0; lane < here; ++lane) {
            put(out[first + lane].pose, z.position, lane);
            put(out[first + lane].pose + 3, z.rotation, lane);
            put(out[first + lane].wrench, force, lane);
            put(out[first + lane].wrench + 3, z.moment, lane);
        }
    }
}

void linearise(const Start* starts, const Linear* out, int count, int steps, Loads loads) {
    for (int first = 0; first < count; first += W) {
        const int here = count - first < W ? count - first : W;
        linearise_pack(starts + first, out + first, here, steps, loads);
    }
}

/// Sums of `panels_here` panels, whose rows begin at `row` and are `stride` apart, beside each other: a weight is read
/// once for all.
template <int panels_here>
SOFTLIMB_ALWAYS_INLINE void combine_some(const double* row, std::ptrdiff_t stride, int count, const double* weights,
                                         double* sums, std::ptrdiff_t sum_stride) {
    Pack sum[panels_here][combined];
    for (auto& of_panel : sum)
        for (Pack& p : of_panel) p = Pack(0.0);
    for (int k = 0; k < count; ++k) {
        Pack numbers[panels_here];
        for (int i = 0; i < panels_here; ++i) numbers[i] = load_some(row + stride * i + combined * k, W);
        for (int j = 0; j < combined; ++j) {
            const Pack weight(weights[combined * k + j]);
            for (int i = 0; i < panels_here; ++i) sum[i][j] = sum[i][j] + weight * numbers[i];
        }
    }
    for (int i = 0; i < panels_here; ++i)
        for (int j = 0; j < combined; ++j) store_some(sums + sum_stride * j + combined * i, sum[i][j], W);
}

void combine(const double* panels, int count, int panel_count, const double* weights, double* sums) {
    static_assert(combined % W == 0);
    constexpr int beside = W == 8 ? 3 : 1;  // as many as the registers hold
    const std::ptrdiff_t stride = static_cast<std::ptrdiff_t>(combined) * count;
    const std::ptrdiff_t sum_stride = static_cast<std::ptrdiff_t>(combined) * panel_count;
    for (int part = 0; part < combined; part += W) {
        int panel = 0;
        for (; panel + beside <= panel_count; panel += beside)
            combine_some<beside>(panels + stride * panel + part, stride, count, weights, sums + combined * panel + part,
                                 sum_stride);
        for (; panel < panel_count; ++panel)
            combine_some<1>(panels + stride * panel + part, stride, count, weights, sums + combined * panel + part,
                            sum_stride);
    }
}

#include "chains.ipp"
#include "geodesics.ipp"
#include "limbs.ipp"
#include "shots.ipp"

}  // namespace

extern const Kernel kernel;
const Kernel kernel{SOFTLIMB_INSTRUCTION_SET_NAME,
                    W,
                    &shoot,
                    &differentiate,
                    &linearise,
                    &geodesics,
                    &condense,
                    &carry,
                    &combine,
                    &shoot_alone,
                    limbs::functions};

}  // namespace softlimb::rod::lanes::SOFTLIMB_INSTRUCTION_SET
