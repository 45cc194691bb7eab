#include "softlimb/sweep/atlas.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <functional>

#include "softlimb/limb/equilibrium.hpp"

namespace softlimb::sweep {
namespace {

constexpr std::size_t pose_numbers = 9, wrench_numbers = 6;  // position, director and tangent; force and moment

/// Pieces and steps that serve nine anchors of ten, rod by rod: a finer mesh costs every row more than it saves those
/// few, which are solved by themselves where it does not serve.
limb::Mesh mesh_of(const std::vector<Anchor>& anchors, double tolerance) {
    constexpr double served = 0.9;
    // Steps of the linearisation. The answer is that of half the step, which errs 256 times less; so these may err by a
    // dozen times the tolerance.
    const double step = 1.35 * limb::allowed_step(tolerance);
    limb::Mesh mesh;
    std::vector<double> activities(anchors.size());
    for (std::size_t i = 0; i < anchors.front().shape.rods.size(); ++i) {
        for (std::size_t k = 0; k < anchors.size(); ++k)
            activities[k] = limb::rod_activity(anchors[k].scene, anchors[k].shape, i);
        const auto at = activities.begin() + static_cast<std::ptrdiff_t>(served * static_cast<double>(anchors.size()));
        std::nth_element(activities.begin(), at, activities.end());
        const double whole = *at;
        mesh.elements.push_back(std::max(1, static_cast<int>(std::ceil(whole / std::min(step, limb::warm_piece)))));
        mesh.steps.push_back(1);
    }
    return mesh;
}

/// What an atlas knows of a shape: poses of plates and interior nodes of its mesh, and wrenches at the pieces' bases,
/// in the frames that the segments stand on.
Eigen::RowVectorXd described(const limb::Geometry& geometry, const Anchor& anchor, const limb::Mesh& mesh,
                             std::size_t outputs) {
    Eigen::RowVectorXd values(static_cast<Eigen::Index>(outputs));
    Eigen::Index at = 0;
    const auto pose = [&](const Pose& foot, const Pose& p) {
        const Matrix3 back = foot.rotation.transpose();
        values.segment<3>(at) = (back * (p.position - foot.position)).transpose();
        values.segment<3>(at + 3) = (back * p.rotation.col(0)).transpose();
        values.segment<3>(at + 6) = (back * p.rotation.col(2)).transpose();
        at += pose_numbers;
    };
    const limb::Shape shape = limb::on_mesh(geometry, anchor.scene, anchor.shape, mesh);
    for (int j = 0; j < geometry.plates(); ++j) pose(geometry.footing(j, shape.plates), shape.plates[j]);
    std::size_t i = 0;
    for (int j = 0; j < geometry.plates(); ++j) {
        const Pose foot = geometry.footing(j, shape.plates);
        for (std::size_t k = 0; k < geometry.segments[j].rods.size(); ++k, ++i) {
            const limb::RodShape& rod = shape.rods[i];
            for (int e = 1; e < rod.elements(); ++e) pose(foot, rod.nodes[e]);
            for (const Vector6& wrench : rod.wrenches) {
                values.segment<3>(at) = (foot.rotation.transpose() * wrench.head<3>()).transpose();
                values.segment<3>(at + 3) = (foot.rotation.transpose() * wrench.tail<3>()).transpose();
                at += wrench_numbers;
            }
        }
    }
    return values;
}

std::size_t outputs_of(const limb::Mesh& mesh, std::size_t plates) {
    std::size_t count = plates * pose_numbers;
    for (const int elements : mesh.elements)
        count += static_cast<std::size_t>(elements) * (pose_numbers + wrench_numbers) - pose_numbers;
    return count;
}

/// Powers of the rods in every term up to a degree, and of those within one segment up to a degree of their own.
std::vector<int> terms_of(const std::vector<double>& scale, const std::vector<int>& segment, int degree, int own) {
    const int rods = static_cast<int>(scale.size());
    constexpr int none = -1, several = -2;
    std::vector<int> terms, power(rods, 0);
    const std::function<void(int, int, int)> add = [&](int from, int used, int within) {
        terms.insert(terms.end(), power.begin(), power.end());
        for (int i = from; i < rods; ++i) {
            const int now = within == none || within == segment[i] ? segment[i] : several;
            if (scale[i] == 0.0 || used >= (now == several ? degree : own)) continue;
            ++power[i];
            add(i, used + 1, now);
            --power[i];
        }
    };
    add(0, 0, none);
    return terms;
}

}  // namespace

Atlas::Atlas(Content content) : content_(std::move(content)) {
    const std::size_t rods = content_.middle.size();
    terms_ = content_.powers.size() / rods;
    outputs_ = content_.coefficients.size() / terms_;
    degree_.assign(rods, 0);
    for (std::size_t k = 0; k < content_.powers.size(); ++k)
        degree_[k % rods] = std::max(degree_[k % rods], content_.powers[k]);
    panel_count_ = (outputs_ + together - 1) / together;
    panels_.assign(panel_count_ * terms_ * together, 0.0);
    for (std::size_t k = 0; k < terms_; ++k)
        for (std::size_t i = 0; i < outputs_; ++i)
            panels_[(i / together * terms_ + k) * together + i % together] = content_.coefficients[k * outputs_ + i];
}

std::optional<Atlas> Atlas::fitted(const limb::Geometry& geometry, const std::vector<Anchor>& anchors,
                                   double tolerance) {
    if (anchors.empty()) return std::nullopt;
    // More terms than this cost more time than the better start saves.
    constexpr std::size_t most_terms = 128;
    const std::size_t most = std::min(most_terms, anchors.size() / 2), rods = geometry.rods();
    Content content;
    std::vector<int> segment;
    for (int j = 0; j < geometry.plates(); ++j) segment.insert(segment.end(), geometry.segments[j].rods.size(), j);
    for (std::size_t i = 0; i < rods; ++i) {
        double low = anchors.front().scene.rods[i].rest_length, high = low;
        for (const Anchor& anchor : anchors) {
            low = std::min(low, anchor.scene.rods[i].rest_length);
            high = std::max(high, anchor.scene.rods[i].rest_length);
        }
        content.middle.push_back(0.5 * (low + high)), content.scale.push_back(0.5 * (high - low));
    }
    constexpr struct {
        int degree, own;
    } choices[] = {{3, 4}, {3, 3}, {2, 3}, {2, 2}, {1, 2}, {1, 1}};
    for (const auto [degree, own] : choices) {
        content.powers = terms_of(content.scale, segment, degree, own);
        if (content.powers.size() <= most * rods) break;
        content.powers.clear();
    }
    if (content.powers.empty()) return std::nullopt;
    content.mesh = mesh_of(anchors, tolerance);
    // Rods that need so many pieces, as those under strong tension, would make room for them in every lane.
    constexpr int most_elements = 12;
    if (*std::max_element(content.mesh.elements.begin(), content.mesh.elements.end()) > most_elements)
        return std::nullopt;
    const std::size_t outputs = outputs_of(content.mesh, geometry.segments.size());
    const std::size_t terms = content.powers.size() / rods;
    content.coefficients.resize(terms * outputs);
    Atlas atlas(std::move(content));

    Eigen::MatrixXd at(anchors.size(), terms), values(anchors.size(), outputs);
    Room room;
    room.terms.resize(together * terms);
    for (std::size_t k = 0; k < anchors.size(); ++k) {
        atlas.fill_terms(anchors[k].scene.rods, room, room.terms.data());
        for (std::size_t term = 0; term < terms; ++term) at(k, term) = room.terms[together * term];
        values.row(k) = described(geometry, anchors[k], atlas.mesh(), outputs);
    }
    using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
    Content fitted = atlas.content();
    Eigen::Map<Rows>(fitted.coefficients.data(), terms, outputs) = at.colPivHouseholderQr().solve(values);
    return Atlas(std::move(fitted));
}

void Atlas::fill_terms(const std::vector<limb::RodAtPressure>& rods, Room& room, double* terms) const {
    constexpr std::size_t most_powers = 8;
    room.powers.resize(rods.size() * most_powers);
    for (std::size_t i = 0; i < rods.size(); ++i) {
        const double x = content_.scale[i] > 0.0 ? (rods[i].rest_length - content_.middle[i]) / content_.scale[i] : 0.0;
        double* power = room.powers.data() + most_powers * i;
        power[0] = 1.0;
        for (int d = 1; d <= degree_[i]; ++d) power[d] = x * power[d - 1];
    }
    const int* power = content_.powers.data();
    for (std::size_t k = 0; k < terms_; ++k) {
        double term = 1.0;
        for (std::size_t i = 0; i < rods.size(); ++i, ++power)
            if (*power > 0) term *= room.powers[most_powers * i + *power];
        terms[together * k] = term;
    }
}

void Atlas::starts(const limb::Geometry& geometry, const std::vector<limb::RodAtPressure>* const* rods, int count,
                   Room& room) const {
    const std::size_t padded = panel_count_ * together;
    room.terms.resize(together * terms_), room.outputs.resize(together * padded);
    for (int i = 0; i < together; ++i) fill_terms(*rods[std::min(i, count - 1)], room, room.terms.data() + i);
    rod::lanes::kernel().combine(panels_.data(), static_cast<int>(terms_), static_cast<int>(panel_count_),
                                 room.terms.data(), room.outputs.data());
    for (int i = 0; i < count; ++i) {
        room.numbers[i].resize(limb::numbers_of(geometry, mesh()));
        decode(geometry, room.outputs.data() + padded * i, room, room.numbers[i].data());
    }
}

void Atlas::decode(const limb::Geometry& geometry, const double* from, Room& room, double* numbers) const {
    const auto pose = [&](const Pose& foot) {
        const Vector3 tangent = Eigen::Map<const Vector3>(from + 6).normalized();
        const Vector3 director = Eigen::Map<const Vector3>(from + 3);
        const Vector3 across = (director - director.dot(tangent) * tangent).normalized();
        Matrix3 rotation;
        rotation << across, tangent.cross(across), tangent;
        const Pose found = foot * Pose{Eigen::Map<const Vector3>(from), rotation};
        from += pose_numbers;
        Eigen::Map<Vector3>{numbers} = found.position;
        Eigen::Map<Matrix3>{numbers + 3} = found.rotation;
        numbers += 12;
        return found;
    };
    room.plates.resize(geometry.plates());
    for (int j = 0; j < geometry.plates(); ++j) room.plates[j] = pose(geometry.footing(j, room.plates));
    std::size_t i = 0;
    for (int j = 0; j < geometry.plates(); ++j) {
        const Pose foot = geometry.footing(j, room.plates);
        for (std::size_t k = 0; k < geometry.segments[j].rods.size(); ++k, ++i) {
            for (int e = 1; e < mesh().elements[i]; ++e) pose(foot);
            for (int e = 0; e < mesh().elements[i]; ++e) {
                Eigen::Map<Vector3>{numbers} = foot.rotation * Eigen::Map<const Vector3>(from);
                Eigen::Map<Vector3>{numbers + 3} = foot.rotation * Eigen::Map<const Vector3>(from + 3);
                numbers += wrench_numbers, from += wrench_numbers;
            }
        }
    }
}

}  // namespace softlimb::sweep
