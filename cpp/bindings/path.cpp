#include "softlimb/limb/path.hpp"

#include <pybind11/functional.h>
#include <pybind11/stl.h>

#include "bindings.hpp"
#include "softlimb/limb/posture.hpp"

namespace py = pybind11;

namespace softlimb::bindings {
namespace {

using limb::Geometry;
using limb::Posture;

/// A followed path together with what it takes to look at it again.
struct FollowedPath {
    std::shared_ptr<Geometry> geometry;
    limb::SceneAt scene_at;
    limb::PathSettings settings;
    limb::Path path;
};

solve::Work work_of(const limb::PathSettings& settings, const Geometry& geometry) {
    // A step takes a hundred evaluations a rod or so; locating an event, a few thousand.
    return solve::Work(40'000L * settings.max_points * (1 + geometry.rods()), [] { return PyErr_CheckSignals() != 0; });
}

template <class Run>
auto raising_signals(Run&& run) {
    try {
        return run();
    } catch (const solve::Interrupted&) {
        throw py::error_already_set();
    }
}

// The scenes come from Python, step by step, so the interpreter lock stays with this call.
std::shared_ptr<FollowedPath> follow(const std::shared_ptr<Geometry>& geometry, limb::SceneAt scene_at,
                                     const Posture& first, double start, double stop, double tolerance,
                                     double largest_step, int max_points, bool through_events) {
    auto followed = std::make_shared<FollowedPath>();
    followed->geometry = geometry;
    followed->scene_at = std::move(scene_at);
    followed->settings.start = start, followed->settings.stop = stop;
    followed->settings.tolerance = tolerance;
    followed->settings.largest_step = largest_step;
    followed->settings.first_step = std::min(followed->settings.first_step, largest_step);
    followed->settings.max_points = max_points;
    followed->settings.through_events = through_events;
    solve::Work work = work_of(followed->settings, *geometry);
    followed->path = raising_signals(
        [&] { return limb::follow(*geometry, followed->scene_at, first.solution.shape, followed->settings, work); });
    return followed;
}

std::shared_ptr<Posture> posture_at(const FollowedPath& followed, const limb::PathPoint& point) {
    auto posture = std::make_shared<Posture>();
    posture->geometry = followed.geometry;
    const std::optional<limb::Scene> scene = followed.scene_at(point.parameter);
    if (!scene) throw std::runtime_error("the scene of this point no longer exists");
    posture->scene = *scene;
    posture->solution = limb::solution_at(*followed.geometry, posture->scene, point.shape, point.report);
    posture->solution.message = "converged on a followed path";
    posture->solution.plan = {"followed from an earlier posture: pseudo-arclength steps"};
    return posture;
}

/// Postures at a parameter between points `after` and `after` + 1: two where the path turns in between.
std::vector<std::shared_ptr<Posture>> between(const FollowedPath& followed, int after, double parameter) {
    const limb::PathPoint &first = followed.path.points.at(after), &last = followed.path.points.at(after + 1);
    const limb::PathPoint* turn = nullptr;
    for (const limb::PathEvent& event : followed.path.events)
        if (event.after == after && first.slope * last.slope < 0.0) turn = &event.point;
    solve::Work work = work_of(followed.settings, *followed.geometry);
    std::vector<std::shared_ptr<Posture>> postures;
    const auto look = [&](const limb::PathPoint& from, const limb::PathPoint& to) {
        if ((from.parameter - parameter) * (to.parameter - parameter) >= 0.0) return;
        const auto found = raising_signals([&] {
            return limb::point_between(*followed.geometry, followed.scene_at, from, to, parameter, followed.settings,
                                       work);
        });
        if (found) postures.push_back(posture_at(followed, *found));
    };
    look(first, turn ? *turn : last);
    if (turn) look(last, *turn);
    return postures;
}

const char* name_of(limb::PathEnd end) {
    switch (end) {
        case limb::PathEnd::stop:
            return "stop";
        case limb::PathEnd::start:
            return "start";
        case limb::PathEnd::event:
            return "event";
        case limb::PathEnd::no_scene:
            return "no_scene";
        case limb::PathEnd::lost:
            return "lost";
        case limb::PathEnd::max_points:
            return "max_points";
    }
    return "unknown";
}

template <class Value>
std::vector<double> values(const FollowedPath& followed, Value&& value) {
    std::vector<double> all;
    for (const limb::PathPoint& point : followed.path.points) all.push_back(value(point));
    return all;
}

}  // namespace

void bind_path(py::module_& m) {
    py::class_<FollowedPath, std::shared_ptr<FollowedPath>>(m, "FollowedPath", "Equilibria along one parameter.")
        .def(py::init<>(), "A path without points.")
        .def_property_readonly("end", [](const FollowedPath& f) { return std::string(name_of(f.path.end)); })
        .def_property_readonly(
            "parameters",
            [](const FollowedPath& f) { return values(f, [](const limb::PathPoint& p) { return p.parameter; }); })
        .def_property_readonly(
            "arclengths",
            [](const FollowedPath& f) { return values(f, [](const limb::PathPoint& p) { return p.arclength; }); })
        .def_property_readonly(
            "events",
            [](const FollowedPath& f) {
                std::vector<py::typing::Tuple<std::string, int, double>> events;
                for (const limb::PathEvent& e : f.path.events)
                    events.push_back(py::make_tuple(e.kind == limb::EventKind::fold ? "fold" : "bifurcation", e.after,
                                                    e.point.parameter));
                return events;
            })
        .def("posture", [](const FollowedPath& f, int i) { return posture_at(f, f.path.points.at(i)); })
        .def("event_posture", [](const FollowedPath& f, int i) { return posture_at(f, f.path.events.at(i).point); })
        .def("between", &between, py::arg("after"), py::arg("parameter"),
             "Postures at a parameter between points `after` and `after` + 1.");

    m.def("follow", &follow, py::arg("geometry"), py::arg("scene_at"), py::arg("first"), py::kw_only(),
          py::arg("start"), py::arg("stop"), py::arg("tolerance"), py::arg("largest_step"), py::arg("max_points"),
          py::arg("through_events"),
          "Follows the equilibrium `first`; scene_at(parameter) gives a Scene, or None where there is none.");
}

}  // namespace softlimb::bindings
