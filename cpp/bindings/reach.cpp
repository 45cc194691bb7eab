#include "softlimb/limb/reach.hpp"

#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include <optional>

#include "arrays.hpp"
#include "bindings.hpp"
#include "named.hpp"
#include "plain.hpp"
#include "softlimb/limb/posture.hpp"
#include "softlimb/sweep/actuation.hpp"

namespace py = pybind11;

namespace softlimb::bindings {
namespace {

using limb::Posture;

/// What a search found, its posture as every other one, and what it was asked for.
struct Reached {
    std::shared_ptr<Posture> posture;
    limb::ReachSolution found;  // without posture and scene
    limb::ReachTarget target;
    Eigen::VectorXd lower, upper;
};

std::shared_ptr<Reached> search(const std::shared_ptr<limb::Geometry>& geometry, const sweep::Members& members,
                                const limb::Scene& scene, const limb::ReachTarget& target,
                                limb::ReachSettings& settings, actuator::SectionModel model, actuator::Valve valve,
                                const limb::ReachStart* start) {
    settings.interrupted = [] {
        py::gil_scoped_acquire locked;
        return PyErr_CheckSignals() != 0;
    };
    const limb::Actuation actuation = sweep::actuation_of(members, model, valve);
    auto reached = std::make_shared<Reached>();
    try {
        py::gil_scoped_release unlocked;
        reached->found = limb::reach(*geometry, scene, actuation, target, settings, start);
    } catch (const solve::Interrupted&) {
        throw py::error_already_set();
    }
    limb::ReachSolution& found = reached->found;
    reached->posture = std::make_shared<Posture>(
        Posture{geometry, std::move(found.scene), std::move(found.posture),
                std::vector<double>(found.pressures.data(), found.pressures.data() + found.pressures.size())});
    reached->target = target;
    reached->lower = settings.lower, reached->upper = settings.upper;
    return reached;
}

Eigen::VectorXd one_each(const Array& values, const sweep::Members& members, const char* name) {
    if (values.ndim() != 1 || values.size() != members.actuators())
        throw std::invalid_argument(std::string(name) + " must have one number an actuator");
    return Eigen::Map<const Eigen::VectorXd>(values.data(), values.size());
}

std::shared_ptr<Reached> reach(const std::shared_ptr<limb::Geometry>& geometry,
                               const std::shared_ptr<sweep::Members>& members, const limb::Scene& scene,
                               const Array& target, const Array& weights, const Array& lower, const Array& upper,
                               const Array& preferred, double tolerance, const std::string& section,
                               const std::string& valve, const std::optional<std::shared_ptr<Posture>>& start,
                               const std::optional<Array>& start_pressures,
                               const std::optional<std::shared_ptr<Reached>>& learned, int starts) {
    if (target.size() != 16 || weights.size() != 6) throw std::invalid_argument("a target is a pose and six weights");
    limb::ReachTarget goal;
    goal.pose = pose_at(target, 0);
    goal.weights = Eigen::Map<const Vector6>(weights.data());
    limb::ReachSettings settings;
    settings.lower = one_each(lower, *members, "lower"), settings.upper = one_each(upper, *members, "upper");
    settings.preferred = one_each(preferred, *members, "preferred");
    settings.tolerance = tolerance;
    settings.starts = starts;
    std::optional<limb::ReachStart> from;
    if (start && start_pressures) {
        from.emplace(limb::ReachStart{&(*start)->solution.shape, one_each(*start_pressures, *members, "start"),
                                      learned ? &(*learned)->found.memory : nullptr});
    }
    return search(geometry, *members, scene, goal, settings, section_model(section), valve_of(valve),
                  from ? &*from : nullptr);
}

/// The same from plain numbers: a position (3,) or a pose (4, 4), one pressure from zero for all actuators, the least
/// effort, a posture or an answer of this limb. None where something is not plain or not right.
std::optional<std::shared_ptr<Reached>> plain_reach(const std::shared_ptr<limb::Geometry>& geometry,
                                                    const std::shared_ptr<sweep::Members>& members,
                                                    const limb::Scene& scene, const py::object& position,
                                                    const py::object& pose, const py::object& max_pressure,
                                                    const py::object& tolerance, const py::object& section,
                                                    const py::object& valve, const py::object& start) {
    const plain::Reader& read = plain::reader();
    limb::ReachTarget target;
    limb::ReachSettings settings;
    actuator::SectionModel model;
    actuator::Valve opening;
    double highest;
    if (position.is_none() ? !read.pose(pose, target.pose) : !pose.is_none()) return std::nullopt;
    if (!position.is_none()) {
        if (!read.three(position, target.pose.position.data())) return std::nullopt;
        target.weights.tail<3>().setZero();
    }
    if (!read.tolerance(tolerance, settings.tolerance) || settings.tolerance < 1e-9 ||
        !read.one(max_pressure, highest) || highest < 0.0 ||
        !read.choice(section, {"tangent", "nonlinear", "paper"}, model) ||
        !read.choice(valve, {"open", "locked"}, opening) || members->actuators() == 0)
        return std::nullopt;
    for (const sweep::Member& member : members->all())
        if (member.tube && member.tube->has_limit() && member.tube->limit_pressure() <= highest) return std::nullopt;
    settings.lower = settings.preferred = Eigen::VectorXd::Zero(members->actuators());
    settings.upper = Eigen::VectorXd::Constant(members->actuators(), highest);

    std::optional<limb::ReachStart> from;
    std::shared_ptr<Reached> before;
    if (!start.is_none()) {
        std::shared_ptr<Posture> posture;
        if (py::isinstance<Reached>(start))
            before = start.cast<std::shared_ptr<Reached>>(), posture = before->posture;
        else if (py::isinstance<Posture>(start))
            posture = start.cast<std::shared_ptr<Posture>>();
        if (!posture || static_cast<int>(posture->pressures.size()) != members->actuators() ||
            static_cast<int>(posture->solution.shape.rods.size()) != members->rods() ||
            static_cast<int>(posture->solution.shape.plates.size()) != geometry->plates())
            return std::nullopt;
        from.emplace(
            limb::ReachStart{&posture->solution.shape,
                             Eigen::Map<const Eigen::VectorXd>(posture->pressures.data(), members->actuators()),
                             before ? &before->found.memory : nullptr});
    }
    return search(geometry, *members, scene, target, settings, model, opening, from ? &*from : nullptr);
}

}  // namespace

void bind_reach(py::module_& m) {
    py::class_<Reached, std::shared_ptr<Reached>>(m, "Reached", "Pressures for a target, and their posture.")
        .def_property_readonly("posture", [](const Reached& r) { return r.posture; })
        .def_property_readonly(
            "gap", [](const Reached& r) { return vector_array(r.found.gap); },
            "Tip minus target [m], rotation vector from the target to the tip [rad], shape (6,).")
        .def_property_readonly("target",
                               [](const Reached& r) {
                                   Array pose({4, 4});
                                   write_matrix(r.target.pose, pose.mutable_data());
                                   return pose;
                               })
        .def_property_readonly("weights", [](const Reached& r) { return vector_array(r.target.weights); })
        .def_property_readonly("lower", [](const Reached& r) { return vector_array(r.lower); })
        .def_property_readonly("upper", [](const Reached& r) { return vector_array(r.upper); })
        .def_property_readonly("reached", [](const Reached& r) { return r.found.reached; })
        .def_property_readonly("least", [](const Reached& r) { return r.found.least; })
        .def_property_readonly("another_from_nothing", [](const Reached& r) { return r.found.another_from_nothing; })
        .def_property_readonly("status", [](const Reached& r) { return std::string(name_of(r.found.status)); })
        .def_property_readonly("iterations", [](const Reached& r) { return r.found.iterations; })
        .def_property_readonly("starts", [](const Reached& r) { return r.found.starts; });
    m.def("reach", &reach, py::arg("geometry"), py::arg("members"), py::arg("scene"), py::kw_only(), py::arg("target"),
          py::arg("weights"), py::arg("lower"), py::arg("upper"), py::arg("preferred"), py::arg("tolerance"),
          py::arg("section"), py::arg("valve"), py::arg("start"), py::arg("start_pressures"), py::arg("learned"),
          py::arg("starts"),
          R"(Pressures within bounds (one number an actuator [Pa]) that put the tip on the target pose (4, 4), errors
counted by six weights; of the scene only loads and holds count.)");
    m.def(
        "plain_reach", &plain_reach, py::arg("geometry"), py::arg("members"), py::arg("scene"), py::arg("position"),
        py::arg("pose"), py::arg("max_pressure"), py::arg("tolerance"), py::arg("section"), py::arg("valve"),
        py::arg("start"),
        R"(Arguments of Limb.reach as they come, `start` a core Posture, Reached or None. None where one is not plain or
not right: it is then for Python to say what is wrong.)");
}

}  // namespace softlimb::bindings
