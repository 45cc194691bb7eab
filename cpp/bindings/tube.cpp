#include "softlimb/actuator/tube.hpp"

#include <pybind11/numpy.h>
#include <pybind11/stl.h>
#include <pybind11/typing.h>

#include <algorithm>
#include <cstring>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "bindings.hpp"
#include "given.hpp"
#include "named.hpp"
#include "softlimb/actuator/thread.hpp"
#include "softlimb/arguments.hpp"

namespace py = pybind11;

namespace softlimb::bindings {
namespace {

using namespace actuator;
using Numbers = py::array_t<double, py::array::c_style | py::array::forcecast>;
using Families = std::vector<Fibres>;

/// States of one call, in the order of the arguments.
struct TubeStates {
    std::vector<TubeState> states;

    bool operator==(const TubeStates& other) const {
        const auto same = [](const TubeState& x, const TubeState& y) {
            return x.stretch == y.stretch && x.inner_radius == y.inner_radius && x.twist_rate == y.twist_rate &&
                   x.pressure == y.pressure && x.axial_force == y.axial_force && x.torque == y.torque &&
                   x.status == y.status && x.flags == y.flags && x.model == y.model;
        };
        return std::equal(states.begin(), states.end(), other.states.begin(), other.states.end(), same);
    }
};

static_assert(std::is_trivially_copyable_v<TubeState>, "states are pickled as bytes");

Ends ends_of(const std::string& name) {
    return named<Ends>("ends", name, {{"free", Ends::free}, {"bonded", Ends::bonded}});
}

void require_size(std::string_view name, py::ssize_t size, py::ssize_t expected) {
    if (size != expected) {
        std::ostringstream text;
        text << name << " has " << size << " values but " << expected << " were expected";
        throw std::invalid_argument(text.str());
    }
}

/// Calls `solve(i)` for each i without the interpreter lock, Ctrl-C checked between blocks.
template <class Solve>
TubeStates solve_all(py::ssize_t count, Solve&& solve) {
    TubeStates all;
    all.states.resize(count);
    constexpr py::ssize_t block = 4096;
    for (py::ssize_t from = 0; from < count; from += block) {
        const py::ssize_t to = std::min(count, from + block);
        {
            py::gil_scoped_release release;
            for (py::ssize_t i = from; i < to; ++i) all.states[i] = solve(i);
        }
        if (PyErr_CheckSignals() != 0) throw py::error_already_set();
    }
    return all;
}

template <class Field>
void define_field(py::class_<TubeStates>& type, const char* name, Field TubeState::* field) {
    type.def_property_readonly(name, [field](const TubeStates& all) {
        py::array_t<Field> values(static_cast<py::ssize_t>(all.states.size()));
        Field* to = values.mutable_data();
        for (std::size_t i = 0; i < all.states.size(); ++i) to[i] = all.states[i].*field;
        return values;
    });
}

std::string text_of(const Fibres& f) {
    std::ostringstream text;
    text.precision(12);
    text << "Fibres(angle=" << f.angle;
    if (f.modulus > 0.0)
        text << ", modulus=" << f.modulus << ", fraction=" << f.fraction << ")";
    else
        text << ", stiffness=" << f.stiffness << ")";
    return text.str();
}

std::string text_of(const Layer& layer) {
    std::ostringstream text;
    text.precision(12);
    text << "Layer(" << layer.inner << ", " << layer.outer << ", " << py::repr(py::cast(layer.law)).cast<std::string>();
    if (!layer.fibres.empty()) {
        text << ", fibres=[";
        for (std::size_t i = 0; i < layer.fibres.size(); ++i) text << (i ? ", " : "") << text_of(layer.fibres[i]);
        text << "]";
    }
    text << ")";
    return text.str();
}

using Number = Given<double>;
using OptionalNumber = std::optional<Given<double>>;

Fibres fibres_of(const Number& given_angle, const OptionalNumber& given_stiffness, const OptionalNumber& given_modulus,
                 const OptionalNumber& given_fraction) {
    const double angle = taken("fibre angle", given_angle);
    const std::optional<double> stiffness = taken("fibre stiffness", given_stiffness);
    const std::optional<double> modulus = taken("fibre modulus", given_modulus);
    const std::optional<double> fraction = taken("fibre fraction", given_fraction);
    if (stiffness && (modulus || fraction))
        throw std::invalid_argument("fibres take either stiffness, or modulus and fraction, not both");
    if (stiffness) return Fibres::with_stiffness(angle, *stiffness);
    if (!modulus || !fraction)
        throw std::invalid_argument("fibres need either stiffness, or both modulus and fraction");
    return Fibres::with_fraction(angle, *modulus, *fraction);
}

State state_of(const Fibres& f) { return py::make_tuple(f.angle, f.stiffness, f.modulus, f.fraction); }

Fibres fibres_from(const State& t) {
    const auto number = [&](int i) { return py::object(t[i]).cast<double>(); };
    return {number(0), number(1), number(2), number(3)};
}

void bind_fibres(py::module_& m) {
    py::class_<Fibres>(m, "Fibres", R"(One family of parallel fibres, spread evenly over its layer.

Its energy per volume of the layer is ``k (stretch - 1)^2 / 2``. Source: MECHANICS, "Actuator".

Parameters
----------
angle : float
    From the circumferential direction, within [-pi/2, pi/2] [rad].
stiffness : float, optional
    k itself [Pa]; the silicone is then left whole.
modulus, fraction : float, optional
    Modulus of the thread [Pa] and its share of the layer's volume: ``k = modulus * fraction``, and the silicone
    counts ``1 - sum of fractions``.

Raises
------
ValueError
    An angle beyond a right angle, a negative stiffness, a fraction outside [0, 1], or both ways at once.)")
        .def(py::init(&fibres_of), py::kw_only(), py::arg("angle"), py::arg("stiffness") = py::none(),
             py::arg("modulus") = py::none(), py::arg("fraction") = py::none())
        .def_static(
            "pair",
            [](const Number& angle, const OptionalNumber& stiffness, const OptionalNumber& modulus,
               const OptionalNumber& fraction) {
                const Fibres family = fibres_of(angle, stiffness, modulus, fraction);
                Fibres mirrored = family;
                mirrored.angle = -family.angle;
                return Families{family, mirrored};
            },
            py::kw_only(), py::arg("angle"), py::arg("stiffness") = py::none(), py::arg("modulus") = py::none(),
            py::arg("fraction") = py::none(),
            "Two families at ``+angle`` and ``-angle``; stiffness or fraction are those of each family.")
        .def_readonly("angle", &Fibres::angle, "From the circumferential direction [rad].")
        .def_readonly("stiffness", &Fibres::stiffness, "k [Pa].")
        .def_property_readonly(
            "modulus", [](const Fibres& f) { return f.modulus > 0.0 ? std::optional(f.modulus) : std::nullopt; },
            "Modulus of the thread [Pa]; None when the stiffness was given.")
        .def_readonly("fraction", &Fibres::fraction, "Share of the layer's volume; 0 leaves the silicone whole.")
        .def("__eq__", &equals<Fibres>, py::arg("other"))
        .def("__hash__", [](const Fibres& f) { return py::hash(state_of(f)); })
        .def("__repr__", [](const Fibres& f) { return text_of(f); })
        .def(py::pickle([](const Fibres& f) { return state_of(f); }, &fibres_from));
}

void bind_layer(py::module_& m) {
    py::class_<Layer>(m, "Layer", R"(One layer of a tube.

Parameters
----------
inner, outer : float
    Undeformed radii [m].
law : NeoHookean, Yeoh, MooneyRivlin, Ogden or Gent
    Material law of the silicone.
fibres : Fibres or sequence of Fibres, optional
    Families in this layer.

Raises
------
ValueError
    Radii that are not positive or out of order, or fractions that leave no silicone.)")
        .def(py::init([](const Number& inner, const Number& outer, const Given<materials::AnyLaw>& law,
                         const Given<std::variant<Families, Fibres>>& fibres) {
                 const auto families = taken("fibres of a layer", fibres, "Fibres or a sequence of Fibres");
                 const Fibres* one = std::get_if<Fibres>(&families);
                 return Layer::make(taken("inner radius of a layer", inner), taken("outer radius of a layer", outer),
                                    taken("law of a layer", law, "a material law such as Yeoh"),
                                    one ? Families{*one} : std::get<Families>(families));
             }),
             py::arg("inner"), py::arg("outer"), py::arg("law"), py::arg("fibres") = Families{})
        .def_readonly("inner", &Layer::inner, "Undeformed inner radius [m].")
        .def_readonly("outer", &Layer::outer, "Undeformed outer radius [m].")
        .def_readonly("law", &Layer::law, "Material law of the silicone.")
        .def_readonly("fibres", &Layer::fibres, "Fibre families (a new list).")
        .def_property_readonly("silicone_fraction", &Layer::silicone_fraction, "1 - sum of the fibre fractions.")
        .def("__eq__", &equals<Layer>, py::arg("other"))
        .def("__hash__", [](const Layer& a) { return py::hash(py::make_tuple(a.inner, a.outer, py::cast(a.law))); })
        .def("__repr__", [](const Layer& layer) { return text_of(layer); })
        .def(py::pickle([](const Layer& a) -> State { return py::make_tuple(a.inner, a.outer, a.law, a.fibres); },
                        [](const State& t) {
                            return Layer{py::object(t[0]).cast<double>(), py::object(t[1]).cast<double>(),
                                         py::object(t[2]).cast<materials::AnyLaw>(), py::object(t[3]).cast<Families>()};
                        }));
}

void bind_states(py::module_& m) {
    py::class_<TubeStates> type(m, "TubeStates", "States of a tube, one a solve; arrays in the order of the solves.");
    define_field(type, "stretch", &TubeState::stretch);
    define_field(type, "inner_radius", &TubeState::inner_radius);
    define_field(type, "twist_rate", &TubeState::twist_rate);
    define_field(type, "pressure", &TubeState::pressure);
    define_field(type, "axial_force", &TubeState::axial_force);
    define_field(type, "torque", &TubeState::torque);
    define_field(type, "smallest_eigenvalue", &TubeState::smallest_eigenvalue);
    define_field(type, "limit_pressure", &TubeState::limit_pressure);
    define_field(type, "success", &TubeState::success);
    define_field(type, "stable", &TubeState::stable);
    define_field(type, "iterations", &TubeState::iterations);
    define_field(type, "flags", &TubeState::flags);
    type.def("__len__", [](const TubeStates& all) { return all.states.size(); })
        .def(
            "status",
            [](const TubeStates& all, std::size_t i) { return std::string(solve::name_of(all.states.at(i).status)); },
            py::arg("index"))
        .def(
            "model",
            [](const TubeStates& all, std::size_t i) {
                return all.states.at(i).model == TubeModel::thick ? "thick" : "paper_reduced";
            },
            py::arg("index"))
        .def(
            "one", [](const TubeStates& all, std::size_t i) { return TubeStates{{all.states.at(i)}}; },
            py::arg("index"))
        .def("__eq__", &equals<TubeStates>, py::arg("other"))
        .def("__hash__",
             [](const TubeStates& all) {
                 return py::hash(py::make_tuple(all.states.size(), all.states.empty() ? 0.0 : all.states[0].stretch));
             })
        .def(py::pickle(
            [](const TubeStates& all) {
                return py::bytes(reinterpret_cast<const char*>(all.states.data()),
                                 all.states.size() * sizeof(TubeState));
            },
            [](const py::bytes& data) {
                const std::string_view bytes(data);
                if (bytes.size() % sizeof(TubeState) != 0) throw std::invalid_argument("not the states of a tube");
                TubeStates all;
                all.states.resize(bytes.size() / sizeof(TubeState));
                std::memcpy(static_cast<void*>(all.states.data()), bytes.data(), bytes.size());
                return all;
            }));
}

py::dict section_fields(const SectionAtPressure& at) {
    py::dict fields;
    fields["rest_length"] = at.rest_length;
    fields["section"] = at.section;
    fields["d_rest_length"] = at.d_rest_length;
    fields["d_section"] = at.d_section;
    fields["status"] = std::string(solve::name_of(at.status));
    return fields;
}

}  // namespace

void bind_tube(py::module_& m) {
    bind_fibres(m);
    bind_layer(m);
    bind_states(m);
    py::class_<ThreadGeometry>(m, "ThreadGeometry", "Angle and volume fraction of a wound thread, for one family.")
        .def_readonly("angle", &ThreadGeometry::angle, "From the circumferential direction [rad].")
        .def_readonly("fraction", &ThreadGeometry::fraction, "Thread over layer, by volume.");
    m.def("thread_geometry", &thread_geometry, py::kw_only(), py::arg("inner"), py::arg("outer"),
          py::arg("thread_diameter"), py::arg("pitch"), py::arg("angle") = py::none(),
          R"(Thread wound in a helix at the inner radius of a layer.

Parameters
----------
inner, outer : float
    Radii of the layer [m].
thread_diameter : float
    [m].
pitch : float
    Axial distance between turns of one family [m].
angle : float, optional
    From the circumferential direction [rad]. Default: that of the pitch, ``tan(angle) = pitch / (2 pi inner)``.

Returns
-------
ThreadGeometry

Raises
------
ValueError
    A length is not positive, the turns overlap, or the angle is outside (0, pi/2).)");
    py::class_<Tube, std::shared_ptr<Tube>>(m, "Tube", "A fibre-reinforced tube; see softlimb.Tube.")
        .def(py::init([](double length, std::vector<Layer> layers, bool tension_only, const std::string& ends,
                         std::optional<double> mass, double cap_length) {
                 TubeOptions options{tension_only, ends_of(ends), mass, cap_length};
                 return Tube(length, std::move(layers), options);
             }),
             py::kw_only(), py::arg("length"), py::arg("layers"), py::arg("tension_only") = false,
             py::arg("ends") = "free", py::arg("mass") = py::none(), py::arg("cap_length") = 0.0)
        .def_property_readonly("length", &Tube::length, "Length at zero pressure [m].")
        .def_property_readonly("layers", &Tube::layers, "Layers from inside out (a new list).")
        .def_property_readonly(
            "tension_only", [](const Tube& t) { return t.options().tension_only; },
            "True when fibres carry no compression.")
        .def_property_readonly(
            "ends", [](const Tube& t) { return t.options().ends == Ends::free ? "free" : "bonded"; },
            "``free``, or ``bonded``: twist blocked.")
        .def_property_readonly(
            "cap_length", [](const Tube& t) { return t.options().cap_length; },
            "Length at each end that a rigid cap keeps at rest [m].")
        .def_property_readonly("mass", &Tube::mass, "[kg]")
        .def_property_readonly(
            "inner_radius", [](const Tube& t) { return t.inner_radius(); }, "Undeformed inner radius [m].")
        .def_property_readonly(
            "outer_radius", [](const Tube& t) { return t.outer_radius(); }, "Undeformed outer radius [m].")
        .def_property_readonly(
            "limit_pressure",
            [](const Tube& t) { return t.has_limit() ? std::optional(t.limit_pressure()) : std::nullopt; },
            "Pressure at which the unloaded tube balloons or else loses stability [Pa]; None when there is none in "
            "reach (stretches to 4).")
        .def_property_readonly("locking_share", &Tube::locking_share,
                               "Share of the work of a first small pressure that two-way fibres smeared over a layer "
                               "spend against each other. Above 0.1 a state says that they lock.")
        .def(
            "_inflate",
            [](const Tube& tube, const Numbers& pressure, const Numbers& force, const Numbers& torque, bool reduced) {
                require_size("axial_force", force.size(), pressure.size());
                require_size("torque", torque.size(), pressure.size());
                const double *p = pressure.data(), *f = force.data(), *t = torque.data();
                return solve_all(pressure.size(), [&](py::ssize_t i) {
                    return reduced ? tube.paper_reduced(p[i]) : tube.inflate(p[i], f[i], t[i]);
                });
            },
            py::arg("pressure"), py::arg("axial_force"), py::arg("torque"), py::arg("reduced"))
        .def(
            "_at_volume",
            [](const Tube& tube, const Numbers& volume, bool radius, double force, double torque) {
                const double* v = volume.data();
                return solve_all(volume.size(), [&](py::ssize_t i) {
                    return radius ? tube.at_inner_radius(v[i], force, torque) : tube.at_volume(v[i], force, torque);
                });
            },
            py::arg("value"), py::arg("is_radius"), py::arg("axial_force"), py::arg("torque"))
        .def(
            "_at_stretch",
            [](const Tube& tube, const Numbers& stretch) {
                const double* l = stretch.data();
                return solve_all(stretch.size(), [&](py::ssize_t i) { return tube.at_stretch(l[i]); });
            },
            py::arg("stretch"))
        .def("_other_pressures", &Tube::pressures_at_stretch, py::arg("stretch"))
        .def(
            "_message",
            [](const Tube& tube, const TubeStates& s, std::size_t i) { return tube.message(s.states.at(i)); },
            py::arg("states"), py::arg("index"))
        .def(
            "_remarks",
            [](const Tube& tube, const TubeStates& s, std::size_t i) { return tube.remarks(s.states.at(i)); },
            py::arg("states"), py::arg("index"))
        .def(
            "_outer_radius",
            [](const Tube& tube, const TubeStates& s) {
                py::array_t<double> values(static_cast<py::ssize_t>(s.states.size()));
                double* to = values.mutable_data();
                for (std::size_t i = 0; i < s.states.size(); ++i) to[i] = tube.outer_radius(s.states[i]);
                return values;
            },
            py::arg("states"))
        .def(
            "_stress",
            [](const Tube& tube, const TubeStates& s, const Numbers& radius, bool reference) {
                const TubeState& state = s.states.at(0);
                py::array_t<double> values({py::ssize_t(6), radius.size()});
                auto to = values.mutable_unchecked<2>();
                for (py::ssize_t i = 0; i < radius.size(); ++i) {
                    const double r = radius.data()[i];
                    const WallStress at = reference ? tube.stress_at_reference(state, r) : tube.stress(state, r);
                    to(0, i) = at.radius, to(1, i) = at.reference_radius, to(2, i) = at.radial;
                    to(3, i) = at.hoop, to(4, i) = at.axial, to(5, i) = at.shear;
                }
                return values;
            },
            py::arg("states"), py::arg("radius"), py::arg("is_reference"))
        .def(
            "_fibres",
            [](const Tube& tube, const TubeStates& s) {
                std::vector<std::tuple<int, double, double, double, double, double>> all;
                for (const FibreState& f : tube.fibres(s.states.at(0)))
                    all.emplace_back(f.layer, f.angle, f.stretch_inside, f.stretch_outside, f.tension, f.taut_fraction);
                return all;
            },
            py::arg("states"))
        .def(
            "_section",
            [](const Tube& tube, double pressure, const std::string& model, const std::string& valve,
               bool derivative) -> py::typing::Dict<py::str, py::object> {
                return section_fields(tube.section(pressure, section_model(model), valve_of(valve), derivative));
            },
            py::arg("pressure"), py::arg("model"), py::arg("valve"), py::arg("derivative"))
        .def(
            "_section_slope",
            [](const Tube& tube, double pressure, const std::string& model, const std::string& valve,
               const std::string& parameter, int layer, int number, int twin) {
                std::vector<SectionSlope> slopes;
                tube.section_slopes(pressure, section_model(model), valve_of(valve),
                                    {{tube_parameter(parameter), layer, number, twin}}, slopes);
                return std::pair{slopes[0].rest_length, slopes[0].section};
            },
            py::arg("pressure"), py::arg("model"), py::arg("valve"), py::arg("parameter"), py::arg("layer"),
            py::arg("number"), py::arg("twin"),
            "Derivative of rest length and section to one number of the tube.")
        .def(
            "_energy",
            [](const Tube& tube, double stretch, double volume, double twist) {
                const auto e = tube.wall().energy(Shape<double>{stretch, volume, twist});
                return std::vector<double>{e.value, e.g_l,  e.g_w,  e.g_t,  e.h_ll,
                                           e.h_lw,  e.h_lt, e.h_ww, e.h_wt, e.h_tt};
            },
            py::arg("stretch"), py::arg("volume"), py::arg("twist"),
            "Scaled wall energy with gradient (l, w, t) and Hessian (ll, lw, lt, ww, wt, tt) [Pa], for tests.")
        .def("__eq__", &equals<Tube>, py::arg("other"))
        .def("__hash__", [](const Tube& a) {
            return py::hash(py::make_tuple(a.length(), a.mass(), py::tuple(py::cast(a.layers()))));
        });
    m.def(
        "axial_strain",
        [](const Section& section, double force) {
            double strain, compliance;
            axial_strain(section.axial_law, force, strain, compliance);
            return std::pair{strain, compliance};
        },
        py::arg("section"), py::arg("force"),
        "Strain v3 - 1 and its derivative to the force [1/N] of a section's axial law at a force [N], without end "
        "moment.");
    m.def(
        "axial_strain_slope",
        [](const Section& section, const Section& slope, double force) {
            double strain, compliance;
            axial_strain_rate(section.axial_law, slope.axial_law, force, strain, compliance);
            return strain;
        },
        py::arg("section"), py::arg("slope"), py::arg("force"),
        "Derivative of the strain v3 - 1 at a force [N] to what the section has this derivative to.");
}

}  // namespace softlimb::bindings
