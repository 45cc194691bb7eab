#pragma once
// Pump and reservoir, and for each chamber a valve, a line and the chamber: the air that pressure control moves.
// MECHANICS, "Control". Gauge pressures here; gas.hpp has absolute ones.
#include <cstdint>
#include <vector>

#include "softlimb/control/gas.hpp"
#include "softlimb/control/sensor.hpp"
#include "softlimb/control/valve.hpp"
#include "softlimb/control/volume_table.hpp"

namespace softlimb::control {

struct SupplyParameters {
    double volume;    // of the reservoir [m^3]
    double pressure;  // where the pump stops [Pa]
    double flow;      // of the pump, mass [kg/s]
    double band;      // below its stop the pump slows down over so much [Pa]
};

struct LineParameters {
    double length, diameter;  // [m]
};

struct ChannelParameters {
    ValveParameters valve;
    LineParameters line;
    double dump_conductance;  // of the normally open valve that vents the line when the loop gives up [m^3/(s Pa)]
    VolumeTable volume;
    SensorParameters sensor;
};

/// Where the air went since the start [kg]; stored = at_start + pumped - lost to rounding.
struct AirLedger {
    double at_start, stored, pumped, lost, drawn;  // drawn: from the reservoir into the lines
};

class Plant {
public:
    /// All chambers at the atmosphere, the reservoir at its pressure. `period` is one step of the controllers [s],
    /// taken in `substeps` implicit steps. Raises std::invalid_argument for numbers out of range.
    Plant(const Gas& gas, const SupplyParameters& supply, const std::vector<ChannelParameters>& channels, double period,
          int substeps, std::uint64_t seed);

    /// One period under these commands (-1..1, one a channel; any other number counts as the nearest limit, NaN as -1).
    /// False where the implicit step did not converge: the state is then that of its last iterate.
    bool advance(const double* commands);

    /// Readings of all sensors, NaN where one is broken.
    void read(double* readings);
    double read_supply();

    std::size_t size() const { return channels_.size(); }
    double period() const { return period_; }
    double pressure(std::size_t i) const { return channels_[i].chamber_pressure - gas_.atmosphere; }
    double line_pressure(std::size_t i) const { return channels_[i].line_pressure - gas_.atmosphere; }
    double opening(std::size_t i) const { return channels_[i].valve.opening(); }
    double volume(std::size_t i) const;
    double supply_pressure() const { return supply_pressure_ - gas_.atmosphere; }
    bool beyond_table(std::size_t i) const { return channels_[i].beyond_table; }
    AirLedger ledger() const;
    /// Largest difference of a mass from what its pressure says, relative.
    double mass_defect() const;

    // Disturbances and faults; they stay until changed.
    void set_leak(std::size_t i, double conductance) { channels_[i].leak = conductance; }
    /// Chamber volume over what the table says: a load that squeezes or stretches the chamber.
    void set_volume_scale(std::size_t i, double scale) { channels_[i].volume_scale = scale; }
    void set_valve_stuck(std::size_t i, bool stuck) { channels_[i].valve.stuck = stuck; }
    void set_sensor(std::size_t i, SensorFault fault, double bias);
    /// Share of the pump's flow that is left, and an orifice from the reservoir to the atmosphere.
    void set_supply(double pump_share, double leak);
    /// Cuts the supply off and opens every line to the atmosphere, or ends that.
    void set_dumped(bool dumped) { dumped_ = dumped; }

private:
    struct Channel {
        Valve valve;
        Sensor sensor;
        VolumeTable table;
        double feed, exhaust, critical_ratio, dump;  // of the orifices
        double line_volume, line_factor;
        double line_mass, chamber_mass, line_pressure, chamber_pressure;
        double volume_scale = 1.0, leak = 0.0;
        bool beyond_table = false;
    };
    struct Exchange {
        double fed = 0.0, lost = 0.0;  // in one sub-step [kg]
    };

    VolumeTable::Value chamber_volume(const Channel& channel, double pressure) const;
    bool exchange(Channel& channel, double opening, double step, Exchange& exchange) const;
    bool refill(double step, double drawn);

    Gas gas_;
    SupplyParameters supply_;
    std::vector<Channel> channels_;
    Sensor supply_sensor_;
    double period_, substep_;
    int substeps_;
    double supply_mass_, supply_pressure_, pump_share_ = 1.0, supply_leak_ = 0.0;
    double at_start_ = 0.0, pumped_ = 0.0, lost_ = 0.0, drawn_ = 0.0;
    bool dumped_ = false;
};

}  // namespace softlimb::control
