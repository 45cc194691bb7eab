#include <pybind11/stl.h>

#include <array>
#include <tuple>

#include "arrays.hpp"
#include "bindings.hpp"
#include "named.hpp"
#include "softlimb/control/loop.hpp"

namespace py = pybind11;

namespace softlimb::bindings {
namespace {

using namespace control;
using Three = std::array<double, 3>;
using Two = std::array<double, 2>;

Common<double> common(double period, double scale, const Two& limits, const std::string& sign,
                      const std::string& anti_windup, double tracking_time, double filter_time) {
    const Common<double> made{
        period,
        scale,
        limits[0],
        limits[1],
        named<ErrorSign>("sign", sign, {{"descending", ErrorSign::descending}, {"printed", ErrorSign::printed}}),
        named<AntiWindup>("anti_windup", anti_windup,
                          {{"none", AntiWindup::none},
                           {"conditional", AntiWindup::conditional},
                           {"back_calculation", AntiWindup::back_calculation}}),
        tracking_time,
        filter_time};
    if (!made.valid()) throw std::invalid_argument("period, scale, limits or times of a controller are out of range");
    return made;
}

NeuralOptions<double> neural(const std::string& learning, const std::string& slope, const Three& rates,
                             const Three& lowest, const Three& highest, double epsilon, const Two& slope_limits,
                             double smallest_move) {
    NeuralOptions<double> made;
    made.learning =
        named<Learning>("learning", learning, {{"gradient", Learning::gradient}, {"normalised", Learning::normalised}});
    made.slope =
        named<Slope>("slope", slope, {{"one", Slope::one}, {"secant", Slope::secant}, {"given", Slope::given}});
    for (int i = 0; i < 3; ++i) {
        made.rates[i] = rates[i];
        made.lowest[i] = lowest[i];
        made.highest[i] = highest[i];
    }
    made.epsilon = epsilon;
    for (int i = 0; i < 2; ++i) made.slope_limits[i] = slope_limits[i];
    made.smallest_move = smallest_move;
    if (!made.valid()) throw std::invalid_argument("rates, bounds or slope limits of a neural PID are out of range");
    return made;
}

Three three(const double* x) { return {x[0], x[1], x[2]}; }

struct Weights {
    explicit Weights(const Three& given) {
        for (int i = 0; i < 3; ++i) {
            require_finite("weight", given[i]);
            values[i] = given[i];
        }
    }
    double values[3];
};

using ValveNumbers = std::array<double, 7>;
using SensorNumbers = std::tuple<double, double, double, double, int>;
using ChannelNumbers = std::tuple<ValveNumbers, Two, double, std::vector<double>, std::vector<double>, SensorNumbers>;

Plant make_plant(const std::array<double, 5>& gas, const std::array<double, 4>& supply,
                 const std::vector<ChannelNumbers>& channels, double period, int substeps, std::uint64_t seed) {
    std::vector<ChannelParameters> made;
    for (const auto& [valve, line, dump, pressures, volumes, sensor] : channels) {
        const auto& [low, high, noise, offset, bits] = sensor;
        made.push_back({{valve[0], valve[1], valve[2], valve[3], valve[4], valve[5], valve[6]},
                        {line[0], line[1]},
                        dump,
                        VolumeTable(pressures, volumes),
                        {low, high, noise, offset, bits}});
    }
    return Plant({gas[0], gas[1], gas[2], gas[3], gas[4]}, {supply[0], supply[1], supply[2], supply[3]}, made, period,
                 substeps, seed);
}

std::size_t channel_of(const Plant& plant, std::size_t i) {
    if (i >= plant.size())
        throw std::out_of_range("channel " + std::to_string(i) + " of " + std::to_string(plant.size()));
    return i;
}

template <class Get>
Array each(const Plant& plant, Get get) {
    Array out(static_cast<py::ssize_t>(plant.size()));
    for (std::size_t i = 0; i < plant.size(); ++i) out.mutable_at(static_cast<py::ssize_t>(i)) = get(i);
    return out;
}

Array shaped(const std::vector<double>& values, std::vector<py::ssize_t> shape) {
    Array out(std::move(shape));
    std::copy(values.begin(), values.end(), out.mutable_data());
    return out;
}

const char* name_of(Fault fault) {
    switch (fault) {
        case Fault::none:
            return "none";
        case Fault::sensor_not_finite:
            return "sensor_not_finite";
        case Fault::sensor_stuck:
            return "sensor_stuck";
        case Fault::over_pressure:
            return "over_pressure";
        case Fault::no_response:
            return "no_response";
        case Fault::wrong_way:
            return "wrong_way";
        case Fault::supply_lost:
            return "supply_lost";
    }
    return "none";
}

// In the order of the fields of GuardOptions and of `softlimb.control.Guard`; limits are the controllers'.
using GuardNumbers =
    std::tuple<int, double, int, double, double, double, double, int, double, double, double, double, int, double, int>;

PressureLoop make_loop(const Plant& plant, const py::typing::List<py::object>& controllers,
                       const std::optional<GuardNumbers>& guards) {
    std::vector<Controller> made;
    for (const py::handle controller : controllers) {
        if (py::isinstance<Pid<double>>(controller))
            made.emplace_back(controller.cast<const Pid<double>&>());
        else
            made.emplace_back(controller.cast<const NeuralPid<double>&>());
    }
    if (!guards) return PressureLoop(plant, std::move(made), nullptr);
    const auto options = std::apply([](auto... numbers) { return GuardOptions<double>{numbers...}; }, *guards);
    if (!options.valid()) throw std::invalid_argument("options of a guard are out of range");
    return PressureLoop(plant, std::move(made), &options);
}

py::typing::Dict<py::str, py::object> run(PressureLoop& loop, const Array& targets, bool timed) {
    const auto n = static_cast<py::ssize_t>(loop.plant.size());
    if (targets.ndim() != 2 || targets.shape(1) != n)
        throw std::invalid_argument("targets must have a row a step and a column for each of " + std::to_string(n) +
                                    " channels");
    const py::ssize_t steps = targets.shape(0);
    Trace trace;
    {
        py::gil_scoped_release unlocked;
        trace = loop.run(targets.data(), static_cast<std::size_t>(steps), timed);
    }
    py::dict out;
    out["pressures"] = shaped(trace.pressures, {steps, n});
    out["readings"] = shaped(trace.readings, {steps, n});
    out["commands"] = shaped(trace.commands, {steps, n});
    out["openings"] = shaped(trace.openings, {steps, n});
    out["weights"] = shaped(trace.weights, {steps, n, 3});
    out["supply"] = shaped(trace.supply, {steps});
    if (timed) out["seconds"] = shaped(trace.seconds, {steps});
    out["solved"] = trace.solved;
    return out;
}

}  // namespace

void bind_control(py::module_& m) {
    const auto common_arguments = [](auto& cls, auto make, auto... more) {
        cls.def(py::init(make), py::kw_only(), py::arg("weights"), py::arg("period"), py::arg("scale"),
                py::arg("limits"), py::arg("sign"), py::arg("anti_windup"), py::arg("tracking_time"),
                py::arg("filter_time"), more...);
    };
    py::class_<Pid<double>> pid(m, "Pid", "The PID of softlimb/control/pid.hpp; see `softlimb.control.PID`.");
    common_arguments(pid, [](const Three& weights, double period, double scale, const Two& limits,
                             const std::string& sign, const std::string& anti_windup, double tracking, double filter) {
        return Pid<double>(common(period, scale, limits, sign, anti_windup, tracking, filter), Weights(weights).values);
    });
    pid.def("step", &Pid<double>::step, py::arg("target"), py::arg("measured"), "The next command.")
        .def("reset", &Pid<double>::reset, "Forgets what was seen.")
        .def_property_readonly(
            "weights", [](const Pid<double>& c) { return three(c.weights()); }, "w1, w2, w3.")
        .def_property_readonly(
            "inputs", [](const Pid<double>& c) { return three(c.inputs().x()); }, "x1, x2, x3 of the last step.");

    py::class_<NeuralPid<double>> neural_pid(
        m, "NeuralPid", "The neural PID of softlimb/control/neural_pid.hpp; see `softlimb.control.NeuralPID`.");
    common_arguments(
        neural_pid,
        [](const Three& weights, double period, double scale, const Two& limits, const std::string& sign,
           const std::string& anti_windup, double tracking, double filter, const std::string& learning,
           const std::string& slope, const Three& rates, const Three& lowest, const Three& highest, double epsilon,
           const Two& slope_limits, double smallest_move) {
            return NeuralPid<double>(
                common(period, scale, limits, sign, anti_windup, tracking, filter), Weights(weights).values,
                neural(learning, slope, rates, lowest, highest, epsilon, slope_limits, smallest_move));
        },
        py::arg("learning"), py::arg("slope"), py::arg("rates"), py::arg("lowest"), py::arg("highest"),
        py::arg("epsilon"), py::arg("slope_limits"), py::arg("smallest_move"));
    neural_pid
        .def("step", &NeuralPid<double>::step, py::arg("target"), py::arg("measured"), py::arg("slope") = 1.0,
             "The next command; then the weights learn.")
        .def("reset", &NeuralPid<double>::reset, "Back to the first weights, and forgets what was seen.")
        .def_property_readonly(
            "weights", [](const NeuralPid<double>& c) { return three(c.weights()); }, "w1, w2, w3 as learned.")
        .def_property_readonly(
            "inputs", [](const NeuralPid<double>& c) { return three(c.inputs().x()); }, "x1, x2, x3 of the last step.");

    py::class_<Plant>(m, "Plant", "Pump, reservoir, valves, lines and chambers; see `softlimb.control.Pneumatics`.")
        .def(py::init(&make_plant), py::kw_only(), py::arg("gas"), py::arg("supply"), py::arg("channels"),
             py::arg("period"), py::arg("substeps"), py::arg("seed"))
        .def("__copy__", [](const Plant& plant) { return Plant(plant); })
        .def(
            "advance",
            [](Plant& plant, const Array& commands) {
                if (commands.ndim() != 1 || static_cast<std::size_t>(commands.size()) != plant.size())
                    throw std::invalid_argument("commands must be one number a channel");
                return plant.advance(commands.data());
            },
            py::arg("commands"), "One period under these commands; False where the implicit step did not converge.")
        .def(
            "read",
            [](Plant& plant) {
                Array out(static_cast<py::ssize_t>(plant.size()));
                plant.read(out.mutable_data());
                return out;
            },
            "Readings of the sensors [Pa], shape (A,).")
        .def_property_readonly("period", &Plant::period, "Of a step [s].")
        .def_property_readonly(
            "pressures", [](const Plant& p) { return each(p, [&](auto i) { return p.pressure(i); }); },
            "Gauge pressures of the chambers [Pa], shape (A,).")
        .def_property_readonly(
            "line_pressures", [](const Plant& p) { return each(p, [&](auto i) { return p.line_pressure(i); }); },
            "Gauge pressures of the lines [Pa], shape (A,).")
        .def_property_readonly(
            "openings", [](const Plant& p) { return each(p, [&](auto i) { return p.opening(i); }); },
            "Openings of the valves, -1 to 1, shape (A,).")
        .def_property_readonly(
            "volumes", [](const Plant& p) { return each(p, [&](auto i) { return p.volume(i); }); },
            "Volumes of the chambers [m^3], shape (A,).")
        .def_property_readonly(
            "beyond_table",
            [](const Plant& p) {
                std::vector<bool> out;
                for (std::size_t i = 0; i < p.size(); ++i) out.push_back(p.beyond_table(i));
                return out;
            },
            "Which chambers were ever above the last pressure of their volume table.")
        .def_property_readonly("supply_pressure", &Plant::supply_pressure, "Gauge pressure of the reservoir [Pa].")
        .def_property_readonly("mass_defect", &Plant::mass_defect,
                               "Largest relative difference of a mass from what its pressure says.")
        .def_property_readonly(
            "ledger",
            [](const Plant& p) {
                const AirLedger a = p.ledger();
                return std::map<std::string, double>{{"at_start", a.at_start},
                                                     {"stored", a.stored},
                                                     {"pumped", a.pumped},
                                                     {"lost", a.lost},
                                                     {"drawn", a.drawn}};
            },
            "Air at the start, stored now, pumped in, lost to the atmosphere, drawn by the lines [kg].")
        .def(
            "set_leak",
            [](Plant& p, std::size_t i, double conductance) {
                require_not_negative("conductance of a leak", conductance);
                p.set_leak(channel_of(p, i), conductance);
            },
            py::arg("channel"), py::arg("conductance"), "Orifice from a chamber to the atmosphere [m^3/(s Pa)].")
        .def(
            "set_volume_scale",
            [](Plant& p, std::size_t i, double scale) {
                require_positive("volume scale", scale);
                p.set_volume_scale(channel_of(p, i), scale);
            },
            py::arg("channel"), py::arg("scale"), "Chamber volume over what its table says.")
        .def(
            "set_valve_stuck", [](Plant& p, std::size_t i, bool stuck) { p.set_valve_stuck(channel_of(p, i), stuck); },
            py::arg("channel"), py::arg("stuck"), "The spool stays where it is.")
        .def(
            "set_sensor",
            [](Plant& p, std::size_t i, const std::string& fault, double bias) {
                require_finite("bias", bias);
                p.set_sensor(channel_of(p, i),
                             named<SensorFault>("fault", fault,
                                                {{"none", SensorFault::none},
                                                 {"not_finite", SensorFault::not_finite},
                                                 {"stuck", SensorFault::stuck}}),
                             bias);
            },
            py::arg("channel"), py::kw_only(), py::arg("fault") = "none", py::arg("bias") = 0.0,
            "A sensor without reading, or that repeats its last one; a bias [Pa].")
        .def(
            "set_supply",
            [](Plant& p, double pump_share, double leak) {
                require_not_negative("pump share", pump_share);
                require_not_negative("leak of the reservoir", leak);
                p.set_supply(pump_share, leak);
            },
            py::kw_only(), py::arg("pump_share") = 1.0, py::arg("leak") = 0.0,
            "Share of the pump's flow that is left, and an orifice from the reservoir [m^3/(s Pa)].")
        .def("set_dumped", &Plant::set_dumped, py::arg("dumped"),
             "Cuts the supply off and opens every line to the atmosphere, or ends that.");

    py::class_<PressureLoop>(m, "PressureLoop", "Controllers and guards against a plant, which it keeps a copy of.")
        .def(py::init(&make_loop), py::arg("plant"), py::arg("controllers"), py::arg("guards"))
        .def_property_readonly(
            "plant", [](PressureLoop& loop) -> Plant& { return loop.plant; },
            py::return_value_policy::reference_internal, "The plant, to disturb and to look at.")
        .def("run", &run, py::arg("targets"), py::kw_only(), py::arg("timed") = false,
             "One period a row of targets (N, A) [Pa]; arrays by name.")
        .def("vent", &PressureLoop::vent, "Ends control: exhaust commands and dump valves.")
        .def_property_readonly("vented", &PressureLoop::vented, "Control has ended.")
        .def_property_readonly("steps", &PressureLoop::steps, "Periods run so far.")
        .def_property_readonly(
            "faults",
            [](const PressureLoop& loop) {
                std::vector<std::tuple<std::size_t, std::string, std::int64_t>> out;
                for (std::size_t i = 0; i < loop.faults().size(); ++i)
                    if (loop.faults()[i] != Fault::none)
                        out.emplace_back(i, name_of(loop.faults()[i]), loop.fault_steps()[i]);
                return out;
            },
            "Channel, name and step of what ended control.");
    m.def(
        "orifice_flow",
        [](double conductance, double critical_ratio, double first, double second) {
            const Flow flow = orifice(conductance, critical_ratio, first, second);
            return py::typing::Tuple<double, double, double>(py::make_tuple(flow.rate, flow.d_first, flow.d_second));
        },
        py::arg("conductance"), py::arg("critical_ratio"), py::arg("first"), py::arg("second"),
        "ISO 6358: mass flow [kg/s] between absolute pressures [Pa], and its derivatives to both.");
}

}  // namespace softlimb::bindings
