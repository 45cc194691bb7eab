#include "softlimb/control/plant.hpp"

#include <algorithm>
#include <cmath>

#include "softlimb/arguments.hpp"

namespace softlimb::control {
namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr int kIterations = 60;
// Of the mass in a volume. What is left stays in the books (the mass is the state) and is worked off in the next step.
constexpr double kTolerance = 1e-12;
// A reservoir whose pressure stands still during a sub-step may lose no more of its air in it.
constexpr double kLargestDraw = 0.02;

void require(const Gas& gas) {
    if (!(gas.exponent >= 1.0 && gas.exponent <= 1.4)) reject("exponent of the gas", gas.exponent, "within [1, 1.4]");
    require_positive("atmosphere", gas.atmosphere);
    require_positive("temperature", gas.temperature);
    require_positive("gas constant", gas.constant);
    require_positive("viscosity", gas.viscosity);
}

void require(const ChannelParameters& c) {
    require_positive("feed conductance", c.valve.feed_conductance);
    require_positive("exhaust conductance", c.valve.exhaust_conductance);
    if (!(c.valve.critical_ratio >= 0.0 && c.valve.critical_ratio < kLaminarRatio))
        reject("critical pressure ratio", c.valve.critical_ratio, "within [0, 0.999)");
    require_not_negative("time constant of the valve", c.valve.time_constant);
    if (!(c.valve.dead_time >= 0.0 && c.valve.dead_time <= 1.0))
        reject("dead time", c.valve.dead_time, "within [0, 1] s");
    if (!(c.valve.dead_band >= 0.0 && c.valve.dead_band < 1.0)) reject("dead band", c.valve.dead_band, "within [0, 1)");
    if (!(c.valve.hysteresis >= 0.0 && c.valve.hysteresis < 2.0))
        reject("hysteresis", c.valve.hysteresis, "within [0, 2)");
    require_positive("line length", c.line.length);
    require_positive("line diameter", c.line.diameter);
    require_not_negative("dump conductance", c.dump_conductance);
    require_finite("low end of the sensor", c.sensor.low);
    require_finite("high end of the sensor", c.sensor.high);
    if (!(c.sensor.high > c.sensor.low)) reject("high end of the sensor", c.sensor.high, "above its low end");
    require_not_negative("noise of the sensor", c.sensor.noise);
    require_finite("offset of the sensor", c.sensor.offset);
    if (c.sensor.bits < 0 || c.sensor.bits > 24) reject("bits of the converter", c.sensor.bits, "within [0, 24]");
}

}  // namespace

Plant::Plant(const Gas& gas, const SupplyParameters& supply, const std::vector<ChannelParameters>& channels,
             double period, int substeps, std::uint64_t seed)
    : gas_(gas),
      supply_(supply),
      // A supply's sensor is read for one threshold only: its own range, no noise.
      supply_sensor_({0.0, 1e6, 0.0, 0.0, 0}, seed),
      period_(period),
      substeps_(substeps) {
    require(gas);
    require_positive("volume of the reservoir", supply.volume);
    require_positive("supply pressure", supply.pressure);
    require_not_negative("flow of the pump", supply.flow);
    require_positive("band of the pump", supply.band);
    require_positive("period", period);
    if (substeps < 1) reject("substeps", substeps, "at least 1");
    if (channels.empty()) reject("channels", 0, "at least one");
    substep_ = period / substeps;

    const double atmosphere = gas.atmosphere;
    double feed = 0.0;
    for (std::size_t i = 0; i < channels.size(); ++i) {
        const ChannelParameters& c = channels[i];
        require(c);
        const double d = c.line.diameter, area = 0.25 * kPi * d * d;
        const double factor =
            kPi * d * d * d * d / (256.0 * gas.viscosity * c.line.length * gas.constant * gas.temperature);
        channels_.push_back({Valve(c.valve, substep_), Sensor(c.sensor, seed + 1 + i), c.volume,
                             c.valve.feed_conductance, c.valve.exhaust_conductance, c.valve.critical_ratio,
                             c.dump_conductance, area * c.line.length, factor, 0.0, 0.0, atmosphere, atmosphere});
        Channel& made = channels_.back();
        made.line_mass = gas.density_at_atmosphere() * made.line_volume;
        made.chamber_mass = gas.density_at_atmosphere() * chamber_volume(made, atmosphere).volume;
        feed += c.valve.feed_conductance;
    }
    supply_pressure_ = supply.pressure + atmosphere;
    supply_mass_ = supply.volume * gas.density(supply_pressure_);
    const double draw = substep_ * feed * kReferenceDensity * supply_pressure_ / supply_mass_;
    if (draw > kLargestDraw)
        reject("share of the reservoir's air that open valves draw in a sub-step", draw,
               "at most 0.02: take a larger reservoir or more substeps");
    at_start_ = ledger().stored;
}

bool Plant::advance(const double* commands) {
    bool solved = true;
    for (int k = 0; k < substeps_; ++k) {
        Exchange all;
        for (std::size_t i = 0; i < channels_.size(); ++i) {
            Channel& channel = channels_[i];
            Exchange one;
            solved = exchange(channel, channel.valve.advance(commands[i]), substep_, one) && solved;
            all.fed += one.fed;
            all.lost += one.lost;
            const double gauge = channel.chamber_pressure - gas_.atmosphere;
            channel.beyond_table = channel.beyond_table || gauge > channel.table.highest();
        }
        lost_ += all.lost;
        drawn_ += all.fed;
        solved = refill(substep_, all.fed) && solved;
    }
    return solved;
}

/// Backward Euler for the masses of line and chamber, the reservoir's pressure as it stands:
///     M_l(p_l) = m_l + h (feed - line - out),   M_c(p_c) = m_c + h (line - leak)
/// Both left sides rise with their pressure and every flow falls with the pressure that it runs to, so there is one
/// answer, and Newton with its step halved finds it.
bool Plant::exchange(Channel& c, double opening, double step, Exchange& out) const {
    const double atmosphere = gas_.atmosphere;
    const double feeding = dumped_ ? 0.0 : c.feed * std::max(opening, 0.0),
                 exhausting = c.exhaust * std::max(-opening, 0.0);
    struct At {
        Flow feed, line, exhaust, dump, leak;
        double residual[2], jacobian[2][2], size;
    };
    const auto at = [&](double p_line, double p_chamber) {
        At a;
        a.feed = orifice(feeding, c.critical_ratio, supply_pressure_, p_line);
        a.exhaust = orifice(exhausting, c.critical_ratio, p_line, atmosphere);
        a.dump = dumped_ ? orifice(c.dump, c.critical_ratio, p_line, atmosphere) : Flow{};
        a.line = laminar(c.line_factor, p_line, p_chamber);
        a.leak = c.leak > 0.0 ? orifice(c.leak, c.critical_ratio, p_chamber, atmosphere) : Flow{};
        const double line_density = gas_.density(p_line), density = gas_.density(p_chamber);
        const VolumeTable::Value v = chamber_volume(c, p_chamber);
        a.residual[0] = line_density * c.line_volume - c.line_mass -
                        step * (a.feed.rate - a.line.rate - a.exhaust.rate - a.dump.rate);
        a.residual[1] = density * v.volume - c.chamber_mass - step * (a.line.rate - a.leak.rate);
        a.jacobian[0][0] = gas_.density_slope(p_line, line_density) * c.line_volume -
                           step * (a.feed.d_second - a.line.d_first - a.exhaust.d_first - a.dump.d_first);
        a.jacobian[0][1] = step * a.line.d_second;
        a.jacobian[1][0] = -step * a.line.d_first;
        a.jacobian[1][1] = gas_.density_slope(p_chamber, density) * v.volume + density * v.slope -
                           step * (a.line.d_second - a.leak.d_first);
        a.size = std::abs(a.residual[0]) + std::abs(a.residual[1]);
        return a;
    };

    double p_line = c.line_pressure, p_chamber = c.chamber_pressure;
    At now = at(p_line, p_chamber);
    const double allowed = kTolerance * (c.line_mass + c.chamber_mass);
    bool solved = now.size <= allowed;
    for (int k = 0; k < kIterations && !solved; ++k) {
        const auto& j = now.jacobian;
        const double determinant = j[0][0] * j[1][1] - j[0][1] * j[1][0];
        const double d_line = -(now.residual[0] * j[1][1] - now.residual[1] * j[0][1]) / determinant;
        const double d_chamber = -(now.residual[1] * j[0][0] - now.residual[0] * j[1][0]) / determinant;
        double share = 1.0;
        At next = now;
        for (int halving = 0; halving < 30; ++halving, share *= 0.5) {
            const double line = p_line + share * d_line, chamber = p_chamber + share * d_chamber;
            if (line <= 0.1 * p_line || chamber <= 0.1 * p_chamber) continue;  // densities need positive pressures
            next = at(line, chamber);
            if (next.size < now.size || share < 1e-6) break;
        }
        const bool better = next.size < now.size;
        if (!better) break;
        p_line += share * d_line;
        p_chamber += share * d_chamber;
        now = next;
        solved = now.size <= allowed;
    }
    // Rounding of the residual itself may stand above the tolerance: as good as it gets, and a thousandth of what a
    // step may be wrong by.
    solved = solved || now.size <= 1e3 * allowed;

    // The masses follow from the flows, what leaves one enters the other: nothing is made or lost but by rounding.
    const double fed = step * now.feed.rate, along = step * now.line.rate;
    const double left = step * (now.exhaust.rate + now.dump.rate), leaked = step * now.leak.rate;
    c.line_mass += fed - along - left;
    c.chamber_mass += along - leaked;
    c.line_pressure = p_line;
    c.chamber_pressure = p_chamber;
    out = {fed, left + leaked};
    return solved;
}

/// Backward Euler for the reservoir, after what the lines drew: pump and leak at its pressure at the end of the step.
bool Plant::refill(double step, double drawn) {
    supply_mass_ -= drawn;
    const double stop = supply_.pressure + gas_.atmosphere;
    const double full = pump_share_ * supply_.flow;
    double p = supply_pressure_, pumped = 0.0, leaked = 0.0, residual = 0.0;
    const double allowed = kTolerance * supply_mass_;
    for (int k = 0; k < kIterations; ++k) {
        const double share = (stop - p) / supply_.band;
        const double pump = full * std::clamp(share, 0.0, 1.0);
        const double pump_slope = share > 0.0 && share < 1.0 ? -full / supply_.band : 0.0;
        const Flow leak = supply_leak_ > 0.0 ? orifice(supply_leak_, 0.5, p, gas_.atmosphere) : Flow{};
        const double density = gas_.density(p);
        pumped = step * pump;
        leaked = step * leak.rate;
        residual = density * supply_.volume - supply_mass_ - pumped + leaked;
        if (std::abs(residual) <= allowed) break;
        const double slope = gas_.density_slope(p, density) * supply_.volume - step * (pump_slope - leak.d_first);
        p = std::max(p - residual / slope, 0.1 * p);
    }
    supply_pressure_ = p;
    supply_mass_ += pumped - leaked;
    pumped_ += pumped;
    lost_ += leaked;
    return std::abs(residual) <= 1e3 * allowed;
}

VolumeTable::Value Plant::chamber_volume(const Channel& channel, double pressure) const {
    const VolumeTable::Value value = channel.table.at(pressure - gas_.atmosphere);
    return {channel.volume_scale * value.volume, channel.volume_scale * value.slope};
}

double Plant::volume(std::size_t i) const { return chamber_volume(channels_[i], channels_[i].chamber_pressure).volume; }

void Plant::read(double* readings) {
    for (std::size_t i = 0; i < channels_.size(); ++i) readings[i] = channels_[i].sensor.read(pressure(i));
}

double Plant::read_supply() { return supply_sensor_.read(supply_pressure()); }

AirLedger Plant::ledger() const {
    double stored = supply_mass_;
    for (const Channel& c : channels_) stored += c.line_mass + c.chamber_mass;
    return {at_start_, stored, pumped_, lost_, drawn_};
}

double Plant::mass_defect() const {
    double largest = std::abs(gas_.density(supply_pressure_) * supply_.volume / supply_mass_ - 1.0);
    for (const Channel& c : channels_) {
        const double line = gas_.density(c.line_pressure) * c.line_volume / c.line_mass;
        const double chamber = gas_.density(c.chamber_pressure) * chamber_volume(c, c.chamber_pressure).volume;
        largest = std::max({largest, std::abs(line - 1.0), std::abs(chamber / c.chamber_mass - 1.0)});
    }
    return largest;
}

void Plant::set_sensor(std::size_t i, SensorFault fault, double bias) {
    channels_[i].sensor.fault = fault;
    channels_[i].sensor.bias = bias;
}

void Plant::set_supply(double pump_share, double leak) {
    pump_share_ = pump_share;
    supply_leak_ = leak;
}

}  // namespace softlimb::control
