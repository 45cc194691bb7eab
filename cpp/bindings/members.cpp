#include "softlimb/sweep/members.hpp"

#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include <memory>
#include <optional>
#include <tuple>
#include <variant>
#include <vector>

#include "arrays.hpp"
#include "bindings.hpp"
#include "named.hpp"
#include "plain.hpp"
#include "softlimb/limb/posture.hpp"

namespace py = pybind11;

namespace softlimb::bindings {
namespace {

using limb::Geometry;
using limb::Posture;
using sweep::Members;
using GivenMember = std::variant<std::shared_ptr<actuator::Tube>, std::tuple<Section, double, double>>;

std::shared_ptr<Members> make_members(const std::vector<GivenMember>& given) {
    std::vector<sweep::Member> members;
    for (const GivenMember& one : given) {
        if (const auto* tube = std::get_if<std::shared_ptr<actuator::Tube>>(&one)) {
            members.push_back({*tube, {}, 0.0, (*tube)->outer_radius()});
        } else {
            const auto& [section, length, radius] = std::get<std::tuple<Section, double, double>>(one);
            members.push_back({nullptr, section, length, radius});
        }
    }
    return std::make_shared<Members>(std::move(members));
}

using Refused = std::optional<py::typing::Tuple<std::string, std::string>>;

py::typing::Tuple<std::vector<Section>, Array, Refused> sections_at(const Members& members, const Array& pressures,
                                                                    const std::string& model,
                                                                    const std::string& valve) {
    if (pressures.size() != members.actuators()) throw std::invalid_argument("one pressure an actuator is needed");
    std::vector<limb::RodAtPressure> rods(members.rods());
    const Members::Refusal refusal =
        members.at_pressures(pressures.data(), section_model(model), valve_of(valve), rods);
    std::vector<Section> sections;
    Array lengths(members.rods());
    for (int i = 0; i < members.rods(); ++i) {
        sections.push_back(rods[i].section);
        lengths.mutable_data()[i] = rods[i].rest_length;
    }
    Refused refused;
    if (refusal) refused = py::make_tuple(std::string(solve::name_of(refusal.status)), members.reason(refusal));
    return py::make_tuple(sections, lengths, refused);
}

/// Solves what is given in plain numbers without a detour through Python's checks.
class PlainSolver {
public:
    PlainSolver(std::shared_ptr<Geometry> geometry, std::shared_ptr<Members> members, std::vector<int> counts)
        : geometry_(std::move(geometry)), members_(std::move(members)), counts_(std::move(counts)) {
        blank_.rods.resize(members_->rods());
        blank_.wrenches.assign(geometry_->plates(), Vector6::Zero());
        blank_.holds.assign(geometry_->plates(), {});
    }

    std::optional<std::shared_ptr<Posture>> solve(const py::object& pressures, const py::object& rest_lengths,
                                                  const py::object& gravity, const py::object& force,
                                                  const py::object& moment, const py::object& frame,
                                                  const py::object& tolerance, const py::object& start,
                                                  const py::object& prefer_stable, const py::object& model,
                                                  const py::object& valve) const {
        const plain::Reader& read = plain::reader();
        limb::SolveOptions options;
        actuator::SectionModel section;
        actuator::Valve opening;
        bool following;
        const Posture* from = nullptr;
        if (!read.truth(prefer_stable, options.prefer_stable) || !read.tolerance(tolerance, options.tolerance) ||
            !read.choice(frame, {"base", "plate"}, following) ||
            !read.choice(model, {"tangent", "nonlinear", "paper"}, section) ||
            !read.choice(valve, {"open", "locked"}, opening) || !posture_of(start, from))
            return std::nullopt;

        auto posture = std::make_shared<Posture>();
        posture->geometry = geometry_;
        posture->scene = blank_;
        limb::Scene& scene = posture->scene;
        scene.following = following;
        double* tip = scene.wrenches.back().data();
        if (!read.three(gravity, scene.gravity.data()) || !read.three(force, tip) || !read.three(moment, tip + 3))
            return std::nullopt;
        if (members_->actuators() > 0) {
            posture->pressures.resize(members_->actuators());
            if (!read.by_segment(pressures, counts_, posture->pressures)) return std::nullopt;
        } else if (!pressures.is_none()) {
            return std::nullopt;
        }
        if (members_->at_pressures(posture->pressures.data(), section, opening, scene.rods)) return std::nullopt;
        if (!rest_lengths.is_none() && !read_rest_lengths(rest_lengths, scene)) return std::nullopt;
        options.interrupted = [] {
            py::gil_scoped_acquire locked;
            return PyErr_CheckSignals() != 0;
        };
        try {
            py::gil_scoped_release unlocked;
            posture->solution = from ? limb::solve(*geometry_, scene, options, from->solved())
                                     : limb::solve(*geometry_, scene, options, nullptr);
        } catch (const solve::Interrupted&) {
            throw py::error_already_set();
        }
        return posture;
    }

    /// Loads of a scene whose sections and rest lengths are not set; none where a number is not plain.
    std::optional<limb::Scene> loads(const py::object& gravity, const py::object& force, const py::object& moment,
                                     const py::object& frame) const {
        const plain::Reader& read = plain::reader();
        limb::Scene scene = blank_;
        double* tip = scene.wrenches.back().data();
        if (!read.choice(frame, {"base", "plate"}, scene.following) || !read.three(gravity, scene.gravity.data()) ||
            !read.three(force, tip) || !read.three(moment, tip + 3))
            return std::nullopt;
        return scene;
    }

private:
    /// Of a limb of rods given directly: tubes would need their pressures first.
    bool read_rest_lengths(const py::object& given, limb::Scene& scene) const {
        if (members_->actuators() > 0) return false;
        std::vector<int> counts;
        for (const limb::Segment& segment : geometry_->segments)
            counts.push_back(static_cast<int>(segment.rods.size()));
        std::vector<double> lengths(scene.rods.size());
        if (!plain::reader().by_segment(given, counts, lengths)) return false;
        for (std::size_t i = 0; i < lengths.size(); ++i) {
            if (!(lengths[i] > 0.0)) return false;
            scene.rods[i].rest_length = lengths[i];
        }
        return true;
    }
    /// Nothing, or a posture of a limb with as many rods and plates.
    bool posture_of(const py::object& start, const Posture*& from) const {
        if (start.is_none()) return true;
        if (!py::isinstance<Posture>(start)) return false;
        from = start.cast<const Posture*>();
        return from->solution.shape.rods.size() == blank_.rods.size() &&
               from->solution.shape.plates.size() == blank_.wrenches.size();
    }

    std::shared_ptr<Geometry> geometry_;
    std::shared_ptr<Members> members_;
    std::vector<int> counts_;  // of the actuators of each segment
    limb::Scene blank_;        // no loads, no holds
};

}  // namespace

void bind_members(py::module_& m) {
    py::class_<Members, std::shared_ptr<Members>>(m, "Members",
                                                  "What a limb is made of: tubes, or rods as (section, length, radius) "
                                                  "with radius 0 where it is not known; flat order.")
        .def(py::init(&make_members), py::arg("members"))
        .def("at_pressures", &sections_at, py::arg("pressures"), py::arg("section"), py::arg("valve"),
             "Sections, rest lengths, and status and reason where an actuator has no state.");
    py::class_<PlainSolver>(m, "PlainSolver", "Postures from plain numbers, in a few microseconds beside the solve.")
        .def(py::init<std::shared_ptr<Geometry>, std::shared_ptr<Members>, std::vector<int>>(), py::arg("geometry"),
             py::arg("members"), py::arg("actuators_of_segments"))
        .def("solve", &PlainSolver::solve, py::arg("pressures"), py::arg("rest_lengths"), py::arg("gravity"),
             py::arg("tip_force"), py::arg("tip_moment"), py::arg("frame"), py::arg("tolerance"), py::arg("start"),
             py::arg("prefer_stable"), py::arg("section"), py::arg("valve"),
             R"(Arguments of Limb.solve, positional, `start` a core Posture or None. None where one is not plain or has
no answer: it is then for Python to say what is wrong. Plain are floats and integers, lists and tuples of them, arrays
of float64; all finite and of the right number.)")
        .def("loads", &PlainSolver::loads, py::arg("gravity"), py::arg("tip_force"), py::arg("tip_moment"),
             py::arg("frame"),
             "A scene with these loads and neither sections nor lengths; None where one is not plain.");
}

}  // namespace softlimb::bindings
