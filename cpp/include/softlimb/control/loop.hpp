#pragma once
// The inner loop: readings -> controllers -> guards -> valves, once a period, against the plant.
#include <cstdint>
#include <variant>
#include <vector>

#include "softlimb/control/guard.hpp"
#include "softlimb/control/neural_pid.hpp"
#include "softlimb/control/pid.hpp"
#include "softlimb/control/plant.hpp"

namespace softlimb::control {

using Controller = std::variant<Pid<double>, NeuralPid<double>>;

/// One row a step, one column a channel.
struct Trace {
    std::vector<double> pressures, readings, commands, openings;  // (N, A)
    std::vector<double> weights;                                  // (N, A, 3)
    std::vector<double> supply;                                   // (N,)
    std::vector<double> seconds;                                  // that controllers and guards took (N,); if asked for
    bool solved = true;                                           // every implicit step of the plant converged
};

class PressureLoop {
public:
    /// One controller a channel of the plant; guards may be left out (none), else one set of options for all, but for
    /// the limits of the command: each guard has those of its controller.
    PressureLoop(Plant plant, std::vector<Controller> controllers, const GuardOptions<double>* guards);

    /// Runs `steps` periods; `targets` holds a row of gauge pressures for each.
    Trace run(const double* targets, std::size_t steps, bool timed);

    /// Ends control: exhaust commands and dump valves, until the loop is thrown away.
    void vent();

    bool vented() const { return vented_; }
    std::size_t steps() const { return steps_; }
    const std::vector<Fault>& faults() const { return faults_; }
    const std::vector<std::int64_t>& fault_steps() const { return fault_steps_; }  // -1: none

    Plant plant;

private:
    void decide(const double* targets);

    std::vector<Controller> controllers_;
    std::vector<Guard<double>> guards_;
    std::vector<Fault> faults_;
    std::vector<std::int64_t> fault_steps_;
    std::vector<double> readings_, commands_;
    std::size_t steps_ = 0;
    bool vented_ = false;
};

}  // namespace softlimb::control
