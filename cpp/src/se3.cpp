#include "softlimb/se3.hpp"

#include <array>

namespace softlimb {
namespace {

/// sin(x)/x, (1 - cos x)/x^2 and (x - sin x)/x^3 in z = x^2; series where the closed forms cancel.
struct RotationSeries {
    double a, b, c;
    explicit RotationSeries(double z) {
        if (z < 0.01) {
            // Next terms are below z^6/14! ~ 1e-23.
            constexpr double f2 = 2.0, f3 = 3.0 * f2, f4 = 4.0 * f3, f5 = 5.0 * f4, f6 = 6.0 * f5, f7 = 7.0 * f6;
            constexpr double f8 = 8.0 * f7, f9 = 9.0 * f8, f10 = 10.0 * f9, f11 = 11.0 * f10, f12 = 12.0 * f11;
            a = 1.0 - z * (1.0 / f3 - z * (1.0 / f5 - z * (1.0 / f7 - z * (1.0 / f9 - z * (1.0 / f11)))));
            b = 1.0 / f2 - z * (1.0 / f4 - z * (1.0 / f6 - z * (1.0 / f8 - z * (1.0 / f10 - z * (1.0 / f12)))));
            c = 1.0 / f3 -
                z * (1.0 / f5 - z * (1.0 / f7 - z * (1.0 / f9 - z * (1.0 / f11 - z * (1.0 / (13.0 * f12))))));
        } else {
            const double x = std::sqrt(z), s = std::sin(0.5 * x);
            a = std::sin(x) / x;
            b = 2.0 * s * s / z;  // not 1 - cos x, which cancels
            c = (1.0 - a) / z;
        }
    }
};

/// Of (x/2) cot(x/2) in z = x^2: (-1)^k B_2k/(2k)!. The ratio of terms tends to 1/(4 pi^2); 12 terms reach 1e-19 at
/// z = 1.
constexpr std::array<double, 13> half_cotangent_series = {1.0,
                                                          -1.0 / 12.0,
                                                          -1.0 / 720.0,
                                                          -1.0 / 30240.0,
                                                          -1.0 / 1209600.0,
                                                          -1.0 / 47900160.0,
                                                          -691.0 / 1307674368000.0,
                                                          -1.0 / 74724249600.0,
                                                          -3617.0 / 10670622842880000.0,
                                                          -43867.0 / 5109094217170944000.0,
                                                          -174611.0 / 802857662698291200000.0,
                                                          -77683.0 / 14101100039391805440000.0,
                                                          -236364091.0 / 1693824136731743669452800000.0};

/// Of asin(x)/x in z = x^2. The ratio of terms tends to 1: below z = 0.02 the terms left out are under 1e-20.
constexpr std::array<double, 11> arcsine_series = {1.0,
                                                   1.0 / 6.0,
                                                   3.0 / 40.0,
                                                   5.0 / 112.0,
                                                   35.0 / 1152.0,
                                                   63.0 / 2816.0,
                                                   231.0 / 13312.0,
                                                   143.0 / 10240.0,
                                                   6435.0 / 557056.0,
                                                   12155.0 / 1245184.0,
                                                   46189.0 / 5505024.0};

/// (x/2) cot(x/2) as a function of z = x^2, with first and second derivative in z.
void half_cotangent(double z, double& q, double& dq, double& ddq) {
    if (z < 1.0) {
        q = dq = ddq = 0.0;
        for (int k = 12; k >= 0; --k) {
            ddq = ddq * z + 2.0 * dq;
            dq = dq * z + q;
            q = q * z + half_cotangent_series[k];
        }
        return;
    }
    const double x = std::sqrt(z), half = 0.5 * x;
    const double cot = std::cos(half) / std::sin(half), csc2 = 1.0 + cot * cot;
    q = half * cot;
    const double q_x = 0.5 * (cot - half * csc2);               // dq/dx
    const double q_xx = -0.5 * csc2 + 0.5 * half * csc2 * cot;  // d2q/dx2
    dq = q_x / (2.0 * x);
    ddq = (q_xx - q_x / x) / (4.0 * z);
}

}  // namespace

Matrix3 exp_so3(const Vector3& w) {
    // 1 + a hat(w) + b hat(w)^2, with hat(w)^2 = w w^T - w^2.
    const double z = w.squaredNorm();
    const RotationSeries f(z);
    Matrix3 r = (f.b * w) * w.transpose() + f.a * hat(w);
    r.diagonal().array() += 1.0 - f.b * z;
    return r;
}

Vector3 log_so3(const Matrix3& r) {
    // Small rotations by the skew part, whose length is the sine: a third of the time of the quaternion and its angle.
    const Vector3 skew(0.5 * (r(2, 1) - r(1, 2)), 0.5 * (r(0, 2) - r(2, 0)), 0.5 * (r(1, 0) - r(0, 1)));
    const double z = skew.squaredNorm();
    if (z < 0.02 && r.trace() > 1.0) {
        // Of the smallest, those that a piece misses its node by, five terms are as good: the next is under 1e-21.
        double ratio = 0.0;
        for (std::size_t k = z < 1e-4 ? 5 : arcsine_series.size(); k-- > 0;) ratio = ratio * z + arcsine_series[k];
        return ratio * skew;
    }
    // Through the quaternion: no cancellation at angle zero nor at pi.
    const Eigen::Quaterniond q(r);
    const double sine = q.vec().norm(), cosine = q.w();
    if (sine < 1e-12) return (cosine < 0.0 ? -2.0 : 2.0) * q.vec();
    const double angle = 2.0 * (cosine < 0.0 ? std::atan2(-sine, -cosine) : std::atan2(sine, cosine));
    return (angle / sine) * q.vec();
}

Matrix3 orthonormalised(const Matrix3& r) { return 1.5 * r - 0.5 * r * (r.transpose() * r); }

Matrix3 rotation_along(const Vector3& director, const Vector3& tangent) {
    const Vector3 along = tangent.normalized();
    const Vector3 across = (director - director.dot(along) * along).normalized();
    Matrix3 rotation;
    rotation << across, along.cross(across), along;
    return rotation;
}

InverseJacobianCoefficient::InverseJacobianCoefficient(double z) {
    if (z < 1.0) {
        // beta = (1 - q)/z, q of `half_cotangent`, by the series of q without its first term.
        beta = slope = curvature = 0.0;
        for (int k = 12; k >= 1; --k) {
            curvature = curvature * z + 2.0 * slope;
            slope = slope * z + beta;
            beta = beta * z - half_cotangent_series[k];
        }
        return;
    }
    double q, dq, ddq;
    half_cotangent(z, q, dq, ddq);
    beta = (1.0 - q) / z;
    slope = -(dq + beta) / z;
    curvature = -(ddq + 2.0 * slope) / z;
}

Matrix3 left_jacobian_inverse(const Vector3& phi) {
    const InverseJacobianCoefficient c(phi.squaredNorm());
    const Matrix3 k = hat(phi);
    return Matrix3::Identity() - 0.5 * k + c.beta * k * k;
}

Vector6 log_se3(const Pose& g) {
    const Vector3 phi = log_so3(g.rotation);
    Vector6 xi;
    xi << left_jacobian_inverse(phi) * g.position, phi;
    return xi;
}

Pose exp_se3(const Vector6& xi) {
    const Vector3 rho = xi.head<3>(), phi = xi.tail<3>();
    const RotationSeries f(phi.squaredNorm());
    const Matrix3 k = hat(phi);
    const Matrix3 k2 = k * k;
    return {rho + f.b * k * rho + f.c * k2 * rho, Matrix3::Identity() + f.a * k + f.b * k2};
}

}  // namespace softlimb
