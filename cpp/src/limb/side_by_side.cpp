#include "softlimb/limb/side_by_side.hpp"

#include <algorithm>
#include <new>

#include "softlimb/limb/equilibrium.hpp"

namespace softlimb::limb {
namespace {

constexpr std::align_val_t alignment{64};

void write_pose(const Pose& pose, double* to) {
    std::copy_n(pose.position.data(), 3, to);
    std::copy_n(pose.rotation.data(), 9, to + 3);
}

Pose read_pose(const double* from) { return {Eigen::Map<const Vector3>(from), Eigen::Map<const Matrix3>(from + 3)}; }

}  // namespace

Shape on_mesh(const Geometry& geometry, const Scene& scene, const Shape& shape, const Mesh& mesh) {
    Shape to;
    to.plates = shape.plates;
    to.rods.resize(shape.rods.size());
    for (std::size_t i = 0; i < shape.rods.size(); ++i) {
        const RodShape& from = shape.rods[i];
        const rod::RodPiece piece{&scene.rods[i].section, scene.rods[i].rest_length / from.elements(),
                                  scene.line_load(static_cast<int>(i))};
        RodShape& rod = to.rods[i];
        const int elements = mesh.elements[i];
        rod.nodes.resize(elements + 1), rod.wrenches.resize(elements);
        rod.integration = {8, 2 * mesh.steps[i]};
        for (int e = 0; e < elements; ++e) {
            const int behind = e * from.elements() / elements;
            const double fraction = static_cast<double>(e) * from.elements() / elements - behind;
            rod::EndState state;
            rod::states_along(piece, from.nodes[behind], from.wrenches[behind], from.integration, &fraction, 1, &state);
            rod.nodes[e] = state.pose, rod.wrenches[e] = state.wrench;
        }
    }
    attach_rods(geometry, to);
    return to;
}

std::size_t numbers_of(const Geometry& geometry, const Mesh& mesh) {
    std::size_t numbers = 12 * static_cast<std::size_t>(geometry.plates());
    for (const int elements : mesh.elements) numbers += 18 * static_cast<std::size_t>(elements) - 12;
    return numbers;
}

void numbers_to_plates(const Geometry& geometry, const double* numbers, std::vector<Pose>& plates) {
    plates.resize(geometry.plates());
    for (Pose& plate : plates) plate = read_pose(numbers), numbers += 12;
}

void numbers_to_shape(const Geometry& geometry, const Mesh& mesh, const double* numbers, Shape& shape) {
    const std::size_t rods = mesh.elements.size();
    numbers_to_plates(geometry, numbers, shape.plates);
    numbers += 12 * geometry.plates();
    shape.rods.resize(rods);
    for (std::size_t i = 0; i < rods; ++i) {
        RodShape& rod = shape.rods[i];
        const int elements = mesh.elements[i];
        rod.nodes.resize(elements + 1), rod.wrenches.resize(elements);
        rod.integration = {8, 2 * mesh.steps[i]};  // the answer is that of half the linearisation's step
        for (int e = 1; e < elements; ++e) rod.nodes[e] = read_pose(numbers), numbers += 12;
        for (Vector6& wrench : rod.wrenches) wrench = Eigen::Map<const Vector6>(numbers), numbers += 6;
    }
    attach_rods(geometry, shape);
}

void shape_to_numbers(const Shape& shape, std::vector<double>& numbers) {
    numbers.clear();
    const auto pose = [&](const Pose& p) {
        numbers.resize(numbers.size() + 12);
        write_pose(p, numbers.data() + numbers.size() - 12);
    };
    for (const Pose& plate : shape.plates) pose(plate);
    for (const RodShape& rod : shape.rods) {
        for (int e = 1; e < rod.elements(); ++e) pose(rod.nodes[e]);
        for (const Vector6& wrench : rod.wrenches) numbers.insert(numbers.end(), wrench.data(), wrench.data() + 6);
    }
}

void make_orthonormal(const Geometry& geometry, const Mesh& mesh, double* numbers) {
    const auto pose = [&] {
        Eigen::Map<Matrix3> rotation(numbers + 3);
        rotation = rotation_along(rotation.col(0), rotation.col(2));
        numbers += 12;
    };
    for (int j = 0; j < geometry.plates(); ++j) pose();
    for (const int elements : mesh.elements) {
        for (int e = 1; e < elements; ++e) pose();
        numbers += 6 * elements;
    }
}

void SideBySide::Free::operator()(void* room) const { ::operator delete(room, alignment); }

SideBySide::SideBySide(const Geometry& geometry, const Scene& scene, const Mesh& mesh, double tolerance,
                       int corrections)
    : geometry_(geometry), kernel_(rod::lanes::kernel()) {
    using rod::lanes::Loads;
    plan_.length = geometry.length, plan_.tolerance = tolerance, plan_.following = scene.following;
    plan_.corrections = corrections;
    std::size_t number = 0;
    bool moments = false, forces = !scene.gravity.isZero(0.0);
    for (int j = 0; j < geometry.plates(); ++j) {
        const Segment& segment = geometry.segments[j];
        rod::lanes::LimbPlate plate{};
        std::copy_n(scene.wrenches[j].data(), 6, plate.wrench);
        const Vector3 weight = segment.plate_mass * scene.gravity;
        std::copy_n(weight.data(), 3, plate.weight);
        plate.weight_arm = 0.5 * segment.plate_thickness;
        plates_.push_back(plate);
        for (const Placement& place : segment.rods) {
            rod::lanes::LimbRod rod;
            rod.plate = j, rod.elements = mesh.elements[number], rod.steps = mesh.steps[number];
            Pose base = place.base;
            if (j > 0) base.position += geometry.segments[j - 1].plate_thickness * Vector3::UnitZ();
            write_pose(base, rod.base), write_pose(place.end, rod.end);
            rods_.push_back(rod);
            const rod::LineLoad<double>& load = scene.rods[number++].line_load;
            forces = forces || !is_zero(load.force), moments = moments || !is_zero(load.moment);
        }
    }
    plan_.loads = moments ? Loads::any : forces ? Loads::force : Loads::none;
    plan_.rod = rods_.data(), plan_.rods = static_cast<int>(rods_.size());
    plan_.plate = plates_.data(), plan_.plates = geometry.plates();
    room_.reset(::operator new(kernel_.limbs.bytes(plan_), alignment));
    kernel_.limbs.open(plan_, room_.get());
    sections_.resize(rods_.size()), lengths_.resize(rods_.size()), loads_.resize(6 * rods_.size());
}

void SideBySide::fill(int lane, const Scene& scene, const double* start, const rod::lanes::LaneReport* so_far) {
    for (std::size_t i = 0; i < rods_.size(); ++i) {
        sections_[i] = &scene.rods[i].section, lengths_[i] = scene.rods[i].rest_length;
        const auto [force, moment] = scene.line_load(static_cast<int>(i));
        const double load[6] = {force.x, force.y, force.z, moment.x, moment.y, moment.z};
        std::copy_n(load, 6, loads_.data() + 6 * i);
    }
    rod::lanes::LimbStart limb{sections_.data(), lengths_.data(), loads_.data(), start,
                               neutral_margin(geometry_, scene)};
    if (so_far) limb.iterations = so_far->iterations, limb.asked_again = so_far->asked_again;
    kernel_.limbs.fill(plan_, room_.get(), lane, limb);
}

}  // namespace softlimb::limb
