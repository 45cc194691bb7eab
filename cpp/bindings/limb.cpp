#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include <limits>

#include "arrays.hpp"
#include "bindings.hpp"
#include "softlimb/arguments.hpp"
#include "softlimb/limb/posture.hpp"
#include "softlimb/limb/start.hpp"

namespace py = pybind11;

namespace softlimb::bindings {
namespace {

using limb::Geometry;
using limb::Posture;
using Flags = py::array_t<bool, py::array::c_style | py::array::forcecast>;

void require_shape(const py::array& a, const std::vector<py::ssize_t>& shape, const char* name) {
    bool same = a.ndim() == static_cast<py::ssize_t>(shape.size());
    for (std::size_t k = 0; same && k < shape.size(); ++k) same = a.shape(k) == shape[k];
    if (!same) throw std::invalid_argument(std::string(name) + " has the wrong shape");
}

Vector6 vector6_at(const Array& a, py::ssize_t i) { return Eigen::Map<const Vector6>(a.data() + 6 * i); }
Vector3 vector3_at(const Array& a, py::ssize_t i) { return Eigen::Map<const Vector3>(a.data() + 3 * i); }

std::shared_ptr<Geometry> make_geometry(const std::vector<std::tuple<Array, Array, double, double>>& segments,
                                        double length) {
    auto geometry = std::make_shared<Geometry>();
    for (const auto& [base, end, thickness, mass] : segments) {
        limb::Segment segment;
        segment.plate_thickness = thickness;
        segment.plate_mass = mass;
        require_shape(end, {base.shape(0), 4, 4}, "end_frames");
        require_shape(base, {base.shape(0), 4, 4}, "base_frames");
        for (py::ssize_t i = 0; i < base.shape(0); ++i) segment.rods.push_back({pose_at(base, i), pose_at(end, i)});
        geometry->segments.push_back(std::move(segment));
    }
    geometry->length = length;
    return geometry;
}

State geometry_state(const Geometry& g) {
    py::list segments;
    for (const limb::Segment& s : g.segments) {
        std::vector<Pose> base, end;
        for (const auto& rod : s.rods) base.push_back(rod.base), end.push_back(rod.end);
        segments.append(py::make_tuple(poses_array(base), poses_array(end), s.plate_thickness, s.plate_mass));
    }
    return py::make_tuple(segments, g.length);
}

std::shared_ptr<Geometry> geometry_of(const State& t) {
    return make_geometry(t[0].cast<std::vector<std::tuple<Array, Array, double, double>>>(), t[1].cast<double>());
}

limb::Scene make_scene(const Geometry& geometry, const std::vector<Section>& sections, const Array& rest_lengths,
                       const Array& gravity, const Array& wrenches, bool following, const Array& line_forces,
                       const Array& line_moments, const Flags& held, const Array& hold_poses) {
    const py::ssize_t rods = geometry.rods(), plates = geometry.plates();
    if (static_cast<py::ssize_t>(sections.size()) != rods) throw std::invalid_argument("one section a rod is needed");
    require_shape(rest_lengths, {rods}, "rest_lengths");
    require_shape(gravity, {3}, "gravity");
    require_shape(wrenches, {plates, 6}, "wrenches");
    require_shape(line_forces, {rods, 3}, "line_forces");
    require_shape(line_moments, {rods, 3}, "line_moments");
    require_shape(held, {plates, 6}, "held");
    require_shape(hold_poses, {plates, 4, 4}, "hold_poses");
    limb::Scene scene;
    for (py::ssize_t i = 0; i < rods; ++i)
        scene.rods.push_back({sections[i],
                              rest_lengths.data()[i],
                              {vec3(vector3_at(line_forces, i)), vec3(vector3_at(line_moments, i))}});
    scene.gravity = vector3_at(gravity, 0);
    scene.following = following;
    for (py::ssize_t j = 0; j < plates; ++j) {
        scene.wrenches.push_back(vector6_at(wrenches, j));
        limb::Hold hold;
        for (int k = 0; k < 6; ++k) hold.held[k] = held.data()[6 * j + k];
        hold.pose = pose_at(hold_poses, j);
        scene.holds.push_back(hold);
    }
    return scene;
}

std::shared_ptr<Posture> solve(const std::shared_ptr<Geometry>& geometry, limb::Scene scene, double tolerance,
                               bool prefer_stable, const std::optional<std::shared_ptr<Posture>>& start,
                               const std::optional<Array>& start_plates) {
    auto posture = std::make_shared<Posture>();
    posture->geometry = geometry;
    posture->scene = std::move(scene);
    limb::SolveOptions options;
    options.tolerance = tolerance;
    options.prefer_stable = prefer_stable;
    std::optional<limb::Shape> shape;
    if (!start && start_plates) shape = limb::start_from_plates(*geometry, posture->scene, poses_of(*start_plates));
    options.interrupted = [] {
        py::gil_scoped_acquire locked;
        return PyErr_CheckSignals() != 0;
    };
    try {
        py::gil_scoped_release unlocked;
        posture->solution = start ? limb::solve(*geometry, posture->scene, options, (*start)->solved())
                                  : limb::solve(*geometry, posture->scene, options, shape ? &*shape : nullptr);
    } catch (const solve::Interrupted&) {
        throw py::error_already_set();
    }
    return posture;
}

/// A posture that could not even be asked for (a pressure without a section): the start, with the reason.
std::shared_ptr<Posture> refused(const std::shared_ptr<Geometry>& geometry, limb::Scene scene,
                                 const std::string& status, const std::string& message) {
    auto posture = std::make_shared<Posture>();
    posture->geometry = geometry;
    posture->scene = std::move(scene);
    limb::Solution& solution = posture->solution;
    solution.shape =
        limb::start_from_plates(*geometry, posture->scene, limb::constant_curvature_plates(*geometry, posture->scene));
    solution.status = solve::status_named(status);
    solution.message = message;
    solution.conservative = posture->scene.conservative();
    solution.residual = std::numeric_limits<double>::infinity();
    solution.reactions.assign(geometry->plates(), Vector6::Zero());
    return posture;
}

using Curves = py::typing::Tuple<Array, Array, Array, Array, Array>;

Curves rod_arrays(const Posture& posture, int rod, const std::vector<double>& fractions) {
    if (rod < 0 || rod >= static_cast<int>(posture.scene.rods.size())) throw py::index_error("no such rod");
    const auto points = limb::points_along(posture, rod, fractions);
    const py::ssize_t count = static_cast<py::ssize_t>(points.size());
    Array poses({count, py::ssize_t{4}, py::ssize_t{4}});
    std::array<Array, 4> vectors;
    for (Array& a : vectors) a = Array({count, py::ssize_t{3}});
    for (py::ssize_t k = 0; k < count; ++k) {
        write_matrix(points[k].pose, poses.mutable_data() + 16 * k);
        const std::array<const Vector3*, 4> source = {&points[k].force, &points[k].moment, &points[k].strain,
                                                      &points[k].curvature};
        for (int v = 0; v < 4; ++v) std::copy_n(source[v]->data(), 3, vectors[v].mutable_data() + 3 * k);
    }
    return py::make_tuple(poses, vectors[0], vectors[1], vectors[2], vectors[3]);
}

State scene_state(const limb::Scene& scene) {
    std::vector<Section> sections;
    std::vector<double> lengths;
    std::vector<Vector6> loads;
    std::vector<std::array<bool, 6>> held;
    std::vector<Pose> poses;
    for (const auto& rod : scene.rods) {
        sections.push_back(rod.section), lengths.push_back(rod.rest_length);
        Vector6 load;
        load << eigen(rod.line_load.force), eigen(rod.line_load.moment);
        loads.push_back(load);
    }
    for (const auto& hold : scene.holds) held.push_back(hold.held), poses.push_back(hold.pose);
    return py::make_tuple(sections, lengths, vectors_array(loads), vector_array(scene.gravity),
                          vectors_array(scene.wrenches), scene.following, held, poses_array(poses));
}

limb::Scene scene_of(const State& t) {
    limb::Scene scene;
    const auto sections = t[0].cast<std::vector<Section>>();
    const auto lengths = t[1].cast<std::vector<double>>();
    const auto loads = t[2].cast<Array>();
    for (std::size_t i = 0; i < sections.size(); ++i) {
        const Vector6 load = vector6_at(loads, static_cast<py::ssize_t>(i));
        scene.rods.push_back({sections[i], lengths[i], {vec3(Vector3(load.head<3>())), vec3(Vector3(load.tail<3>()))}});
    }
    scene.gravity = vector3_at(t[3].cast<Array>(), 0);
    const auto wrenches = t[4].cast<Array>();
    scene.following = t[5].cast<bool>();
    const auto held = t[6].cast<std::vector<std::array<bool, 6>>>();
    const auto poses = poses_of(t[7].cast<Array>());
    for (std::size_t j = 0; j < held.size(); ++j) {
        scene.wrenches.push_back(vector6_at(wrenches, static_cast<py::ssize_t>(j)));
        scene.holds.push_back({held[j], poses[j]});
    }
    return scene;
}

State posture_state(const Posture& p) {
    const limb::Solution& s = p.solution;
    py::list rods;
    for (const limb::RodShape& rod : s.shape.rods)
        rods.append(py::make_tuple(poses_array(rod.nodes), vectors_array(rod.wrenches), rod.integration.order,
                                   rod.integration.steps));
    return py::make_tuple(geometry_state(*p.geometry), scene_state(p.scene), poses_array(s.shape.plates), rods,
                          static_cast<int>(s.status), s.message, s.plan, s.iterations, s.descent_iterations, s.residual,
                          s.error_estimate, s.conservative, s.stable, s.unstable_modes, vector_array(s.base_wrench),
                          vectors_array(s.reactions), p.pressures, s.followed);
}

std::shared_ptr<Posture> posture_of(const State& t) {
    auto p = std::make_shared<Posture>();
    p->geometry = geometry_of(t[0].cast<State>());
    p->scene = scene_of(t[1].cast<State>());
    limb::Solution& s = p->solution;
    s.shape.plates = poses_of(t[2].cast<Array>());
    for (const py::handle& item : t[3].cast<py::list>()) {
        const auto rod = item.cast<py::tuple>();
        limb::RodShape shape;
        shape.nodes = poses_of(rod[0].cast<Array>());
        const auto wrenches = rod[1].cast<Array>();
        for (py::ssize_t e = 0; e < wrenches.shape(0); ++e) shape.wrenches.push_back(vector6_at(wrenches, e));
        shape.integration = {rod[2].cast<int>(), rod[3].cast<int>()};
        s.shape.rods.push_back(std::move(shape));
    }
    s.status = static_cast<solve::SolveStatus>(t[4].cast<int>());
    s.message = t[5].cast<std::string>();
    s.plan = t[6].cast<std::vector<std::string>>();
    s.iterations = t[7].cast<int>(), s.descent_iterations = t[8].cast<int>();
    s.residual = t[9].cast<double>(), s.error_estimate = t[10].cast<double>();
    s.conservative = t[11].cast<bool>(), s.stable = t[12].cast<bool>();
    s.unstable_modes = t[13].cast<std::optional<int>>();
    s.base_wrench = vector6_at(t[14].cast<Array>(), 0);
    const auto reactions = t[15].cast<Array>();
    for (py::ssize_t j = 0; j < reactions.shape(0); ++j) s.reactions.push_back(vector6_at(reactions, j));
    p->pressures = t[16].cast<std::vector<double>>();
    s.followed = t[17].cast<bool>();
    return p;
}

}  // namespace

void bind_limb(py::module_& m) {
    // Declared before anything mentions them, so that signatures carry Python names.
    py::class_<Posture, std::shared_ptr<Posture>> posture(m, "Posture", "A solved limb: shape, wrenches, outcome.");

    py::class_<limb::Scene>(m, "Scene", "Rods at their pressures, loads and holds of one solve.")
        .def_readonly("following", &limb::Scene::following)
        .def_property_readonly("gravity", [](const limb::Scene& s) { return vector_array(s.gravity); })
        .def_property_readonly("sections",
                               [](const limb::Scene& s) {
                                   std::vector<Section> sections;
                                   for (const auto& rod : s.rods) sections.push_back(rod.section);
                                   return sections;
                               })
        .def_property_readonly("wrenches", [](const limb::Scene& s) { return vectors_array(s.wrenches); })
        .def_property_readonly("rest_lengths", [](const limb::Scene& s) {
            std::vector<double> lengths;
            for (const auto& rod : s.rods) lengths.push_back(rod.rest_length);
            return lengths;
        });

    py::class_<Geometry, std::shared_ptr<Geometry>>(m, "Geometry",
                                                    "Placement of rods and plates of a limb; constant and shared.")
        .def(py::init(&make_geometry), py::arg("segments"), py::arg("length"))
        .def_readonly("length", &Geometry::length, "Reference length [m]")
        .def("scene", &make_scene, py::kw_only(), py::arg("sections"), py::arg("rest_lengths"), py::arg("gravity"),
             py::arg("wrenches"), py::arg("following"), py::arg("line_forces"), py::arg("line_moments"),
             py::arg("held"), py::arg("hold_poses"), "Scene of one solve; arrays as in Limb.solve, all given.")
        .def("solve", &solve, py::arg("scene"), py::kw_only(), py::arg("tolerance"), py::arg("prefer_stable"),
             py::arg("start"), py::arg("start_plates"), "Equilibrium of the scene.")
        .def("refused", &refused, py::arg("scene"), py::kw_only(), py::arg("status"), py::arg("message"),
             "Posture of a scene that cannot be solved, with the reason.")
        .def(
            "start_plates",
            [](const Geometry& g, const limb::Scene& scene) {
                return poses_array(limb::constant_curvature_plates(g, scene));
            },
            py::arg("scene"), "Plates under constant curvature, unloaded: where a solve without a start begins.")
        .def(py::pickle([](const Geometry& g) { return geometry_state(g); }, &geometry_of));

    posture.def_property_readonly("status", [](const Posture& p) { return std::string(name_of(p.solution.status)); })
        .def_property_readonly("message", [](const Posture& p) { return p.solution.message; })
        .def_property_readonly("plan", [](const Posture& p) { return p.solution.plan; })
        .def_property_readonly("iterations", [](const Posture& p) { return p.solution.iterations; })
        .def_property_readonly("descent_iterations", [](const Posture& p) { return p.solution.descent_iterations; })
        .def_property_readonly("residual", [](const Posture& p) { return p.solution.residual; })
        .def_property_readonly("error_estimate", [](const Posture& p) { return p.solution.error_estimate; })
        .def_property_readonly(
            "followed", [](const Posture& p) { return p.solution.followed; },
            "Solved from a posture near by, and linearised at the answer.")
        .def_property_readonly("conservative", [](const Posture& p) { return p.solution.conservative; })
        .def_property_readonly("stable", [](const Posture& p) { return p.solution.stable; })
        .def_property_readonly("unstable_modes", [](const Posture& p) { return p.solution.unstable_modes; })
        .def_property_readonly("plates", [](const Posture& p) { return poses_array(p.solution.shape.plates); })
        .def_property_readonly("base_wrench", [](const Posture& p) { return vector_array(p.solution.base_wrench); })
        .def_property_readonly("reactions", [](const Posture& p) { return vectors_array(p.solution.reactions); })
        .def_property_readonly("scene", [](const Posture& p) { return p.scene; })
        .def_property_readonly(
            "pressures",
            [](const Posture& p) -> std::optional<Array> {
                if (p.pressures.empty()) return std::nullopt;
                return Array(static_cast<py::ssize_t>(p.pressures.size()), p.pressures.data());
            },
            "Of the actuators, where the rods came from pressures [Pa].")
        .def_property_readonly("elements",
                               [](const Posture& p) {
                                   std::vector<int> counts;
                                   for (const auto& rod : p.solution.shape.rods) counts.push_back(rod.elements());
                                   return counts;
                               })
        .def(
            "rod", &rod_arrays, py::arg("rod"), py::arg("fractions"),
            "Poses (n,4,4), forces, moments, strains, curvatures (n,3) of rod number `rod` at fractions of its length.")
        .def("rod_base_wrench",
             [](const Posture& p, int rod) { return vector_array(p.solution.shape.rods.at(rod).wrenches.front()); })
        .def("clearance",
             [](const Posture& p, const std::vector<double>& radii,
                int points) -> py::typing::Tuple<double, int, int, double, double> {
                 const limb::Clearance c = limb::clearance(p, radii, points);
                 return py::make_tuple(c.gap, c.first, c.second, c.first_fraction, c.second_fraction);
             })
        .def(
            "remarks",
            [](const Posture& p, double gap, int first) {
                limb::Clearance nearest;
                nearest.gap = gap, nearest.first = first;
                return limb::remarks(p, nearest);
            },
            py::arg("gap"), py::arg("first"), "What to know before the posture is trusted; of its clearance.")
        .def("verify",
             [](const Posture& p) -> py::typing::Tuple<double, double, double, double, double> {
                 const limb::Verification v = limb::verify(p);
                 return py::make_tuple(v.position_error, v.rotation_error, v.force_error, v.moment_error, v.hold_error);
             })
        .def(py::pickle([](const Posture& p) { return posture_state(p); }, &posture_of));
}

}  // namespace softlimb::bindings
