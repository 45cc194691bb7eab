#include "softlimb/control/loop.hpp"

#include <algorithm>
#include <chrono>

#include "softlimb/arguments.hpp"

namespace softlimb::control {

PressureLoop::PressureLoop(Plant given, std::vector<Controller> controllers, const GuardOptions<double>* guards)
    : plant(std::move(given)), controllers_(std::move(controllers)) {
    const std::size_t n = plant.size();
    if (controllers_.size() != n) reject("number of controllers", controllers_.size(), "one a channel of the plant");
    if (guards != nullptr) {
        for (const Controller& controller : controllers_) {
            GuardOptions<double> own = *guards;
            std::visit([&](const auto& c) { own.low = c.common().low, own.high = c.common().high; }, controller);
            guards_.emplace_back(own);
        }
    }
    faults_.assign(n, Fault::none);
    fault_steps_.assign(n, -1);
    readings_.resize(n);
    commands_.resize(n);
}

Trace PressureLoop::run(const double* targets, std::size_t steps, bool timed) {
    const std::size_t n = plant.size();
    Trace trace;
    for (auto* rows : {&trace.pressures, &trace.readings, &trace.commands, &trace.openings}) rows->resize(steps * n);
    trace.weights.resize(steps * n * 3);
    trace.supply.resize(steps);
    if (timed) trace.seconds.resize(steps);
    for (std::size_t k = 0; k < steps; ++k, ++steps_) {
        plant.read(readings_.data());
        if (timed) {
            const auto start = std::chrono::steady_clock::now();
            decide(targets + k * n);
            trace.seconds[k] = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
        } else {
            decide(targets + k * n);
        }
        trace.solved = plant.advance(commands_.data()) && trace.solved;
        for (std::size_t i = 0; i < n; ++i) {
            trace.pressures[k * n + i] = plant.pressure(i);
            trace.openings[k * n + i] = plant.opening(i);
            const double* weights = std::visit([](const auto& c) { return c.weights(); }, controllers_[i]);
            std::copy_n(weights, 3, trace.weights.data() + 3 * (k * n + i));
        }
        std::copy(readings_.begin(), readings_.end(), trace.readings.begin() + k * n);
        std::copy(commands_.begin(), commands_.end(), trace.commands.begin() + k * n);
        trace.supply[k] = plant.supply_pressure();
    }
    return trace;
}

void PressureLoop::decide(const double* targets) {
    const std::size_t n = controllers_.size();
    const double supply = plant.read_supply();
    for (std::size_t i = 0; i < n && !vented_; ++i) {
        commands_[i] = std::visit([&](auto& c) { return c.step(targets[i], readings_[i]); }, controllers_[i]);
        if (guards_.empty()) continue;
        const Fault fault = guards_[i].step(targets[i], readings_[i], commands_[i], supply);
        if (fault == Fault::none) continue;
        faults_[i] = fault;
        fault_steps_[i] = static_cast<std::int64_t>(steps_);
        vent();
    }
    if (vented_) std::fill(commands_.begin(), commands_.end(), -1.0);
}

void PressureLoop::vent() {
    vented_ = true;
    plant.set_dumped(true);
}

}  // namespace softlimb::control
