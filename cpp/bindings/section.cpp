#include "softlimb/section.hpp"

#include <pybind11/stl.h>

#include <sstream>
#include <vector>

#include "bindings.hpp"
#include "given.hpp"

namespace py = pybind11;

namespace softlimb::bindings {
namespace {

State state_of(const Section& s) {
    const AxialLaw& a = s.axial_law;
    return py::make_tuple(s.axial, s.shear, s.bending, s.torsion, s.mass_per_length, s.rest_twist, s.extension_twist,
                          s.stretch, s.largest_stretch, a.degree, a.centre, a.half_range, a.coefficient);
}

Section section_of(const State& t) {
    Section s;
    s.axial = py::object(t[0]).cast<double>(), s.shear = py::object(t[1]).cast<double>(),
    s.bending = py::object(t[2]).cast<double>();
    s.torsion = py::object(t[3]).cast<double>(), s.mass_per_length = py::object(t[4]).cast<double>(),
    s.rest_twist = py::object(t[5]).cast<double>();
    s.extension_twist = py::object(t[6]).cast<double>(), s.stretch = py::object(t[7]).cast<double>(),
    s.largest_stretch = py::object(t[8]).cast<double>();
    s.axial_law.degree = py::object(t[9]).cast<int>(), s.axial_law.centre = py::object(t[10]).cast<double>();
    s.axial_law.half_range = py::object(t[11]).cast<double>();
    s.axial_law.coefficient = py::object(t[12]).cast<std::array<double, AxialLaw::max_degree + 1>>();
    return s;
}

std::string text_of(const Section& s) {
    std::ostringstream text;
    text.precision(6);
    text << "Section(axial=" << s.axial << ", shear=" << s.shear << ", bending=" << s.bending
         << ", torsion=" << s.torsion << ", mass_per_length=" << s.mass_per_length;
    if (s.rest_twist != 0.0) text << ", rest_twist=" << s.rest_twist;
    if (s.extension_twist != 0.0) text << ", extension_twist=" << s.extension_twist;
    if (!s.axial_law.linear()) text << ", nonlinear axial law";
    text << ")";
    return text.str();
}

}  // namespace

void bind_section(py::module_& m) {
    py::class_<Section>(m, "Section", R"(Stiffness of a rod's cross-section, per rest length, SI.

Transversely isotropic about the rod's axis: ``n = R diag(GA, GA, EA) (v - v*)``, ``m = R diag(EI, EI, GJ) (u - u*)``
with ``v* = (0, 0, 1)`` and ``u* = (0, 0, rest_twist)``. Source: MECHANICS, "Section".

Parameters
----------
axial, shear : float
    EA and GA [N].
bending, torsion : float
    EI and GJ [N m^2].
mass_per_length : float
    Mass per rest length [kg/m].
rest_twist : float
    Twist of the unloaded section [rad/m].
extension_twist : float
    Compliance that couples axial force to twist and axial moment to stretch [1/(N m)].

Raises
------
ValueError
    A value is not finite, a stiffness is not positive, a mass is negative, or the coupling is too strong.)")
        .def(py::init([](const Given<double>& axial, const Given<double>& shear, const Given<double>& bending,
                         const Given<double>& torsion, const Given<double>& mass_per_length,
                         const Given<double>& rest_twist, const Given<double>& extension_twist) {
                 return Section::make(taken("axial", axial), taken("shear", shear), taken("bending", bending),
                                      taken("torsion", torsion), taken("mass_per_length", mass_per_length),
                                      taken("rest_twist", rest_twist), taken("extension_twist", extension_twist));
             }),
             py::kw_only(), py::arg("axial"), py::arg("shear"), py::arg("bending"), py::arg("torsion"),
             py::arg("mass_per_length") = 0.0, py::arg("rest_twist") = 0.0, py::arg("extension_twist") = 0.0)
        .def_readonly("axial", &Section::axial, "EA [N]")
        .def_readonly("shear", &Section::shear, "GA [N]")
        .def_readonly("bending", &Section::bending, "EI [N m^2]")
        .def_readonly("torsion", &Section::torsion, "GJ [N m^2]")
        .def_readonly("mass_per_length", &Section::mass_per_length, "Mass per rest length [kg/m]")
        .def_readonly("rest_twist", &Section::rest_twist, "Twist of the unloaded section [rad/m]")
        .def_readonly("extension_twist", &Section::extension_twist, "Coupling compliance [1/(N m)]")
        .def_readonly("stretch", &Section::stretch, "Rest length over the length at zero pressure")
        .def_readonly("largest_stretch", &Section::largest_stretch,
                      "Total stretch up to which the material laws were fitted; 0 when not known")
        .def_property_readonly(
            "nonlinear", [](const Section& s) { return !s.axial_law.linear(); },
            "True when the axial law is a curve and not the constant EA")
        .def("__eq__", &equals<Section>, py::arg("other"))
        .def("__hash__",
             [](const Section& s) { return py::hash(py::make_tuple(s.axial, s.shear, s.bending, s.torsion)); })
        .def("__repr__", [](const Section& s) { return text_of(s); })
        .def(py::pickle([](const Section& s) { return state_of(s); }, &section_of));
}

}  // namespace softlimb::bindings
