#include "check.hpp"
#include "examples.hpp"
#include "softlimb/se3.hpp"

using namespace softlimb;
using namespace softlimb::tests;

namespace {

// Around every change of formula (1e-12 and 0.04 and 1 in the squared angle, 0.1 in the angle, 0.01 and 0.1419 where
// the squared sine is 1e-4 and 0.02) and at both ends.
const std::vector<double> angles = {0.0,    1e-300, 1e-160, 1e-14,  1e-9,      9e-7,      1.1e-6,    1e-4, 0.0099,
                                    0.0101, 0.0999, 0.1001, 0.1418, 0.142,     0.1999,    0.2001,    0.5,  0.9999,
                                    1.0001, 1.5,    2.0,    3.0,    pi - 1e-4, pi - 1e-9, pi - 1e-15};
// A central difference of a smooth function of order one with this step: 1e-10 of truncation, 1e-11 of rounding.
constexpr double step = 1e-5, slope_tolerance = 1e-8;

Vector6 twist(Draw& draw, double angle) {
    Vector6 xi;
    xi << draw.matrix<Vector3>(), angle * draw.direction();
    return xi;
}

}  // namespace

CLAIM(a_rotation_is_the_exponential_of_its_logarithm_at_every_angle) {
    Draw draw(1);
    for (const double angle : angles)
        for (int k = 0; k < 20; ++k) {
            const Matrix3 r = exp_so3(angle * draw.direction());
            const Vector3 w = log_so3(r);
            // A dozen roundings of numbers of order one.
            CHECK_NEAR(exp_so3(w), r, 4e-15);
            CHECK_NEAR(w.norm(), angle, 4e-15);
            CHECK_NEAR(r.transpose() * r, Matrix3::Identity(), 4e-15);
        }
}

CLAIM(the_logarithm_is_the_axis_times_the_angle_of_the_quaternion) {
    Draw draw(9);
    for (const double angle : angles)
        for (int k = 0; k < 20; ++k) {
            if (angle > 3.1) continue;  // beyond, the sign of the axis is a matter of rounding
            const Vector3 w = angle * draw.direction();
            const Matrix3 r = exp_so3(w);
            const Eigen::AngleAxisd plain{Eigen::Quaterniond(r)};
            // A dozen roundings of a rotation's numbers, near three radians magnified by what the angle's sine lacks.
            CHECK_NEAR(log_so3(r), plain.angle() * plain.axis(), 1e-14);
            // Of a small rotation no digit is lost: its numbers off the diagonal are as small.
            if (angle < 1.0) CHECK_NEAR(log_so3(r), w, 8e-16 * angle);
        }
}

CLAIM(half_a_turn_about_each_axis_has_a_logarithm_of_length_pi) {
    for (int k = 0; k < 3; ++k) {
        Matrix3 r = -Matrix3::Identity();
        r(k, k) = 1.0;
        const Vector3 w = log_so3(r);
        CHECK_NEAR(w.norm(), pi, 4e-16 * pi);
        CHECK_NEAR(std::abs(w(k)), pi, 4e-16 * pi);
    }
}

CLAIM(a_twist_is_the_logarithm_of_its_exponential_below_half_a_turn) {
    Draw draw(2);
    for (const double angle : angles)
        for (int k = 0; k < 20; ++k) {
            if (angle > 3.1) continue;  // beyond, the sign of the logarithm is a matter of rounding
            const Vector6 xi = twist(draw, angle);
            CHECK_NEAR(log_se3(exp_se3(xi)), xi, 2e-14);
        }
}

CLAIM(a_pose_times_its_inverse_is_the_identity) {
    Draw draw(3);
    const Pose a = draw.pose(2.0), unit = a * a.inverse();
    CHECK_NEAR(unit.position, Vector3::Zero(), 1e-15);
    CHECK_NEAR(unit.rotation, Matrix3::Identity(), 1e-15);
}

CLAIM(hat_is_the_cross_product) {
    Draw draw(4);
    const Vector3 a = draw.matrix<Vector3>(), b = draw.matrix<Vector3>();
    CHECK_NEAR(hat(a) * b, a.cross(b), 1e-16);
}

CLAIM(the_coefficient_of_the_inverse_jacobian_comes_with_its_slopes) {
    // On both sides of where the series ends, at z = 1, and at zero, where beta is 1/12.
    CHECK_NEAR(InverseJacobianCoefficient(0.0).beta, 1.0 / 12.0, 1e-17);
    for (const double z : {0.0, 1e-6, 0.5, 0.99, 1.01, 4.0, 9.0}) {
        const InverseJacobianCoefficient up(z + step), down(z - step), here(z);
        if (z > 0.0) CHECK_NEAR(here.beta, (1.0 - 0.5 * std::sqrt(z) / std::tan(0.5 * std::sqrt(z))) / z, 1e-9);
        CHECK_NEAR(here.slope, (up.beta - down.beta) / (2.0 * step), slope_tolerance);
        CHECK_NEAR(here.curvature, (up.slope - down.slope) / (2.0 * step), slope_tolerance);
    }
}

CLAIM(the_left_jacobian_inverse_of_a_rotation_is_the_slope_of_its_vector) {
    Draw draw(7);
    for (const double angle : angles) {
        if (angle > 3.1) continue;
        const Vector3 phi = angle * draw.direction();
        const Matrix3 r = exp_so3(phi), jacobian = left_jacobian_inverse(phi);
        for (int k = 0; k < 3; ++k) {
            const Vector3 turn = step * Vector3::Unit(k);
            const Vector3 slope = (log_so3(exp_so3(turn) * r) - log_so3(exp_so3(-turn) * r)) / (2.0 * step);
            CHECK_NEAR(jacobian.col(k), slope, slope_tolerance);
        }
    }
}

CLAIM(orthonormalised_moves_towards_the_nearest_rotation_and_squares_the_error) {
    Draw draw(8);
    const Matrix3 r = exp_so3(draw.direction());
    for (const double size : {1e-3, 1e-6, 1e-9}) {
        const Matrix3 noise = size * draw.matrix<Matrix3>();
        const Matrix3 near = orthonormalised(r + noise);
        CHECK_NEAR(near.transpose() * near, Matrix3::Identity(), 10.0 * size * size + 1e-15);
        // The polar factor takes the symmetric part of the noise out and leaves the rest, to the square of the noise.
        const Matrix3 in_place = r.transpose() * noise;
        CHECK_NEAR(r.transpose() * near, Matrix3::Identity() + 0.5 * (in_place - in_place.transpose()),
                   10.0 * size * size + 1e-15);
    }
}
