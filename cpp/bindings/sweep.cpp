#include "softlimb/sweep/sweep.hpp"

#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include <optional>
#include <tuple>
#include <vector>

#include "arrays.hpp"
#include "bindings.hpp"
#include "named.hpp"
#include "softlimb/limb/posture.hpp"

namespace py = pybind11;

namespace softlimb::bindings {
namespace {

/// An array of the caller's that is written in place: exactly of this kind, never a copy of another.
template <class Number>
using InPlace = py::array_t<Number, py::array::c_style>;

template <class Number>
Number* rows_of(InPlace<Number>& array, const char* name, py::ssize_t rows, py::ssize_t row_size) {
    if (array.ndim() < 1 || array.shape(0) != rows || array.size() != rows * row_size)
        throw std::invalid_argument(std::string(name) + " has the wrong shape");
    return array.mutable_data();  // raises where it may not be written
}

void require_columns(const InPlace<double>& pressures, const sweep::Members& members) {
    if (pressures.ndim() != 2 || pressures.shape(1) != members.actuators())
        throw std::invalid_argument("pressures must have one column an actuator");
}

/// Asks Python whether to go on, and sees Ctrl-C.
sweep::Tick asking(const py::typing::Callable<bool(int)>& tick) {
    return [&tick](std::int64_t done) {
        py::gil_scoped_acquire locked;
        if (PyErr_CheckSignals() != 0) throw py::error_already_set();
        return py::cast<bool>(tick(done));
    };
}

using SheetState = std::tuple<std::vector<int>, std::vector<int>, std::vector<double>>;
using AtlasState = std::tuple<std::vector<int>, std::vector<int>, std::vector<int>, std::vector<double>,
                              std::vector<double>, std::vector<double>, std::vector<SheetState>>;

AtlasState state_of(const sweep::Atlas& atlas) {
    const sweep::Atlas::Content& c = atlas.content();
    std::vector<SheetState> sheets;
    for (const sweep::Atlas::Sheet& sheet : c.sheets)
        sheets.emplace_back(sheet.earlier, sheet.variable, sheet.coefficients);
    return {c.mesh.elements, c.mesh.steps, c.first_rod, c.direction, c.middle, c.scale, sheets};
}

sweep::Atlas atlas_of(const AtlasState& state) {
    const auto& [elements, steps, first_rod, direction, middle, scale, states] = state;
    sweep::Atlas::Content content{{elements, steps}, first_rod, direction, middle, scale, {}};
    for (const auto& [earlier, variable, coefficients] : states)
        content.sheets.push_back({earlier, variable, coefficients});
    return sweep::Atlas(std::move(content));
}

std::optional<sweep::Atlas> survey_rows(const std::shared_ptr<limb::Geometry>& geometry,
                                        const std::shared_ptr<sweep::Members>& members, const limb::Scene& scene,
                                        const InPlace<double>& pressures, double tolerance, const std::string& section,
                                        const std::string& valve, int threads,
                                        const py::typing::Callable<bool(int)>& tick) {
    require_columns(pressures, *members);
    sweep::SweepOptions options;
    options.model = section_model(section), options.valve = valve_of(valve);
    options.tolerance = tolerance, options.threads = threads;
    const sweep::Tick ask = asking(tick);
    const double* given = pressures.data();
    const py::ssize_t rows = pressures.shape(0);
    py::gil_scoped_release unlocked;
    return sweep::survey(*geometry, *members, scene, options, given, rows, ask);
}

void sweep_rows(const std::shared_ptr<limb::Geometry>& geometry, const std::shared_ptr<sweep::Members>& members,
                const limb::Scene& scene, const InPlace<double>& pressures, double tolerance, bool prefer_stable,
                const std::string& section, const std::string& valve, bool ordered,
                const std::optional<std::shared_ptr<sweep::Atlas>>& atlas, int threads,
                const std::optional<std::shared_ptr<limb::Posture>>& start, const std::optional<Array>& start_plates,
                InPlace<double> tip, InPlace<double> plates, InPlace<std::int8_t> status, InPlace<bool> success,
                InPlace<bool> stable, InPlace<std::int64_t> unstable_modes, InPlace<double> clearance,
                InPlace<std::int64_t> iterations, InPlace<double> residual,
                const py::typing::Dict<py::int_, py::str>& message, const py::typing::Callable<bool(int)>& tick) {
    require_columns(pressures, *members);
    const py::ssize_t rows = pressures.shape(0), pose = 16;
    const sweep::RowAnswers answers{
        rows_of(tip, "tip", rows, pose),          rows_of(plates, "plates", rows, pose * geometry->plates()),
        rows_of(status, "status", rows, 1),       rows_of(success, "success", rows, 1),
        rows_of(stable, "stable", rows, 1),       rows_of(unstable_modes, "unstable_modes", rows, 1),
        rows_of(clearance, "clearance", rows, 1), rows_of(iterations, "iterations", rows, 1),
        rows_of(residual, "residual", rows, 1)};
    sweep::SweepOptions options;
    options.model = section_model(section), options.valve = valve_of(valve);
    options.tolerance = tolerance, options.prefer_stable = prefer_stable;
    options.ordered = ordered, options.threads = threads;
    if (atlas) options.atlas = atlas->get();
    if (start) options.start = start->get();
    std::vector<Pose> first;
    if (start_plates) first = poses_of(*start_plates), options.start_plates = &first;

    const sweep::Tick ask = asking(tick);
    std::vector<sweep::RowMessage> messages;
    std::exception_ptr raised;
    try {
        py::gil_scoped_release unlocked;
        sweep::sweep(*geometry, *members, scene, options, pressures.data(), rows, answers, messages, ask);
    } catch (...) {
        raised = std::current_exception();
    }
    for (const sweep::RowMessage& one : messages) message[py::int_(one.row)] = one.text;
    if (raised) std::rethrow_exception(raised);
}

}  // namespace

void bind_sweep(py::module_& m) {
    m.attr("CHUNK_ROWS") = sweep::chunk_rows;
    m.def(
        "status_names",
        [] {
            std::vector<std::string> names;
            for (int i = 0; i <= static_cast<int>(solve::SolveStatus::limit_point); ++i)
                names.emplace_back(solve::name_of(static_cast<solve::SolveStatus>(i)));
            return names;
        },
        "Names of the outcomes of a solve, by number.");
    py::class_<sweep::Atlas, std::shared_ptr<sweep::Atlas>>(
        m, "Atlas", "Starts for the rows of a long sweep, fitted to some of them; made by `survey_rows`.")
        .def_property_readonly(
            "terms",
            [](const sweep::Atlas& atlas) {
                std::vector<std::size_t> terms;
                for (const sweep::Atlas::Sheet& sheet : atlas.content().sheets) terms.push_back(sheet.terms());
                return terms;
            },
            "Numbers of terms of the polynomials of its segments.")
        .def(py::pickle(&state_of, &atlas_of));
    m.def("survey_rows", &survey_rows, py::arg("geometry"), py::arg("members"), py::arg("scene"),
          py::arg("pressures").noconvert(), py::kw_only(), py::arg("tolerance"), py::arg("section"), py::arg("valve"),
          py::arg("threads"), py::arg("tick"),
          R"(Solves rows of pressures (N, A) from nothing and fits an atlas to them, without the interpreter lock.

None where an atlas does not serve: the limb is held, too few rows have an answer, rods need many pieces, or a row has
another stable posture, which each row should then say itself. `tick` as for `sweep_rows`; none after a stop.)");
    m.def("sweep_rows", &sweep_rows, py::arg("geometry"), py::arg("members"), py::arg("scene"),
          py::arg("pressures").noconvert(), py::kw_only(), py::arg("tolerance"), py::arg("prefer_stable"),
          py::arg("section"), py::arg("valve"), py::arg("ordered"), py::arg("atlas"), py::arg("threads"),
          py::arg("start"), py::arg("start_plates"), py::arg("tip").noconvert(), py::arg("plates").noconvert(),
          py::arg("status").noconvert(), py::arg("success").noconvert(), py::arg("stable").noconvert(),
          py::arg("unstable_modes").noconvert(), py::arg("clearance").noconvert(), py::arg("iterations").noconvert(),
          py::arg("residual").noconvert(), py::arg("message"), py::arg("tick"),
          R"(Solves one posture a row of pressures (N, A) into the given arrays, without the interpreter lock.

`status` has numbers of `status_names`, and keeps what it has (-1) for rows not come to; where a row did not converge,
poses, stability and clearance stay as they were. `message` gets by row what is more than "converged". `tick(done)` is
asked ten times a second by the calling thread; false, an exception or Ctrl-C stops the workers and keeps what is done.)");
}

}  // namespace softlimb::bindings
