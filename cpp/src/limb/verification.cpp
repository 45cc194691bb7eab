// Written apart from the solver's kernel on purpose: quaternions instead of directors, strains in section axes instead
// of the tangent form, a plain RK4 instead of the high-order method. Slow and simple.
#include <algorithm>
#include <cmath>

#include "softlimb/largest.hpp"
#include "softlimb/limb/posture.hpp"

namespace softlimb::limb {
namespace {

struct State {
    Vector3 p;
    Eigen::Quaterniond q;
    Vector3 n, m;
};

State rate(const Section& section, const Vector3& f, const Vector3& l, const State& y) {
    const Matrix3 r = y.q.normalized().toRotationMatrix();
    const Vector3 n = r.transpose() * y.n, m = r.transpose() * y.m;
    double strain, compliance;
    axial_strain(section.axial_law, n.z(), strain, compliance);
    const Vector3 v(n.x() / section.shear, n.y() / section.shear, 1.0 + strain + section.extension_twist * m.z());
    const Vector3 u(m.x() / section.bending, m.y() / section.bending,
                    section.rest_twist + section.extension_twist * n.z() + m.z() / section.torsion);
    const Vector3 dp = r * v;
    const Eigen::Quaterniond dq = y.q * Eigen::Quaterniond(0.0, 0.5 * u.x(), 0.5 * u.y(), 0.5 * u.z());
    return {dp, dq, -f, -dp.cross(y.n) - l};
}

State add(const State& y, double h, const State& d) {
    return {y.p + h * d.p, Eigen::Quaterniond(y.q.coeffs() + h * d.q.coeffs()), y.n + h * d.n, y.m + h * d.m};
}

State integrate(const rod::RodPiece& piece, State y, int steps) {
    const double h = piece.length / steps;
    const Vector3 f = eigen(piece.load.force), l = eigen(piece.load.moment);
    for (int i = 0; i < steps; ++i) {
        const State k1 = rate(*piece.section, f, l, y), k2 = rate(*piece.section, f, l, add(y, 0.5 * h, k1)),
                    k3 = rate(*piece.section, f, l, add(y, 0.5 * h, k2)),
                    k4 = rate(*piece.section, f, l, add(y, h, k3));
        y = add(add(add(add(y, h / 6.0, k1), h / 3.0, k2), h / 3.0, k3), h / 6.0, k4);
        y.q.normalize();
    }
    return y;
}

/// End of a piece, RK4 with halved steps until the end is good to 1e-13 of the piece, or the steps are `most_steps`.
State converged_end(const rod::RodPiece& piece, const State& base, int most_steps) {
    State coarse = integrate(piece, base, 16);
    for (int steps = 32; steps <= most_steps; steps *= 2) {
        const State fine = integrate(piece, base, steps);
        const double change = (fine.p - coarse.p).norm() / piece.length + (fine.q.coeffs() - coarse.q.coeffs()).norm();
        // RK4 halves to a sixteenth, so the finer value is fifteen times better than the change.
        if (change < 1.5e-12) return fine;
        coarse = fine;
    }
    return coarse;
}

}  // namespace

Verification verify(const Posture& posture) {
    const Geometry& geometry = *posture.geometry;
    const Scene& scene = posture.scene;
    const Shape& shape = posture.solution.shape;
    Verification errors;
    double force = 0.0, moment = 0.0;
    for (std::size_t i = 0; i < scene.rods.size(); ++i) {
        const double length = scene.rods[i].rest_length;
        force = std::max(force, scene.rods[i].section.bending / (length * length));
        moment = std::max(moment, scene.rods[i].section.bending / length);
        for (const Vector6& w : shape.rods[i].wrenches) {
            force = std::max(force, w.head<3>().norm());
            moment = std::max(moment, w.tail<3>().norm());
        }
    }
    std::vector<Vector3> plate_force(geometry.plates(), Vector3::Zero());
    std::vector<Vector3> plate_moment(geometry.plates(), Vector3::Zero());
    double carried = 0.0;  // largest moment of a force about its plate's origin
    int i = 0;
    for (int j = 0; j < geometry.plates(); ++j) {
        const Pose foot = geometry.footing(j, shape.plates);
        const Pose& plate = shape.plates[j];
        for (const Placement& place : geometry.segments[j].rods) {
            const RodShape& rod = shape.rods[i];
            const rod::RodPiece piece{&scene.rods[i].section, scene.rods[i].rest_length / rod.elements(),
                                      scene.line_load(i)};
            ++i;
            Pose at = foot * place.base;
            const Vector3 n0 = rod.wrenches[0].head<3>(), m0 = rod.wrenches[0].tail<3>();
            if (j > 0) {
                const Vector3 arm = at.position - shape.plates[j - 1].position;
                plate_force[j - 1] -= n0;
                plate_moment[j - 1] -= m0 + arm.cross(n0);
                grow(carried, arm.norm() * n0.norm());
            }
            Vector3 n_end = n0, m_end = m0;
            for (int e = 0; e < rod.elements(); ++e) {
                const State base{at.position, Eigen::Quaterniond(at.rotation), rod.wrenches[e].head<3>(),
                                 rod.wrenches[e].tail<3>()};
                // Beside an error of a tenth of the limb, as the best point of a failed solve has it, digits do not
                // matter, and its hundreds of mad pieces would take seconds.
                const bool hopeless = !(errors.position_error < 0.1 && errors.rotation_error < 0.1);
                const State end = converged_end(piece, base, hopeless ? 32 : 16384);
                n_end = end.n, m_end = end.m;
                const bool last = e + 1 == rod.elements();
                const Pose target = last ? plate * place.end : rod.nodes[e + 1];
                grow(errors.position_error, (end.p - target.position).norm() / geometry.length);
                grow(errors.rotation_error, log_so3(end.q.toRotationMatrix() * target.rotation.transpose()).norm());
                if (!last) {
                    grow(errors.force_error, (n_end - rod.wrenches[e + 1].head<3>()).norm() / force);
                    grow(errors.moment_error, (m_end - rod.wrenches[e + 1].tail<3>()).norm() / moment);
                }
                at = target;
            }
            plate_force[j] += n_end;
            const Vector3 arm = at.position - plate.position;
            plate_moment[j] += m_end + arm.cross(n_end);
            grow(carried, arm.norm() * n_end.norm());
        }
    }
    for (int j = 0; j < geometry.plates(); ++j) {
        const Segment& segment = geometry.segments[j];
        const Pose& plate = shape.plates[j];
        Vector3 f = scene.wrenches[j].head<3>(), m = scene.wrenches[j].tail<3>();
        if (scene.following) f = plate.rotation * f, m = plate.rotation * m;
        const Vector3 weight = segment.plate_mass * scene.gravity;
        const Vector3 centre = 0.5 * segment.plate_thickness * plate.rotation.col(2);
        plate_force[j] -= f + weight + posture.solution.reactions[j].head<3>();
        plate_moment[j] -= m + centre.cross(weight) + posture.solution.reactions[j].tail<3>();
        grow(errors.force_error, plate_force[j].norm() / force);
        // Rods that stand a million times their length apart balance moments far larger than their own; the rounding of
        // those is no error of the posture.
        grow(errors.moment_error, plate_moment[j].norm() / (moment + 1e-9 * carried));
        const Hold& hold = scene.holds[j];
        const Vector3 shift = plate.position - hold.pose.position;
        const Vector3 turn = log_so3(plate.rotation * hold.pose.rotation.transpose());
        for (int k = 0; k < 3; ++k) {
            if (hold.held[k]) grow(errors.hold_error, std::abs(shift(k)) / geometry.length);
            if (hold.held[3 + k]) grow(errors.hold_error, std::abs(turn(k)));
        }
    }
    return errors;
}

}  // namespace softlimb::limb
