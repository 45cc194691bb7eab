#include "softlimb/sweep/atlas.hpp"

#include <Eigen/Cholesky>
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

/// What an atlas knows of a segment: poses of its plate and of the interior nodes of its rods, and wrenches at the
/// pieces' bases, in the frame that it stands on.
template <class Row>
void describe(const limb::Geometry& geometry, const limb::Shape& shape, int segment, int first_rod, Row&& values) {
    const Pose foot = geometry.footing(segment, shape.plates);
    const Matrix3 back = foot.rotation.transpose();
    Eigen::Index at = 0;
    const auto pose = [&](const Pose& p) {
        values.template segment<3>(at) = back * (p.position - foot.position);
        values.template segment<3>(at + 3) = back * p.rotation.col(0);
        values.template segment<3>(at + 6) = back * p.rotation.col(2);
        at += pose_numbers;
    };
    pose(shape.plates[segment]);
    for (std::size_t k = 0; k < geometry.segments[segment].rods.size(); ++k) {
        const limb::RodShape& rod = shape.rods[first_rod + k];
        for (int e = 1; e < rod.elements(); ++e) pose(rod.nodes[e]);
        for (const Vector6& wrench : rod.wrenches) {
            values.template segment<3>(at) = back * wrench.head<3>();
            values.template segment<3>(at + 3) = back * wrench.tail<3>();
            at += wrench_numbers;
        }
    }
}

/// Numbers of a segment's description.
std::size_t outputs_of(const limb::Mesh& mesh, int first_rod, int end_rod) {
    std::size_t count = pose_numbers;
    for (int i = first_rod; i < end_rod; ++i)
        count += static_cast<std::size_t>(mesh.elements[i]) * (pose_numbers + wrench_numbers) - pose_numbers;
    return count;
}

/// Terms of all variables up to a degree, and of the first `own` of them up to a degree of their own.
Atlas::Sheet terms_of(int variables, int own, int degree, int own_degree, const std::vector<bool>& varies) {
    Atlas::Sheet sheet;
    const std::function<void(int, int, int, bool)> add = [&](int term, int from, int used, bool beyond) {
        for (int v = from; v < variables; ++v) {
            const bool now = beyond || v >= own;
            if (!varies[v] || used >= (now ? degree : own_degree)) continue;
            sheet.earlier.push_back(term), sheet.variable.push_back(v);
            add(static_cast<int>(sheet.earlier.size()), v, used + 1, now);
        }
    };
    add(0, 0, 0, false);
    return sheet;
}

bool is_on(const limb::Mesh& mesh, const limb::Shape& shape) {
    for (std::size_t i = 0; i < shape.rods.size(); ++i)
        if (shape.rods[i].elements() != mesh.elements[i]) return false;
    return true;
}

/// Of the loads that do not turn with the limb, all together; where they cancel, of the first one.
std::vector<double> direction_of(const limb::Geometry& geometry, const limb::Scene& scene) {
    std::vector<Vector3> loads{Vector3::Zero()};
    const auto add = [&](const Vector3& load) { loads.front() += load, loads.push_back(load); };
    for (std::size_t i = 0; i < scene.rods.size(); ++i)
        add(scene.rods[i].rest_length * eigen(scene.line_load(static_cast<int>(i)).force));
    for (std::size_t j = 0; j < scene.wrenches.size(); ++j) {
        add(geometry.segments[j].plate_mass * scene.gravity);
        if (!scene.following) add(scene.wrenches[j].head<3>());
    }
    for (const Vector3& load : loads)
        if (load.norm() > 0.0) {
            const Vector3 unit = load.normalized();
            return {unit.x(), unit.y(), unit.z()};
        }
    return {};
}

}  // namespace

Atlas::Atlas(Content content) : content_(std::move(content)) {
    std::size_t at = 12 * content_.sheets.size();
    for (const int count : content_.mesh.elements) {
        rod_at_.push_back(at);
        at += 18 * static_cast<std::size_t>(count) - 12;
    }
    for (const Sheet& sheet : content_.sheets) {
        const std::size_t terms = sheet.terms(), outputs = sheet.coefficients.size() / terms;
        Panels panels;
        panels.count = (outputs + together - 1) / together;
        panels.numbers.assign(panels.count * terms * together, 0.0);
        for (std::size_t k = 0; k < terms; ++k)
            for (std::size_t i = 0; i < outputs; ++i)
                panels.numbers[(i / together * terms + k) * together + i % together] =
                    sheet.coefficients[k * outputs + i];
        panels_.push_back(std::move(panels));
    }
}

std::size_t Atlas::variables(std::size_t segment) const {
    const std::size_t rods = content_.middle.size() - content_.first_rod[segment];
    return rods + (segment > 0 ? content_.direction.size() : 0);
}

void Atlas::fill_variables(std::size_t segment, const std::vector<limb::RodAtPressure>& rods, const Matrix3* footing,
                           double* to) const {
    const auto lengths = [&](int from, int end) {
        for (int i = from; i < end; ++i, to += together)
            *to = content_.scale[i] > 0.0 ? (rods[i].rest_length - content_.middle[i]) / content_.scale[i] : 0.0;
    };
    lengths(content_.first_rod[segment], content_.first_rod[segment + 1]);
    if (segment > 0 && !content_.direction.empty())
        for (int c = 0; c < 3; ++c, to += together)
            *to = footing->col(c).dot(Eigen::Map<const Vector3>(content_.direction.data()));
    lengths(content_.first_rod[segment + 1], content_.first_rod.back());
}

void Atlas::fill_terms(const Sheet& sheet, const double* variables, double* terms) const {
    for (int i = 0; i < together; ++i) terms[i] = 1.0;
    for (std::size_t k = 0; k < sheet.earlier.size(); ++k) {
        const double *earlier = terms + together * sheet.earlier[k], *by = variables + together * sheet.variable[k];
        double* term = terms + together * (k + 1);
        for (int i = 0; i < together; ++i) term[i] = earlier[i] * by[i];
    }
}

std::optional<Atlas> Atlas::fitted(const limb::Geometry& geometry, const std::vector<Anchor>& anchors, double tolerance,
                                   const limb::Mesh* mesh) {
    if (anchors.empty()) return std::nullopt;
    // More terms than this cost more time than the better start saves.
    constexpr std::size_t most_terms = 360;
    const std::size_t most = std::min(most_terms, anchors.size() / 3), count = anchors.size();
    Content content;
    content.direction = direction_of(geometry, anchors.front().scene);
    content.first_rod.push_back(0);
    for (const limb::Segment& segment : geometry.segments)
        content.first_rod.push_back(content.first_rod.back() + static_cast<int>(segment.rods.size()));
    for (int i = 0; i < geometry.rods(); ++i) {
        double low = anchors.front().scene.rods[i].rest_length, high = low;
        for (const Anchor& anchor : anchors) {
            low = std::min(low, anchor.scene.rods[i].rest_length);
            high = std::max(high, anchor.scene.rods[i].rest_length);
        }
        content.middle.push_back(0.5 * (low + high)), content.scale.push_back(0.5 * (high - low));
    }
    content.mesh = mesh ? *mesh : mesh_of(anchors, tolerance);
    // Rods that need so many pieces, as those under strong tension, would make room for them in every lane.
    constexpr int most_elements = 12;
    if (*std::max_element(content.mesh.elements.begin(), content.mesh.elements.end()) > most_elements)
        return std::nullopt;
    const int segments = geometry.plates();
    for (int j = 0; j < segments; ++j) {
        std::vector<bool> varies;
        const auto lengths = [&](int from, int end) {
            for (int i = from; i < end; ++i) varies.push_back(content.scale[i] > 0.0);
        };
        lengths(content.first_rod[j], content.first_rod[j + 1]);
        if (j > 0) varies.insert(varies.end(), content.direction.size(), true);
        const int own = static_cast<int>(varies.size());
        lengths(content.first_rod[j + 1], content.first_rod.back());
        constexpr struct {
            int degree, own;
        } choices[] = {{3, 5}, {3, 4}, {3, 3}, {2, 4}, {2, 3}, {2, 2}, {1, 2}, {1, 1}};
        Sheet sheet;
        for (const auto [degree, own_degree] : choices) {
            sheet = terms_of(static_cast<int>(varies.size()), own, degree, own_degree, varies);
            if (sheet.terms() <= most) break;
        }
        if (sheet.terms() > most) return std::nullopt;
        content.sheets.push_back(std::move(sheet));
    }

    const Atlas terms_only(content);
    std::vector<limb::Shape> shapes;
    for (const Anchor& anchor : anchors)
        shapes.push_back(is_on(content.mesh, anchor.shape)
                             ? anchor.shape
                             : limb::on_mesh(geometry, anchor.scene, anchor.shape, content.mesh));
    std::vector<double> variables, terms;
    for (int j = 0; j < segments; ++j) {
        Sheet& sheet = content.sheets[j];
        const auto size = static_cast<Eigen::Index>(sheet.terms());
        const auto outputs =
            static_cast<Eigen::Index>(outputs_of(content.mesh, content.first_rod[j], content.first_rod[j + 1]));
        Eigen::MatrixXd at(size, count), values(outputs, count);
        variables.resize(together * terms_only.variables(j)), terms.resize(together * sheet.terms());
        for (std::size_t k = 0; k < count; ++k) {
            const limb::Shape& shape = shapes[k];
            const Matrix3* footing = j > 0 ? &shape.plates[j - 1].rotation : nullptr;
            terms_only.fill_variables(j, anchors[k].scene.rods, footing, variables.data());
            terms_only.fill_terms(sheet, variables.data(), terms.data());
            for (Eigen::Index term = 0; term < size; ++term) at(term, k) = terms[together * term];
            describe(geometry, shape, j, content.first_rod[j], values.col(static_cast<Eigen::Index>(k)));
        }
        // Least squares by the normal equations, with a pull to zero too small to be seen in a start: terms may be
        // nearly alike, as those of a direction's three components are.
        Eigen::MatrixXd normal = at * at.transpose();
        normal.diagonal().array() += 1e-9 * static_cast<double>(count);
        const Eigen::MatrixXd right = at * values.transpose();
        const Eigen::MatrixXd found = normal.llt().solve(right);
        if (!found.allFinite()) return std::nullopt;
        sheet.coefficients.resize(static_cast<std::size_t>(size * outputs));
        using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
        Eigen::Map<Rows>(sheet.coefficients.data(), size, outputs) = found;
    }
    return Atlas(std::move(content));
}

void Atlas::starts(const limb::Geometry& geometry, const std::vector<limb::RodAtPressure>* const* rods, int count,
                   Room& room) const {
    for (int i = 0; i < count; ++i) room.numbers[i].resize(limb::numbers_of(geometry, mesh()));
    for (std::size_t j = 0; j < content_.sheets.size(); ++j) {
        const Sheet& sheet = content_.sheets[j];
        const std::size_t padded = panels_[j].count * together;
        room.variables.resize(together * variables(j)), room.terms.resize(together * sheet.terms());
        room.outputs.resize(together * padded);
        for (int i = 0; i < together; ++i) {
            const int limb = std::min(i, count - 1);
            Matrix3 footing;
            if (j > 0) footing = Eigen::Map<const Matrix3>(room.numbers[limb].data() + 12 * (j - 1) + 3);
            fill_variables(j, *rods[limb], &footing, room.variables.data() + i);
        }
        fill_terms(sheet, room.variables.data(), room.terms.data());
        rod::lanes::kernel().combine(panels_[j].numbers.data(), static_cast<int>(sheet.terms()),
                                     static_cast<int>(panels_[j].count), room.terms.data(), room.outputs.data());
        for (int i = 0; i < count; ++i)
            decode(geometry, static_cast<int>(j), room.outputs.data() + padded * i, room.numbers[i].data());
    }
}

void Atlas::decode(const limb::Geometry& geometry, int segment, const double* from, double* numbers) const {
    Pose foot;
    if (segment > 0) {
        const double* before = numbers + 12 * (segment - 1);
        foot = geometry.distal_face(segment - 1,
                                    {Eigen::Map<const Vector3>(before), Eigen::Map<const Matrix3>(before + 3)});
    }
    const auto pose = [&](double*& to) {
        const Matrix3 rotation =
            rotation_along(Eigen::Map<const Vector3>(from + 3), Eigen::Map<const Vector3>(from + 6));
        const Pose found = foot * Pose{Eigen::Map<const Vector3>(from), rotation};
        from += pose_numbers;
        Eigen::Map<Vector3>{to} = found.position;
        Eigen::Map<Matrix3>{to + 3} = found.rotation;
        to += 12;
    };
    double* plate = numbers + 12 * segment;
    pose(plate);
    for (int i = content_.first_rod[segment]; i < content_.first_rod[segment + 1]; ++i) {
        double* to = numbers + rod_at_[i];
        for (int e = 1; e < mesh().elements[i]; ++e) pose(to);
        for (int e = 0; e < mesh().elements[i]; ++e) {
            Eigen::Map<Vector3>{to} = foot.rotation * Eigen::Map<const Vector3>(from);
            Eigen::Map<Vector3>{to + 3} = foot.rotation * Eigen::Map<const Vector3>(from + 3);
            to += wrench_numbers, from += wrench_numbers;
        }
    }
}

}  // namespace softlimb::sweep
