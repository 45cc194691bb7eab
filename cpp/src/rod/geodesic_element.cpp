#include "softlimb/rod/element.hpp"

namespace softlimb::rod {
namespace {

/// Stiffness of the six strains (v, u) of a section, the inverse of its compliance.
Matrix6 strain_stiffness(const Section& s) {
    Matrix6 k = Matrix6::Zero();
    k.diagonal() << s.shear, s.shear, s.axial, s.bending, s.bending, s.torsion;
    if (s.extension_twist != 0.0) {
        const double c11 = 1.0 / s.axial, c22 = 1.0 / s.torsion, c12 = s.extension_twist;
        const double determinant = c11 * c22 - c12 * c12;
        k(2, 2) = c22 / determinant;
        k(5, 5) = c11 / determinant;
        k(2, 5) = k(5, 2) = -c12 / determinant;
    }
    return k;
}

struct Geodesic {
    Vector6 xi;      // twist from the first to the second node
    Vector6 wrench;  // in section axes, constant
    Matrix6 stiffness;
    double energy;

    Geodesic(const RodPiece& piece, const Pose& first, const Pose& second)
        : xi(log_se3(first.inverse() * second)), stiffness(strain_stiffness(*piece.section)) {
        Vector6 strain = xi / piece.length;
        strain(2) -= 1.0;
        strain(5) -= piece.section->rest_twist;
        wrench = stiffness * strain;
        energy = 0.5 * piece.length * strain.dot(wrench);
    }
};

double load_potential(const RodPiece& piece, const Pose& first, const Pose& second) {
    const Vector3 f = eigen(piece.load.force);
    return -0.5 * piece.length * f.dot(first.position + second.position);
}

}  // namespace

double geodesic_energy(const RodPiece& piece, const Pose& first, const Pose& second) {
    return Geodesic(piece, first, second).energy + load_potential(piece, first, second);
}

Vector6 geodesic_base_wrench(const RodPiece& piece, const Pose& first, const Pose& second) {
    const Geodesic g(piece, first, second);
    const Vector6 in_section = RightJacobianInverse(-g.xi).matrix().transpose() * g.wrench;
    Vector6 wrench;
    wrench << first.rotation * in_section.head<3>(), first.rotation * in_section.tail<3>();
    return wrench;
}

double geodesic_element(const RodPiece& piece, const Pose& first, const Pose& second, ElementStiffness& out) {
    const Geodesic g(piece, first, second);
    const RightJacobianInverse right(g.xi), left(-g.xi);
    const Matrix6 &r = right.matrix(), &l = left.matrix();
    // dxi = r eta2 - l eta1 in node axes; forces in node axes: (-l^T w, r^T w).
    const Matrix6 k = g.stiffness / piece.length;
    const Matrix6 kr = r.transpose() * k + right.derivative(g.wrench);    // d(r^T w)/dxi
    const Matrix6 kl = -(l.transpose() * k) + left.derivative(g.wrench);  // d(-l^T w)/dxi, as l = r(-xi)
    const Vector6 f1 = -(l.transpose() * g.wrench), f2 = r.transpose() * g.wrench;

    // To base axes: forces turn with their node, f_base = R f, df_base = R df + dtheta x f_base.
    const auto turn = [](const Matrix3& rotation, const Matrix6& m) {
        Matrix6 t;
        t << rotation * m.topLeftCorner<3, 3>(), rotation * m.topRightCorner<3, 3>(),
            rotation * m.bottomLeftCorner<3, 3>(), rotation * m.bottomRightCorner<3, 3>();
        return t;
    };
    const auto turn_columns = [](const Matrix6& m, const Matrix3& rotation) {
        Matrix6 t;
        t.leftCols<3>() = m.leftCols<3>() * rotation.transpose();
        t.rightCols<3>() = m.rightCols<3>() * rotation.transpose();
        return t;
    };
    const Matrix3 &r1 = first.rotation, &r2 = second.rotation;
    out.force << r1 * f1.head<3>(), r1 * f1.tail<3>(), r2 * f2.head<3>(), r2 * f2.tail<3>();
    out.stiffness.topLeftCorner<6, 6>() = turn_columns(turn(r1, -kl * l), r1);
    out.stiffness.topRightCorner<6, 6>() = turn_columns(turn(r1, kl * r), r2);
    out.stiffness.bottomLeftCorner<6, 6>() = turn_columns(turn(r2, -kr * l), r1);
    out.stiffness.bottomRightCorner<6, 6>() = turn_columns(turn(r2, kr * r), r2);
    for (int node = 0; node < 2; ++node) {
        const int at = 6 * node;
        out.stiffness.block<3, 3>(at, at + 3) -= hat(out.force.segment<3>(at));
        out.stiffness.block<3, 3>(at + 3, at + 3) -= hat(out.force.segment<3>(at + 3));
    }
    // Lumped load: minus half the load on each node.
    const Vector3 half_force = 0.5 * piece.length * eigen(piece.load.force);
    const Vector3 half_moment = 0.5 * piece.length * eigen(piece.load.moment);
    out.force.segment<3>(0) -= half_force;
    out.force.segment<3>(3) -= half_moment;
    out.force.segment<3>(6) -= half_force;
    out.force.segment<3>(9) -= half_moment;
    return g.energy + load_potential(piece, first, second);
}

}  // namespace softlimb::rod
