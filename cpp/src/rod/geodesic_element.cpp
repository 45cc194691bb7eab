#include "softlimb/rod/element.hpp"
#include "softlimb/rod/geodesic.hpp"

namespace softlimb::rod {
namespace {

/// Stiffness of the six strains (v, u) of a section, the inverse of its compliance.
StrainStiffness<double> strain_stiffness(const Section& s) {
    StrainStiffness<double> k{s.shear, s.axial, s.bending, s.torsion, 0.0};
    if (s.extension_twist != 0.0) {
        const double c11 = 1.0 / s.axial, c22 = 1.0 / s.torsion, c12 = s.extension_twist;
        const double determinant = c11 * c22 - c12 * c12;
        k.axial = c22 / determinant, k.torsion = c11 / determinant, k.coupling = -c12 / determinant;
    }
    return k;
}

Mat3<double> mat3(const Matrix3& r) { return {{vec3(r.col(0)), vec3(r.col(1)), vec3(r.col(2))}}; }

GeodesicData<double> data_of(const RodPiece& piece, const Pose& first, const Pose& second) {
    const Vector6 xi = log_se3(first.inverse() * second);
    const InverseJacobianCoefficient c(xi.tail<3>().squaredNorm());
    return {vec3(xi.head<3>()),
            vec3(xi.tail<3>()),
            c.beta,
            c.slope,
            c.curvature,
            mat3(first.rotation),
            mat3(second.rotation),
            strain_stiffness(*piece.section),
            piece.length,
            piece.section->rest_twist,
            0.5 * piece.length * piece.load.force,
            0.5 * piece.length * piece.load.moment};
}

}  // namespace

double geodesic_energy(const RodPiece& piece, const Vector6& twist, const Vector3& positions) {
    const StrainStiffness<double> k = strain_stiffness(*piece.section);
    Vector6 strain = twist / piece.length;
    strain(2) -= 1.0;
    strain(5) -= piece.section->rest_twist;
    const double density = k.shear * (strain(0) * strain(0) + strain(1) * strain(1)) +
                           k.bending * (strain(3) * strain(3) + strain(4) * strain(4)) +
                           k.axial * strain(2) * strain(2) + k.torsion * strain(5) * strain(5) +
                           2.0 * k.coupling * strain(2) * strain(5);
    return 0.5 * piece.length * (density - eigen(piece.load.force).dot(positions));
}

Vector6 geodesic_base_wrench(const RodPiece& piece, const Pose& first, const Pose& second) {
    GeodesicData<double> d = data_of(piece, first, second);
    d.half_force = d.half_moment = {};
    const GeodesicResult<double> r = geodesic(d);
    Vector6 wrench;
    wrench << -eigen(r.force[0][0]), -eigen(r.force[0][1]);
    return wrench;
}

void geodesic_element(const RodPiece& piece, const Pose& first, const Pose& second, ElementStiffness& out) {
    const GeodesicResult<double> r = geodesic(data_of(piece, first, second));
    for (int i = 0; i < 2; ++i)
        for (int u = 0; u < 2; ++u) {
            const int row = 6 * i + 3 * u;
            out.force.segment<3>(row) = eigen(r.force[i][u]);
            for (int j = 0; j < 2; ++j)
                for (int v = 0; v < 2; ++v)
                    for (int c = 0; c < 3; ++c)
                        out.stiffness.block<3, 1>(row, 6 * j + 3 * v + c) = eigen(r.stiffness[i][j].at[u][v].column[c]);
        }
}

lanes::Geodesic geodesic_lane(const RodPiece& piece, const Vector6& twist, const Matrix3& first,
                              const Matrix3& second) {
    lanes::Geodesic lane;
    const InverseJacobianCoefficient c(twist.tail<3>().squaredNorm());
    for (int i = 0; i < 6; ++i) lane.twist[i] = twist(i);
    lane.beta[0] = c.beta, lane.beta[1] = c.slope, lane.beta[2] = c.curvature;
    lane.first_rotation = first.data(), lane.second_rotation = second.data();
    const StrainStiffness<double> k = strain_stiffness(*piece.section);
    lane.shear = k.shear, lane.axial = k.axial, lane.bending = k.bending;
    lane.torsion = k.torsion, lane.coupling = k.coupling;
    lane.length = piece.length, lane.rest_twist = piece.section->rest_twist;
    const auto& [f, l] = piece.load;
    const double half = 0.5 * piece.length;
    lane.half_force[0] = half * f.x, lane.half_force[1] = half * f.y, lane.half_force[2] = half * f.z;
    lane.half_moment[0] = half * l.x, lane.half_moment[1] = half * l.y, lane.half_moment[2] = half * l.z;
    return lane;
}

}  // namespace softlimb::rod
