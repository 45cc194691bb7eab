#include <pybind11/stl.h>

#include "bindings.hpp"
#include "softlimb/arguments.hpp"
#include "softlimb/bench/build_info.hpp"
#include "softlimb/bench/yardstick.hpp"

namespace py = pybind11;

namespace softlimb::bindings {
namespace {

py::typing::Tuple<double, double> yardstick(int repetitions) {
    if (repetitions < 1) reject("repetitions", repetitions, "at least 1");
    bench::Yardstick found;
    {
        py::gil_scoped_release unlocked;
        found = bench::yardstick(repetitions);
    }
    return py::make_tuple(found.microseconds, found.checksum);
}

py::typing::Dict<py::str, py::str> build_info() {
    const bench::BuildInfo info = bench::build_info();
    py::dict fields;
    fields["compiler"] = info.compiler;
    fields["flags"] = info.flags;
    fields["standard"] = info.standard;
    fields["target"] = info.target;
    fields["assertions"] = info.assertions ? "on" : "off";
    return fields;
}

}  // namespace

void bind_bench(py::module_& m) {
    m.def("yardstick", &yardstick, py::kw_only(), py::arg("repetitions") = 9,
          "Microseconds of one pass of a fixed loop (nine rods of eight Runge-Kutta steps, plain scalar code), the "
          "least of `repetitions` times 2000 passes, and its checksum, 0.159407.");
    m.def("build_info", &build_info,
          "Compiler, flags, language standard, target and assertions of this build, as texts.");
}

}  // namespace softlimb::bindings
