#pragma once
// Rotations, poses, and the exponential map of SE(3) with the coefficients that its derivatives need.
// Twists and wrenches are ordered (linear, angular). Source: cpp/MECHANICS.md, "Rotations".
#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>

#include "softlimb/vec3.hpp"

namespace softlimb {

using Vector3 = Eigen::Vector3d;
using Matrix3 = Eigen::Matrix3d;
using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Vector12 = Eigen::Matrix<double, 12, 1>;
using Matrix12 = Eigen::Matrix<double, 12, 12>;

inline Vec3<double> vec3(const Vector3& a) { return {a.x(), a.y(), a.z()}; }
inline Vector3 eigen(const Vec3<double>& a) { return {a.x, a.y, a.z}; }

/// Skew matrix: hat(a) b = a x b.
inline Matrix3 hat(const Vector3& a) {
    Matrix3 m;
    m << 0.0, -a.z(), a.y(), a.z(), 0.0, -a.x(), -a.y(), a.x(), 0.0;
    return m;
}

/// Rigid pose: x_outer = rotation x_inner + position.
struct Pose {
    Vector3 position = Vector3::Zero();
    Matrix3 rotation = Matrix3::Identity();

    Pose operator*(const Pose& b) const { return {position + rotation * b.position, rotation * b.rotation}; }
    Pose inverse() const { return {-(rotation.transpose() * position), rotation.transpose()}; }
    bool finite() const { return position.allFinite() && rotation.allFinite(); }
    bool operator==(const Pose&) const = default;
};

/// The homogeneous matrix of a pose, row by row: 16 numbers.
inline void write_matrix(const Pose& pose, double* x) {
    for (int r = 0; r < 3; ++r) {
        for (int c = 0; c < 3; ++c) x[4 * r + c] = pose.rotation(r, c);
        x[4 * r + 3] = pose.position(r);
    }
    x[12] = x[13] = x[14] = 0.0, x[15] = 1.0;
}

/// Rotation by the rotation vector `w` [rad].
Matrix3 exp_so3(const Vector3& w);
/// Rotation vector of `r`, angle in [0, pi].
Vector3 log_so3(const Matrix3& r);
/// One step of Newton's iteration towards the nearest rotation: enough for a product of rotations, which is one to
/// rounding, and must still be one many products later.
Matrix3 orthonormalised(const Matrix3& r);
/// The rotation whose third column is along `tangent`, and whose first is what `director` has across it.
Matrix3 rotation_along(const Vector3& director, const Vector3& tangent);
/// Inverse left Jacobian of SO(3): the rotation vector phi of exp(phi) changes by J_l^-1(phi) dtheta when the rotation
/// is turned by dtheta (outer frame).
Matrix3 left_jacobian_inverse(const Vector3& phi);

/// The even coefficient of the inverse Jacobians of SO(3), 1 +- hat(phi)/2 + beta hat(phi)^2, in z = |phi|^2, with its
/// first and second derivative.
struct InverseJacobianCoefficient {
    double beta, slope, curvature;
    explicit InverseJacobianCoefficient(double z);
};

/// Twist (rho, phi) with exp = the pose `g`; |phi| < 2 pi is assumed by what follows.
Vector6 log_se3(const Pose& g);
Pose exp_se3(const Vector6& xi);

}  // namespace softlimb
