#pragma once
// A proportional three-way valve: command -1..1 to opening; positive feeds from the supply, negative exhausts.
#include <cstddef>
#include <vector>

namespace softlimb::control {

struct ValveParameters {
    double feed_conductance;     // ISO 6358 C of the way in, fully open [m^3/(s Pa)]
    double exhaust_conductance;  // and of the way out
    double critical_ratio;       // b of both
    double time_constant;        // of the spool [s]
    double dead_time;            // [s]
    double dead_band;            // share of the stroke to each side that opens nothing
    double hysteresis;           // width of the play between command and spool, in strokes of one side
};

/// Command -> limits -> dead time -> play -> first order -> dead band. The spool follows its differential equation
/// exactly while the command stands.
class Valve {
public:
    Valve(const ValveParameters& parameters, double step);

    /// One step with this command; the opening at its end, -1..1.
    double advance(double command);
    double opening() const;

    bool stuck = false;  // the spool stays where it is

private:
    ValveParameters parameters_;
    double share_;  // of the way to its target that the spool goes in a step
    std::vector<double> waiting_;
    std::size_t next_ = 0;
    double played_ = 0.0, spool_ = 0.0;
};

}  // namespace softlimb::control
