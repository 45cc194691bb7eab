#include "softlimb/limb/balance.hpp"

namespace softlimb::limb {
namespace {

/// Derivative of (dtheta x arm) x force to dtheta.
Matrix3 turning_arm(const Vector3& arm, const Vector3& force) {
    return arm * force.transpose() - arm.dot(force) * Matrix3::Identity();
}

/// L^T g for a force at `arm` from the plate's origin.
Vector6 carried(const Vector6& g, const Vector3& arm) {
    Vector6 out = g;
    out.tail<3>() += arm.cross(Vector3(g.head<3>()));
    return out;
}

struct Arms {
    Vector3 base, end;  // from the proximal and the distal plate's origin
};

Arms arms_of(const Geometry& geometry, const std::vector<Pose>& plates, int j, const Placement& place) {
    Arms arms;
    if (j == 0) {
        arms.base = place.base.position;
    } else {
        const Vector3 local = place.base.position + Vector3(0.0, 0.0, geometry.segments[j - 1].plate_thickness);
        arms.base = plates[j - 1].rotation * local;
    }
    arms.end = plates[j].rotation * place.end.position;
    return arms;
}

}  // namespace

Vector6 plate_load(const Geometry& geometry, const Scene& scene, const Pose& plate, int j, Matrix6* derivative) {
    const Segment& segment = geometry.segments[j];
    Vector6 load = scene.wrenches[j];
    if (scene.following) load << plate.rotation * load.head<3>(), plate.rotation * load.tail<3>();
    if (derivative) {
        derivative->setZero();
        if (scene.following) {
            derivative->block<3, 3>(0, 3) = -hat(load.head<3>());
            derivative->block<3, 3>(3, 3) = -hat(load.tail<3>());
        }
    }
    if (segment.plate_mass > 0.0) {
        const Vector3 weight = segment.plate_mass * scene.gravity;
        const Vector3 arm = 0.5 * segment.plate_thickness * plate.rotation.col(2);
        load.head<3>() += weight;
        load.tail<3>() += arm.cross(weight);
        if (derivative) derivative->block<3, 3>(3, 3) += turning_arm(arm, weight);
    }
    return load;
}

Vector6 hold_gap(const Hold& hold, const Pose& plate) { return rod::pose_gap(plate, hold.pose); }

Matrix6 hold_rows(const Hold& hold, const Pose& plate) {
    Matrix6 rows = Matrix6::Identity();
    rows.bottomRightCorner<3, 3>() = left_jacobian_inverse(log_so3(plate.rotation * hold.pose.rotation.transpose()));
    return rows;
}

void Balance::resize(int plates) {
    system_.resize(plates);
    residual_.resize(plates), full_residual_.resize(plates);
    projector_.resize(plates), hold_map_.resize(plates), unshifted_.resize(plates);
}

void Balance::carry(const Geometry& geometry, const std::vector<Pose>& plates, const std::vector<Vector12>& rod_forces,
                    std::vector<Vector6>& plate_forces) {
    for (Vector6& f : plate_forces) f.setZero();
    int i = 0;
    for (int j = 0; j < geometry.plates(); ++j)
        for (const Placement& place : geometry.segments[j].rods)
            add_carried(geometry, plates, j, place, rod_forces[i++], plate_forces);
}

void Balance::add_carried(const Geometry& geometry, const std::vector<Pose>& plates, int j, const Placement& place,
                          const Vector12& rod_force, std::vector<Vector6>& plate_forces) {
    const Arms arms = arms_of(geometry, plates, j, place);
    plate_forces[j] += carried(rod_force.tail<6>(), arms.end);
    if (j > 0) plate_forces[j - 1] += carried(rod_force.head<6>(), arms.base);
}

void Balance::move_ends(const Geometry& geometry, const std::vector<Pose>& plates, const std::vector<Vector6>& moves,
                        std::vector<std::vector<Vector6>>& nodes) {
    int i = 0;
    for (int j = 0; j < geometry.plates(); ++j)
        for (const Placement& place : geometry.segments[j].rods) {
            const Arms arms = arms_of(geometry, plates, j, place);
            Vector6 &first = nodes[i].front(), &second = nodes[i].back();
            first.setZero();
            if (j > 0) {
                first = moves[j - 1];
                first.head<3>() += Vector3(first.tail<3>()).cross(arms.base);
            }
            second = moves[j];
            second.head<3>() += Vector3(second.tail<3>()).cross(arms.end);
            ++i;
        }
}

void Balance::assemble(const Geometry& geometry, const Scene& scene, const std::vector<Pose>& plates,
                       const std::vector<rod::Chain>& chains, bool symmetric) {
    system_.set_zero();
    for (Vector6& r : residual_) r.setZero();
    const auto carry = rod::lanes::kernel().carry;
    int i = 0;
    for (int j = 0; j < geometry.plates(); ++j) {
        for (const Placement& place : geometry.segments[j].rods) {
            const rod::ElementStiffness& rod = chains[i++].ends();
            const Arms arms = arms_of(geometry, plates, j, place);
            const bool on_ground = j == 0;
            carry(rod.force.data(), arms.base.data(), arms.end.data(),
                  on_ground ? nullptr : system_.diagonal[j - 1].data(),
                  on_ground ? nullptr : system_.upper[j - 1].data(), system_.lower[j].data(),
                  system_.diagonal[j].data());
            const Vector6 at_end = rod.force.tail<6>();
            residual_[j] += carried(at_end, arms.end);
            system_.diagonal[j].bottomRightCorner<3, 3>() += turning_arm(arms.end, at_end.head<3>());
            if (on_ground) continue;
            const Vector6 at_base = rod.force.head<6>();
            residual_[j - 1] += carried(at_base, arms.base);
            system_.diagonal[j - 1].bottomRightCorner<3, 3>() += turning_arm(arms.base, at_base.head<3>());
        }
    }
    for (int j = 0; j < geometry.plates(); ++j) {
        Matrix6 derivative;
        residual_[j] -= plate_load(geometry, scene, plates[j], j, &derivative);
        system_.diagonal[j] -= derivative;
        if (symmetric) system_.diagonal[j] = 0.5 * (system_.diagonal[j] + system_.diagonal[j].transpose()).eval();
        full_residual_[j] = residual_[j];
        projector_[j].setIdentity();
        hold_map_[j].setZero();
    }
    apply_holds(scene, plates, symmetric);
    for (int j = 0; j < geometry.plates(); ++j) unshifted_[j] = system_.diagonal[j].diagonal();
}

void Balance::apply_holds(const Scene& scene, const std::vector<Pose>& plates, bool symmetric) {
    for (int j = 0; j < system_.rows(); ++j) {
        const Hold& hold = scene.holds[j];
        if (!hold.any()) continue;
        // Held rows C (dp, dtheta) = -gap. With Pi = 1 - C^+ C the balance is asked for along Pi only, and the held
        // directions get C^T (C x + gap) = 0 instead: both parts are independent, and nothing is special-cased.
        const Matrix6 rows = hold_rows(hold, plates[j]);
        const Vector6 gap = hold_gap(hold, plates[j]);
        Matrix6 c = Matrix6::Zero();
        Vector6 g = Vector6::Zero();
        for (int k = 0; k < 6; ++k)
            if (hold.held[k]) c.row(k) = rows.row(k), g(k) = gap(k);
        Matrix6 gram = c * c.transpose();
        for (int k = 0; k < 6; ++k)
            if (!hold.held[k]) gram(k, k) = 1.0;
        const Matrix6 pseudo = c.transpose() * gram.partialPivLu().inverse();
        Matrix6& projector = projector_[j];
        projector = Matrix6::Identity() - pseudo * c;
        if (hold.all()) projector.setZero();  // nothing is free: not even rounding noise
        if (hold.partly_turned()) {
            // The reaction C^T lambda turns with the plate where some rotations are free: its own stiffness, by central
            // differences (it does not enter the residual, so 1e-9 is plenty).
            const Vector6 reaction = pseudo.transpose() * full_residual_[j];
            for (int k = 0; k < 3; ++k) {
                constexpr double turn = 1e-5;
                Pose plus = plates[j], minus = plates[j];
                plus.rotation = exp_so3(turn * Vector3::Unit(k)) * plus.rotation;
                minus.rotation = exp_so3(-turn * Vector3::Unit(k)) * minus.rotation;
                const Matrix6 change = (hold_rows(hold, plus) - hold_rows(hold, minus)) / (2.0 * turn);
                Vector6 column = Vector6::Zero();
                for (int row = 0; row < 6; ++row)
                    if (hold.held[row]) column += change.row(row).transpose() * reaction(row);
                system_.diagonal[j].col(3 + k) -= column;
            }
        }
        // Any positive weight gives the same answer; the plate's own stiffness keeps the block well scaled.
        const double weight = std::max(system_.diagonal[j].diagonal().cwiseAbs().maxCoeff(), 1e-300);
        system_.diagonal[j] = (projector * system_.diagonal[j]).eval() + weight * pseudo * c;
        system_.upper[j] = (projector * system_.upper[j]).eval();
        system_.lower[j] = (projector * system_.lower[j]).eval();
        residual_[j] = (projector * residual_[j]).eval() + weight * pseudo * g;
        hold_map_[j] = weight * pseudo;
        if (!symmetric) continue;
        // On a shape that meets its holds the moves lie in the free directions: project the columns as well.
        system_.diagonal[j] = projector * system_.diagonal[j] * projector + weight * pseudo * c;
        if (j > 0) system_.upper[j - 1] = (system_.upper[j - 1] * projector).eval();
        if (j + 1 < system_.rows()) system_.lower[j + 1] = (system_.lower[j + 1] * projector).eval();
    }
}

void Balance::shift(int plate, const Vector6& by) { system_.diagonal[plate].diagonal() = unshifted_[plate] + by; }

void Balance::solve(const std::vector<Vector6>& rhs, std::vector<Vector6>& moves) const {
    for (int j = 0; j < system_.rows(); ++j) moves[j] = -rhs[j];
    system_.solve(moves);
}

}  // namespace softlimb::limb
