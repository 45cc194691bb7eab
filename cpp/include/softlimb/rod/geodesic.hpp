#pragma once
// The geodesic element in any scalar: constant strain on SE(3) between two nodes. A twist is a rotation vector of dual
// numbers, phi + eps rho, so that everything on SE(3) is a formula of SO(3) and its derivative, in 3 x 3 blocks.
// Source: cpp/MECHANICS.md, "Geodesic element".
#include "softlimb/mat3.hpp"

namespace softlimb::rod {

/// Stiffness of the six strains (v, u): shear twice, axial, bending twice, torsion, and axial with torsion.
template <class S>
struct StrainStiffness {
    S shear, axial, bending, torsion, coupling;
};

/// What a geodesic element is made of. beta(z), z = phi^2, is the even coefficient of the inverse Jacobian
/// 1 + hat(phi)/2 + beta hat(phi)^2, given with two derivatives in z.
template <class S>
struct GeodesicData {
    Vec3<S> rho, phi;  // twist from the first to the second node
    S beta, beta_slope, beta_curvature;
    Mat3<S> first, second;  // rotations of the nodes
    StrainStiffness<S> stiffness;
    S length, rest_twist;
    Vec3<S> half_force, half_moment;  // load on each node
};

/// A 6 x 6 matrix in 3 x 3 blocks.
template <class S>
struct Blocks {
    Mat3<S> at[2][2];
};

/// Forces on the nodes, (force, moment) each, and their derivatives [node][node], base axes.
template <class S>
struct GeodesicResult {
    Vec3<S> force[2][2];
    Blocks<S> stiffness[2][2];
};

template <class S>
SOFTLIMB_ALWAYS_INLINE void geodesic_wrench(const GeodesicData<S>& d, Vec3<S>& n, Vec3<S>& m) {
    const auto& k = d.stiffness;
    const S per_length = S(1.0) / d.length;
    const S stretch = d.rho.z * per_length - S(1.0), twist = d.phi.z * per_length - d.rest_twist;
    n = {k.shear * d.rho.x * per_length, k.shear * d.rho.y * per_length, k.axial * stretch + k.coupling * twist};
    m = {k.bending * d.phi.x * per_length, k.bending * d.phi.y * per_length, k.torsion * twist + k.coupling * stretch};
}

template <class S>
SOFTLIMB_ALWAYS_INLINE GeodesicResult<S> geodesic(const GeodesicData<S>& d) {
    const Vec3<S>&rho = d.rho, &phi = d.phi;
    const S two(2.0), half(0.5), beta = d.beta, z = dot(phi, phi), across = dot(phi, rho);
    // dxi = r eta2 - l eta1 in node axes, r = [A B; 0 A], l = [A^T B^T; 0 A^T]: B is A's derivative along rho.
    Mat3<S> a = beta * outer(phi, phi) + half * hat(phi);
    a.add_to_diagonal(S(1.0) - beta * z);
    Mat3<S> b =
        half * hat(rho) + beta * (outer(rho, phi) + outer(phi, rho)) + (two * d.beta_slope * across) * outer(phi, phi);
    b.add_to_diagonal(-two * across * (beta + d.beta_slope * z));
    const Mat3<S> at = transposed(a), bt = transposed(b);

    Vec3<S> n, m;
    geodesic_wrench(d, n, m);

    // Derivative of A^T x to phi at fixed x: its odd part hat(x)/2 and its even part.
    const auto even = [&](const Vec3<S>& x) SOFTLIMB_LAMBDA_INLINE {
        const S along = dot(phi, x);
        Mat3<S> g = beta * outer(phi, x) - (two * beta) * outer(x, phi) +
                    (two * d.beta_slope) * outer(along * phi - z * x, phi);
        g.add_to_diagonal(beta * along);
        return g;
    };
    const Mat3<S> even_n = even(n), even_m = even(m), odd_n = half * hat(n), odd_m = half * hat(m);
    // Derivative to phi of what n and rho make in the moment, (dA^T n/dphi) rho.
    const S n_along = dot(phi, n), n_rho = dot(n, rho);
    const Vec3<S> bent = n_along * phi - z * n;
    const Vec3<S> mixed = n_rho * phi + n_along * rho - two * across * n;
    Mat3<S> h =
        beta * (outer(rho, n) - two * outer(n, rho)) +
        (two * d.beta_slope) * (outer(mixed, phi) + outer(bent, rho) + across * (outer(phi, n) - two * outer(n, phi))) +
        (S(4.0) * d.beta_curvature * across) * outer(bent, phi);
    h.add_to_diagonal(beta * n_rho + two * d.beta_slope * across * n_along);

    const S per_length = S(1.0) / d.length;
    const auto& k = d.stiffness;
    const S kv = per_length * k.shear, ka = per_length * k.axial, kb = per_length * k.bending,
            kt = per_length * k.torsion, kc = per_length * k.coupling;
    const auto by_v = [&](const Mat3<S>& x) SOFTLIMB_LAMBDA_INLINE {
        return Mat3<S>{{kv * x.column[0], kv * x.column[1], ka * x.column[2]}};
    };
    const auto by_u = [&](const Mat3<S>& x) SOFTLIMB_LAMBDA_INLINE {
        return Mat3<S>{{kb * x.column[0], kb * x.column[1], kt * x.column[2]}};
    };
    const auto coupled = [&](const Mat3<S>& x) SOFTLIMB_LAMBDA_INLINE {
        const S zero(0.0);
        const Vec3<S> nothing{zero, zero, zero};
        return Mat3<S>{{nothing, nothing, kc * x.column[2]}};
    };
    // Derivatives to xi of r^T w (second node) and of l^T w (first node, whose force is minus that); the odd parts
    // change sign with xi.
    const auto by_twist = [&](const Mat3<S>& axes, const Mat3<S>& s, const Mat3<S>& t, const S& odd)
                              SOFTLIMB_LAMBDA_INLINE {
                                  const Mat3<S> gn = even_n + odd * odd_n, gm = even_m + odd * odd_m;
                                  Blocks<S> out;
                                  out.at[0][0] = axes * by_v(s);
                                  out.at[0][1] = axes * (coupled(s) + gn);
                                  out.at[1][0] = axes * (by_v(t) + coupled(s) + gn);
                                  out.at[1][1] = axes * (coupled(t) + by_u(s) + gm + h);
                                  return out;
                              };
    const Blocks<S> second = by_twist(d.second, at, bt, S(1.0)), first = by_twist(d.first, a, b, S(-1.0));

    // Columns of dxi by the nodes' moves, base axes: (r R2^T) and (l R1^T).
    const Mat3<S> to_second = transposed(d.second), to_first = transposed(d.first);
    const Mat3<S> ar = a * to_second, br = b * to_second, al = at * to_first, bl = bt * to_first;
    const auto times = [](const Blocks<S>& x, const Mat3<S>& s, const Mat3<S>& t, const S& sign)
                           SOFTLIMB_LAMBDA_INLINE {
                               Blocks<S> out;
                               for (int row = 0; row < 2; ++row) {
                                   out.at[row][0] = sign * (x.at[row][0] * s);
                                   out.at[row][1] = sign * (x.at[row][0] * t + x.at[row][1] * s);
                               }
                               return out;
                           };
    GeodesicResult<S> out;
    const S one(1.0);
    out.stiffness[1][1] = times(second, ar, br, one);
    out.stiffness[1][0] = times(second, al, bl, -one);
    out.stiffness[0][1] = times(first, ar, br, -one);
    out.stiffness[0][0] = times(first, al, bl, one);
    out.force[0][0] = -(d.first * (a * n));
    out.force[0][1] = -(d.first * (b * n + a * m));
    out.force[1][0] = d.second * (at * n);
    out.force[1][1] = d.second * (bt * n + at * m);
    for (int node = 0; node < 2; ++node) {
        // Forces turn with their node: f_base = R f, df_base = R df + dtheta x f_base.
        Blocks<S>& own = out.stiffness[node][node];
        own.at[0][1] = own.at[0][1] - hat(out.force[node][0]);
        own.at[1][1] = own.at[1][1] - hat(out.force[node][1]);
        out.force[node][0] = out.force[node][0] - d.half_force;
        out.force[node][1] = out.force[node][1] - d.half_moment;
    }
    return out;
}

}  // namespace softlimb::rod
