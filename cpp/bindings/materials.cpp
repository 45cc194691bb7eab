#include <pybind11/numpy.h>
#include <pybind11/stl.h>
#include <pybind11/typing.h>

#include <cmath>
#include <optional>
#include <sstream>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "bindings.hpp"
#include "given.hpp"
#include "softlimb/dual.hpp"
#include "softlimb/materials/laws.hpp"
#include "softlimb/materials/response.hpp"

namespace py = pybind11;

namespace softlimb::bindings {
namespace {

using namespace materials;
using Numbers = py::typing::Tuple<py::float_, py::ellipsis>;
using Six = std::tuple<double, double, double, double, double, double>;
using Four = std::tuple<double, double, double, double>;

// A coefficient crosses the border as a float, a list of coefficients as a sequence in and a tuple out.
template <class Value>
using Incoming = std::conditional_t<std::is_same_v<Value, Terms>, std::vector<double>, double>;

double incoming(std::string_view, double value) { return value; }
Terms incoming(std::string_view name, const std::vector<double>& values) { return Terms::from(name, values); }

py::float_ outgoing(double value) { return py::float_(value); }
Numbers outgoing(const Terms& terms) {
    py::tuple numbers(terms.count);
    for (int i = 0; i < terms.count; ++i) numbers[i] = terms[i];
    return numbers;
}

template <MaterialLaw L, std::size_t I>
constexpr auto parameter() {
    return std::get<I>(L::parameters());
}

template <MaterialLaw L>
constexpr std::size_t parameter_count = std::tuple_size_v<decltype(L::parameters())>;

template <MaterialLaw L, class Visitor>
void for_each_parameter(Visitor&& visit) {
    std::apply([&](const auto&... each) { (visit(each), ...); }, L::parameters());
}

template <MaterialLaw L>
std::string documentation() {
    std::string text = std::string(L::summary) + "\n\nParameters\n----------\n";
    for_each_parameter<L>([&]<class Value>(const materials::Parameter<L, Value>& p) {
        text += std::string(p.name) + (std::is_same_v<Value, Terms> ? " : sequence of float\n    " : " : float\n    ") +
                std::string(p.meaning) + "\n";
    });
    return text + R"(density : float
    Density [kg/m^3].
max_strain : float
    Largest nominal strain of the data behind the coefficients; 0 when not known. It judges results, it never
    changes them.

Raises
------
ValueError
    A value is not finite or breaks its rule, or the initial shear modulus )" +
           std::string(L::shear_modulus_formula) + R"( is not positive.

Notes
-----
Incompressible. Source: MECHANICS, "Material".)";
}

template <MaterialLaw L>
py::dict parameters_of(const L& law) {
    py::dict values;
    for_each_parameter<L>([&](const auto& p) { values[py::str(p.name)] = outgoing(law.*p.member); });
    return values;
}

template <MaterialLaw L>
State state_of(const L& law) {
    return py::make_tuple(py::tuple(parameters_of(law).attr("values")()), law.density, law.max_strain);
}

template <MaterialLaw L>
L law_of(const State& state) {
    L law;
    const py::tuple values = state[0];
    std::size_t i = 0;
    for_each_parameter<L>([&]<class Value>(const materials::Parameter<L, Value>& p) {
        law.*p.member = incoming(p.name, values[i++].template cast<Incoming<Value>>());
    });
    law.density = state[1].cast<double>(), law.max_strain = state[2].cast<double>();
    check(law);
    return law;
}

template <MaterialLaw L>
std::string text_of(const L& law) {
    std::string text = std::string(L::class_name) + "(";
    const auto add = [&](std::string_view name, const py::object& value) {
        text += std::string(name) + "=" + py::repr(value).cast<std::string>() + ", ";
    };
    for_each_parameter<L>([&]<class Value>(const materials::Parameter<L, Value>& p) {
        if (p.optional && law.*p.member == Value()) return;
        add(p.name, outgoing(law.*p.member));
    });
    add("density", outgoing(law.density));
    if (law.max_strain > 0.0) add("max_strain", outgoing(law.max_strain));
    return text.substr(0, text.size() - 2) + ")";
}

template <MaterialLaw L, std::size_t I>
auto argument() {
    constexpr auto p = parameter<L, I>();
    if constexpr (p.optional)
        return py::arg(p.name.data()) = 0.0;
    else
        return py::arg(p.name.data());
}

template <MaterialLaw L, std::size_t I>
using IncomingAt = Incoming<std::remove_cvref_t<decltype(std::declval<L>().*(parameter<L, I>().member))>>;

template <MaterialLaw L, std::size_t... I>
void define_constructor(py::class_<L>& type, std::index_sequence<I...>) {
    type.def(py::init([](const Given<IncomingAt<L, I>>&... values, const Given<double>& density,
                         const Given<double>& max_strain) {
                 L law;
                 ((law.*(parameter<L, I>().member) =
                       incoming(parameter<L, I>().name, taken(parameter<L, I>().name.data(), values))),
                  ...);
                 law.density = taken("density", density), law.max_strain = taken("max_strain", max_strain);
                 check(law);
                 return law;
             }),
             py::kw_only(), argument<L, I>()..., py::arg("density") = 1080.0, py::arg("max_strain") = 0.0);
}

// Scalar in, scalar out; array in, array of its shape out. A Python number takes the first overload; numpy's scalars
// take the second like arrays without axes.
template <MaterialLaw L, class Function>
void define_over_stretch(py::class_<L>& type, const char* name, const std::string& doc, Function function) {
    type.def(
        name,
        [function](const L& law, double stretch) {
            require_positive("stretch", stretch);
            return function(law, stretch);
        },
        py::arg("stretch").noconvert(), doc.c_str());
    type.def(
        name,
        [function](const L& law, const Given<py::array_t<double, py::array::c_style | py::array::forcecast>>& given) {
            const auto stretch = taken("stretch", given);
            py::array_t<double> out(std::vector<py::ssize_t>(stretch.shape(), stretch.shape() + stretch.ndim()));
            const double* from = stretch.data();
            double* to = out.mutable_data();
            for (py::ssize_t i = 0; i < stretch.size(); ++i) {
                if (!(std::isfinite(from[i]) && from[i] > 0.0))
                    reject("stretch (item " + std::to_string(i) + " in flat order)", from[i], "finite and positive");
                to[i] = function(law, from[i]);
            }
            if (out.ndim() > 0) return out;
            const py::object scalar = out[py::tuple()];
            return py::reinterpret_borrow<py::array_t<double>>(scalar);  // a float64, as numpy's own functions return
        },
        py::arg("stretch"), doc.c_str());
}

template <MaterialLaw L, Test test>
void define_test(py::class_<L>& type, const std::string& name, const std::string& what) {
    const std::string notes = R"(

Parameters
----------
stretch : float or array_like
    Stretch, positive.

Returns
-------
float or ndarray of the same shape
    [Pa]; NaN where the law has no value (Gent past its limit).

Raises
------
ValueError
    A stretch is not finite or not positive.)";
    define_over_stretch(type, (name + "_stress").c_str(), "Nominal stress in " + what + "." + notes,
                        [](const L& law, double stretch) { return response(law, test, stretch).stress; });
    define_over_stretch(type, (name + "_tangent").c_str(),
                        "Derivative of the nominal stress in the stretch, in " + what + "." + notes,
                        [](const L& law, double stretch) { return response(law, test, stretch).tangent; });
}

void require_state(double a, double t) {
    require_positive("a", a);
    require_finite("t", t);
    // Rounding of 2/sqrt(a) in the caller: a few units in the last place.
    if (t < 2.0 / std::sqrt(a) * (1.0 - 1e-14)) reject("t", t, "at least 2/sqrt(a), its value for equal stretches");
}

template <MaterialLaw L>
Six energy_derivatives(const L& law, const Given<double>& given_a, const Given<double>& given_t) {
    const double a = taken("a", given_a), t = taken("t", given_t);
    require_state(a, t);
    const auto e = law.derivatives(a, t);
    return {e.w, e.w_a, e.w_t, e.w_aa, e.w_at, e.w_tt};
}

template <MaterialLaw L>
Four third_derivatives(const L& law, const Given<double>& given_a, const Given<double>& given_t) {
    const double a = taken("a", given_a), t = taken("t", given_t);
    require_state(a, t);
    const auto e = law.derivatives(Dual<2>::variable(a, 0), Dual<2>::variable(t, 1));
    return {e.w_aa.slope[0], e.w_aa.slope[1], e.w_tt.slope[0], e.w_tt.slope[1]};
}

template <MaterialLaw L>
DruckerCheck drucker_over(const L& law, const std::optional<Given<double>>& given) {
    const std::optional<double> max_strain = taken("max_strain", given);
    const double range = max_strain.value_or(law.max_strain);
    if (!max_strain && range == 0.0)
        throw std::invalid_argument("max_strain must be given: this law does not know the range of its fit");
    require_positive("max_strain", range);
    return check_drucker(law, range);
}

template <MaterialLaw L>
void bind_law(py::module_& m) {
    py::class_<L> type(m, L::class_name.data(), documentation<L>().c_str());
    define_constructor(type, std::make_index_sequence<parameter_count<L>>{});
    for_each_parameter<L>([&](const auto& p) {
        const auto member = p.member;
        type.def_property_readonly(
            p.name.data(), [member](const L& law) { return outgoing(law.*member); }, std::string(p.meaning).c_str());
    });
    type.def_property_readonly_static(
            "name", [](const py::object&) { return std::string(L::name); },
            "Name of the law as `fit_uniaxial` and files spell it.")
        .def_readonly("density", &L::density, "Density [kg/m^3].")
        .def_readonly("max_strain", &L::max_strain, "Largest nominal strain of the fit range; 0 when not known.")
        .def_property_readonly("shear_modulus", &L::shear_modulus, "Initial shear modulus [Pa].")
        .def_property_readonly(
            "parameters", [](const L& law) -> py::typing::Dict<py::str, py::object> { return parameters_of(law); },
            "Coefficients by name (a new dict); lists of coefficients are tuples.");
    define_test<L, Test::uniaxial>(type, "uniaxial", "uniaxial tension or compression");
    define_test<L, Test::planar>(type, "planar", "planar tension (pure shear: one lateral direction held)");
    define_test<L, Test::equibiaxial>(type, "equibiaxial", "equibiaxial tension, in each of the two directions");
    type.def("energy_derivatives", &energy_derivatives<L>, py::arg("a"), py::arg("t"),
             R"(Energy density and its derivatives (w, w_a, w_t, w_aa, w_at, w_tt) [Pa].

Parameters
----------
a : float
    Squared stretch in one principal direction.
t : float
    Sum of the squared stretches in the other two, at least 2/sqrt(a).

Raises
------
ValueError
    `a` is not positive, or `t` too small to be a sum of real squares with product 1/a.)")
        .def("energy_third_derivatives", &third_derivatives<L>, py::arg("a"), py::arg("t"),
             "Third derivatives (w_aaa, w_aat, w_att, w_ttt) [Pa]; arguments as in `energy_derivatives`.")
        .def("check_drucker", &drucker_over<L>, py::arg("max_strain") = py::none(),
             R"(Is the law stable in Drucker's sense in tension, planar tension and equibiaxial tension?

Stable means that any further strain at constant volume costs work, d(stress) : d(strain) > 0.

Parameters
----------
max_strain : float, optional
    Nominal strains 0..max_strain are checked. Default: the law's own `max_strain`.

Returns
-------
DruckerCheck
    True in a condition when stable; says where stability is lost first otherwise.

Raises
------
ValueError
    `max_strain` is not positive, or not given and not known to the law.)")
        .def("__eq__",
             [](const L& law, const py::object& other) {
                 return py::isinstance<L>(other) && law == other.cast<const L&>();
             })
        .def("__hash__", [](const L& law) { return py::hash(py::make_tuple(L::name, state_of(law))); })
        .def("__repr__", &text_of<L>)
        .def(py::pickle(&state_of<L>, &law_of<L>));
}

const char* name_of(Test test) {
    return test == Test::uniaxial ? "uniaxial" : test == Test::planar ? "planar" : "equibiaxial";
}

std::string message_of(const DruckerCheck& check) {
    std::ostringstream text;
    text.precision(4);
    if (check.stable)
        text << "stable up to a nominal strain of " << check.max_strain;
    else
        text << "stability is lost at a nominal strain of " << check.strain << " in " << name_of(check.test)
             << " tension (checked up to " << check.max_strain << ")";
    return text.str();
}

void bind_drucker(py::module_& m) {
    py::class_<DruckerCheck>(m, "DruckerCheck", "Outcome of `check_drucker` of a law; true when stable.")
        .def_readonly("stable", &DruckerCheck::stable, "Stable over the whole range in all three tests.")
        .def_readonly("max_strain", &DruckerCheck::max_strain, "Largest nominal strain that was checked.")
        .def_readonly("margin", &DruckerCheck::margin,
                      "Smallest d(stress) : d(strain) over the value of the undeformed material: 1 there, not positive "
                      "where unstable, NaN where the law has no value.")
        .def_readonly("strain", &DruckerCheck::strain, "Nominal strain where stability is lost first; NaN if nowhere.")
        .def_property_readonly(
            "test",
            [](const DruckerCheck& check) -> std::optional<std::string> {
                if (check.stable) return std::nullopt;
                return name_of(check.test);
            },
            "Test in which it is lost first: uniaxial, planar or equibiaxial; None if nowhere.")
        .def_property_readonly("message", &message_of, "The outcome in words.")
        .def("__bool__", [](const DruckerCheck& check) { return check.stable; })
        .def("__repr__", [](const DruckerCheck& check) { return "DruckerCheck(" + message_of(check) + ")"; })
        .def(py::pickle(
            [](const DruckerCheck& c) -> State {
                return py::make_tuple(c.stable, c.max_strain, c.margin, static_cast<int>(c.test), c.strain);
            },
            [](const State& s) {
                return DruckerCheck{s[0].cast<bool>(), s[1].cast<double>(), s[2].cast<double>(),
                                    static_cast<Test>(s[3].cast<int>()), s[4].cast<double>()};
            }));
}

}  // namespace

void bind_materials(py::module_& m) {
    bind_drucker(m);
    Laws::for_each([&]<class L>() { bind_law<L>(m); });
    m.def(
        "law_class_names",
        [] {
            std::vector<std::string> names;
            Laws::for_each([&]<class L>() { names.emplace_back(L::class_name); });
            return names;
        },
        "Class names of the material laws, in the order of the list in laws.hpp.");
}

}  // namespace softlimb::bindings
