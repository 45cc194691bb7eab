#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include "bindings.hpp"
#include "softlimb/arguments.hpp"
#include "softlimb/rod/element.hpp"

namespace py = pybind11;

namespace softlimb::bindings {
namespace {

using Vector6Numbers = std::array<double, 6>;
using Vector3Numbers = std::array<double, 3>;

std::vector<int> integrator_orders() {
    std::vector<int> orders;
    rod::Integrators::for_each([&]<class Method>() { orders.push_back(Method::order); });
    return orders;
}

py::typing::Tuple<Vector3Numbers, std::array<Vector3Numbers, 3>, Vector6Numbers> rod_end(
    const Section& section, double length, const Vector6Numbers& wrench, const Vector3Numbers& line_force, int order,
    int steps) {
    require_positive("length", length);
    if (steps < 1) reject("steps", steps, "at least 1");
    const rod::RodPiece piece{&section, length, {{line_force[0], line_force[1], line_force[2]}, {}}};
    const rod::EndState end =
        rod::end_of(piece, {}, Eigen::Map<const Vector6>(wrench.data()), rod::Integration{order, steps});
    const Pose& pose = end.pose;
    std::array<Vector3Numbers, 3> rotation;
    Vector6Numbers end_wrench;
    for (int r = 0; r < 3; ++r)
        for (int c = 0; c < 3; ++c) rotation[r][c] = pose.rotation(r, c);
    for (int k = 0; k < 6; ++k) end_wrench[k] = end.wrench(k);
    return py::make_tuple(Vector3Numbers{pose.position.x(), pose.position.y(), pose.position.z()}, rotation,
                          end_wrench);
}

}  // namespace

void bind_rod(py::module_& m) {
    m.def(
        "instruction_set", [] { return std::string(rod::lanes::kernel().instruction_set); },
        "Instruction set that the rods are integrated with: baseline, avx2 or avx512.");
    m.def(
        "instruction_sets",
        [] {
            std::vector<std::string> names;
            for (const rod::lanes::Kernel* kernel : rod::lanes::kernels()) names.push_back(kernel->instruction_set);
            return names;
        },
        "Those that this machine has, plainest first.");
    m.def(
        "use_instruction_set", &rod::lanes::use, py::arg("name"),
        "Integrates with another one from now on; ValueError when the machine has it not. Answers agree to rounding.");
    m.def("integrator_orders", &integrator_orders, "Orders of the integrators in the list.");
    m.def("rod_end", &rod_end, py::arg("section"), py::kw_only(), py::arg("length"), py::arg("wrench"),
          py::arg("line_force"), py::arg("order"), py::arg("steps"),
          R"(Shoot a rod from the origin with a base wrench: end position, rotation and internal wrench.

Parameters
----------
section : Section
length : float
    Rest length [m].
wrench : sequence of 6 floats
    Internal force and moment at the base [N, N m].
line_force : sequence of 3 floats
    Dead load per rest length [N/m].
order, steps : int
    Which integrator of the list, and how many equal steps it takes.

Raises
------
ValueError
    The length is not positive, there is no step, or no integrator has that order.)");
}

}  // namespace softlimb::bindings
