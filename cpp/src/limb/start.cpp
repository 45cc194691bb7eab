#include "softlimb/limb/start.hpp"

#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>

namespace softlimb::limb {
namespace {

/// Pose of a segment's plate over its footing, unloaded: rods of length l_i at (x_i, y_i) bend to the curvature that
/// fits l_i = length (1 + kappa_y-part x_i - kappa_x-part y_i) best; placements that are no ring fall back on the mean
/// of where each rod alone would put the plate.
Pose bent_segment(const Segment& segment, const RodAtPressure* rods) {
    const int count = static_cast<int>(segment.rods.size());
    // Rest lengths l fitted by a + b x + c y, each rod as stiff against the rest as EA/l is; bending stiffness of the
    // rods holds the slopes down, and keeps one or two rods, or points in a line, regular.
    Matrix3 normal = Matrix3::Zero();
    Vector3 right = Vector3::Zero();
    double mean = 0.0;
    for (int i = 0; i < count; ++i) mean += rods[i].rest_length / count;
    for (int i = 0; i < count; ++i) {
        const Vector3& at = segment.rods[i].base.position;
        const Section section = softened(rods[i]);
        const Vector3 row(1.0, at.x(), at.y());
        normal += section.axial * row * row.transpose();
        normal.diagonal().tail<2>().array() += section.bending;
        right += section.axial * row * (rods[i].rest_length - mean);
    }
    const Vector3 fit = normal.partialPivLu().solve(right);
    // A longer rod at +x bends the segment towards -x: rotation about -y by the length slope.
    Vector3 turn(fit.z(), -fit.y(), 0.0);
    const double largest = 2.5;  // rad: a start, not an answer; beyond it the arc folds back on the base
    if (turn.norm() > largest) turn *= largest / turn.norm();

    // Twists of the rods' ends against their own base, averaged with the bend.
    Vector3 position = Vector3::Zero();
    Matrix3 rotation = Matrix3::Zero();
    for (int i = 0; i < count; ++i) {
        Vector6 xi;
        xi << 0.0, 0.0, rods[i].rest_length, segment.rods[i].base.rotation.transpose() * turn;
        xi(5) += rods[i].section.rest_twist * rods[i].rest_length / count;
        const Pose plate = segment.rods[i].base * exp_se3(xi) * segment.rods[i].end.inverse();
        position += plate.position / count;
        rotation += plate.rotation;
    }
    const Eigen::JacobiSVD<Matrix3> svd(rotation, Eigen::ComputeFullU | Eigen::ComputeFullV);
    Matrix3 nearest = svd.matrixU() * svd.matrixV().transpose();
    if (nearest.determinant() < 0.0)
        nearest = svd.matrixU() * Vector3(1, 1, -1).asDiagonal() * svd.matrixV().transpose();
    return {position, nearest};
}

}  // namespace

void meet_hold(const Hold& hold, Pose& plate) {
    if (!hold.any()) return;
    for (int k = 0; k < 3; ++k)
        if (hold.held[k]) plate.position(k) = hold.pose.position(k);
    if (hold.held[3] || hold.held[4] || hold.held[5]) {
        Vector3 turn = log_so3(plate.rotation * hold.pose.rotation.transpose());
        for (int k = 0; k < 3; ++k)
            if (hold.held[3 + k]) turn(k) = 0.0;
        plate.rotation = exp_so3(turn) * hold.pose.rotation;
    }
}

std::vector<Pose> constant_curvature_plates(const Geometry& geometry, const Scene& scene) {
    std::vector<Pose> plates(geometry.plates());
    int first = 0;
    for (int j = 0; j < geometry.plates(); ++j) {
        plates[j] = geometry.footing(j, plates) * bent_segment(geometry.segments[j], scene.rods.data() + first);
        meet_hold(scene.holds[j], plates[j]);
        first += static_cast<int>(geometry.segments[j].rods.size());
    }
    return plates;
}

Shape geodesic_shape(const Geometry& geometry, const Scene& scene, const std::vector<Pose>& plates, int elements) {
    Shape shape;
    shape.plates = plates;
    shape.rods.resize(scene.rods.size());
    for (RodShape& rod : shape.rods) {
        rod.nodes.resize(2);
        rod.wrenches.assign(1, Vector6::Zero());
    }
    attach_rods(geometry, shape);
    for (RodShape& rod : shape.rods) split_elements(rod, elements);
    return shape;
}

Section softened(const RodAtPressure& rod) {
    Section section = rod.section;
    const double stiffest = 1e5 * section.bending / (rod.rest_length * rod.rest_length);
    section.axial = std::min(section.axial, stiffest);
    section.shear = std::min(section.shear, stiffest);
    return section;
}

Section softened(const RodAtPressure& rod, int elements) {
    Section section = softened(rod);
    const double h = rod.rest_length / elements;
    section.shear = 1.0 / (1.0 / section.shear + h * h / (12.0 * section.bending));
    return section;
}

void set_geodesic_wrenches(const Scene& scene, Shape& shape, Stiffness stiffness) {
    for (std::size_t i = 0; i < shape.rods.size(); ++i) {
        RodShape& rod = shape.rods[i];
        const Section section =
            stiffness == Stiffness::softened ? softened(scene.rods[i], rod.elements()) : scene.rods[i].section;
        const rod::RodPiece piece{&section, scene.rods[i].rest_length / rod.elements(),
                                  scene.line_load(static_cast<int>(i))};
        for (int e = 0; e < rod.elements(); ++e)
            rod.wrenches[e] = rod::geodesic_base_wrench(piece, rod.nodes[e], rod.nodes[e + 1]);
    }
}

Shape start_from_plates(const Geometry& geometry, const Scene& scene, const std::vector<Pose>& plates) {
    constexpr int elements = 4;  // enough for Newton's basin where the plates are near the answer
    std::vector<Pose> held = plates;
    for (int j = 0; j < geometry.plates(); ++j) meet_hold(scene.holds[j], held[j]);
    Shape shape = geodesic_shape(geometry, scene, held, elements);
    set_geodesic_wrenches(scene, shape, Stiffness::exact);
    return shape;
}

void split_elements(RodShape& rod, int parts) {
    if (parts <= 1) return;
    std::vector<Pose> nodes;
    std::vector<Vector6> wrenches;
    for (int e = 0; e < rod.elements(); ++e) {
        const Vector6 xi = log_se3(rod.nodes[e].inverse() * rod.nodes[e + 1]);
        for (int k = 0; k < parts; ++k) {
            nodes.push_back(rod.nodes[e] * exp_se3(xi * (static_cast<double>(k) / parts)));
            wrenches.push_back(rod.wrenches[e]);
            // The same force, and its moment about the new node; a weight in between is left out.
            const Vector3 arm = nodes.back().position - rod.nodes[e].position;
            wrenches.back().tail<3>() -= arm.cross(Vector3(rod.wrenches[e].head<3>()));
        }
    }
    nodes.push_back(rod.nodes.back());
    rod.nodes = std::move(nodes);
    rod.wrenches = std::move(wrenches);
}

void merge_elements(RodShape& rod, int wanted) {
    int group = rod.elements() / std::max(1, wanted);
    while (group > 1 && rod.elements() % group != 0) --group;
    if (group <= 1) return;
    const int left = rod.elements() / group;
    for (int e = 1; e < left; ++e) rod.nodes[e] = rod.nodes[e * group], rod.wrenches[e] = rod.wrenches[e * group];
    rod.nodes[left] = rod.nodes.back();
    rod.nodes.resize(left + 1), rod.wrenches.resize(left);
}

}  // namespace softlimb::limb
