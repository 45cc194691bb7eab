#include "softlimb/limb/derivatives.hpp"

#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include <memory>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include "arrays.hpp"
#include "bindings.hpp"
#include "named.hpp"
#include "softlimb/limb/energy.hpp"
#include "softlimb/materials/coefficients.hpp"
#include "softlimb/sweep/parameters.hpp"

namespace py = pybind11;

namespace softlimb::bindings {
namespace {

using limb::Derivatives;
using limb::Posture;
using sweep::Members;
using sweep::Parameter;
using sweep::Parameters;

/// Kind (of a tube's numbers with what it is called there: "tube radius"), place, layer, number or component, twin,
/// direction, column, factor.
using GivenParameter = std::tuple<std::string, int, int, int, int, std::optional<std::vector<double>>, int, double>;

std::shared_ptr<Parameters> make_parameters(const std::vector<GivenParameter>& given, int columns) {
    auto parameters = std::make_shared<Parameters>();
    parameters->columns = columns;
    const std::string of_tube = "tube ";
    for (const auto& [kind, place, layer, number, twin, direction, column, factor] : given) {
        Parameter p;
        p.place = place, p.column = column, p.factor = factor;
        if (kind.starts_with(of_tube)) {
            p.tube = {tube_parameter(kind.substr(of_tube.size())), layer, number, twin};
        } else {
            using Kind = Parameter::Kind;
            p.kind = named<Kind>("kind of a parameter", kind,
                                 {{"rod section", Kind::rod_section},
                                  {"rod length", Kind::rod_length},
                                  {"placement", Kind::placement},
                                  {"line force", Kind::line_force},
                                  {"plate thickness", Kind::plate_thickness},
                                  {"plate mass", Kind::plate_mass},
                                  {"wrench", Kind::wrench},
                                  {"gravity", Kind::gravity}});
            p.component = number;
        }
        if (direction) {
            if (direction->size() != 12) throw std::invalid_argument("a direction has 12 numbers");
            p.direction = Eigen::Map<const Vector12>(direction->data());
        }
        parameters->list.push_back(p);
    }
    return parameters;
}

Array matrix_array(const Eigen::MatrixXd& m) {
    Array out({m.rows(), m.cols()});
    Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>(out.mutable_data(), m.rows(),
                                                                                       m.cols()) = m;
    return out;
}

/// What a posture was made from, beside its scene: members, pressures, section model, valve.
using Made = std::tuple<std::shared_ptr<Members>, Array, std::string, std::string>;

std::vector<limb::SceneRate> rates(const Posture& posture, const Parameters& parameters, const Made& made) {
    const auto& [members, pressures, model, valve] = made;
    if (pressures.size() != members->actuators()) throw std::invalid_argument("one pressure an actuator is needed");
    sweep::check(parameters, *members, *posture.geometry);
    return sweep::rates_of(parameters, *members, posture.scene, pressures.data(), section_model(model),
                           valve_of(valve));
}

std::vector<limb::MaterialPoint> points_of(const Posture& posture, const std::vector<int>& rods,
                                           const std::vector<double>& fractions) {
    if (rods.size() != fractions.size()) throw std::invalid_argument("a point has a rod and a fraction");
    std::vector<limb::MaterialPoint> points;
    for (std::size_t p = 0; p < rods.size(); ++p) {
        if (rods[p] < 0 || rods[p] >= static_cast<int>(posture.scene.rods.size())) throw py::index_error("no such rod");
        if (!(fractions[p] >= 0.0 && fractions[p] <= 1.0))
            throw std::invalid_argument("a fraction must be within 0 and 1");
        points.push_back({rods[p], fractions[p]});
    }
    return points;
}

/// (6, actuators), from what `by_rods` makes of the slopes of the rods.
template <class ByRods>
Array tip_by_pressures(const sweep::Members& members, const double* pressures, py::ssize_t count,
                       const std::string& model, const std::string& valve, ByRods&& by_rods) {
    if (count == 0) throw std::runtime_error("a Jacobian to pressures needs a posture that was solved from pressures");
    if (count != members.actuators()) throw std::invalid_argument("one pressure an actuator is needed");
    const std::vector<Vector6> moves = by_rods(members.slopes_at(pressures, section_model(model), valve_of(valve)));
    Array jacobian({6, members.actuators()});
    auto out = jacobian.mutable_unchecked<2>();
    int column = 0;
    for (const int rod : members.driven()) {
        for (int k = 0; k < 6; ++k) out(k, column) = moves[rod](k);
        ++column;
    }
    return jacobian;
}

}  // namespace

void bind_derivatives(py::module_& m) {
    py::class_<Parameters, std::shared_ptr<Parameters>>(
        m, "Parameters",
        "Numbers of a limb and its loads for derivatives: kind, place, layer, number, twin, direction, column and\n"
        "factor each.")
        .def(py::init(&make_parameters), py::arg("parameters"), py::arg("columns"));
    m.def("law_coefficients", &materials::coefficient_names, py::arg("law"), "Names of all coefficients of a law.");
    m.def(
        "rest_length_slopes",
        [](const Posture& posture, const Parameters& parameters, const Made& made) {
            const auto all = rates(posture, parameters, made);
            Array out({static_cast<py::ssize_t>(posture.scene.rods.size()), static_cast<py::ssize_t>(all.size())});
            std::fill_n(out.mutable_data(), out.size(), 0.0);
            auto to = out.mutable_unchecked<2>();
            for (std::size_t n = 0; n < all.size(); ++n)
                for (const auto& [rod, rate] : all[n].rods) to(rod, static_cast<py::ssize_t>(n)) = rate.rest_length;
            return out;
        },
        py::arg("posture"), py::arg("parameters"), py::arg("made"), "Rest lengths by parameters, (rods, columns).");
    m.def("potential_energy", &limb::potential_energy, py::arg("posture"),
          "Of rods and loads [J]; RuntimeError where the loads have no potential.");
    m.def(
        "potential_energy_slopes",
        [](const Posture& posture, const Parameters& parameters, const Made& made) {
            const std::vector<double> slopes = limb::potential_energy_slopes(posture, rates(posture, parameters, made));
            return Array(static_cast<py::ssize_t>(slopes.size()), slopes.data());
        },
        py::arg("posture"), py::arg("parameters"), py::arg("made"), "Its derivatives, (columns,).");
    py::class_<Derivatives, std::shared_ptr<Derivatives>>(
        m, "Derivatives", "A posture, linearised. `made` is (members, pressures, section model, valve).")
        .def("compliance", [](const Derivatives& d) { return matrix_array(d.compliance()); })
        .def(
            "tip_by_pressures",
            [](Derivatives& d, const Made& made) {
                const auto& [members, pressures, model, valve] = made;
                return tip_by_pressures(*members, pressures.data(), pressures.size(), model, valve,
                                        [&](const auto& slopes) { return d.tip_by_rods(slopes); });
            },
            py::arg("made"), "Tip (dp, dtheta) by each pressure, (6, actuators).")
        .def("plate_stiffness", [](const Derivatives& d) { return matrix_array(d.plate_stiffness()); })
        .def(
            "forward",
            [](const Derivatives& d, const Parameters& parameters, const Made& made, const std::vector<int>& rods,
               const std::vector<double>& fractions) {
                return matrix_array(
                    d.forward(rates(d.posture(), parameters, made), points_of(d.posture(), rods, fractions)));
            },
            py::arg("parameters"), py::arg("made"), py::arg("rods"), py::arg("fractions"),
            "(dp, dtheta) of all plates, then positions of points on rods, by each column.")
        .def(
            "adjoint",
            [](const Derivatives& d, const Array& weights, const Parameters& parameters, const Made& made,
               const std::vector<int>& rods, const std::vector<double>& fractions) {
                if (weights.ndim() != 2) throw std::invalid_argument("weights must be a matrix");
                const Eigen::MatrixXd w =
                    Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>(
                        weights.data(), weights.shape(0), weights.shape(1));
                return matrix_array(
                    d.adjoint(w, rates(d.posture(), parameters, made), points_of(d.posture(), rods, fractions)));
            },
            py::arg("weights"), py::arg("parameters"), py::arg("made"), py::arg("rods"), py::arg("fractions"),
            "Rows of weights times what `forward` gives, without forming it.");
    m.def(
        "tip_by_pressures",
        [](const Posture& posture, const std::shared_ptr<sweep::Members>& members, const std::string& model,
           const std::string& valve, const std::optional<Array>& pressures) {
            const std::vector<double>& own = posture.pressures;
            return tip_by_pressures(*members, pressures ? pressures->data() : own.data(),
                                    pressures ? pressures->size() : static_cast<py::ssize_t>(own.size()), model, valve,
                                    [&](const auto& slopes) { return limb::tip_by_rods(posture, slopes); });
        },
        py::arg("followed"), py::arg("members"), py::arg("section"), py::arg("valve"), py::arg("pressures"),
        "Tip (dp, dtheta) by each pressure, (6, actuators), of a posture that was followed: by the linearisation "
        "that its solve ended with. At its own pressures where none are given; RuntimeError where it has none.");
    m.def(
        "linearised",
        [](const std::shared_ptr<Posture>& posture, double tolerance) {
            return std::make_shared<Derivatives>(posture, tolerance);
        },
        py::arg("posture"), py::arg("tolerance"), "RuntimeError at a fold.");
}

}  // namespace softlimb::bindings
