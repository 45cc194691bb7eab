#pragma once
// PID whose three weights a single neuron adapts, Zhang et al. eq 11-12; MECHANICS, "Control".
#include "softlimb/control/pid.hpp"

namespace softlimb {
namespace control {

/// How far the weights go at each step. `gradient`: w_i += eta_i e x_i s, as printed. `normalised`: the same over
/// epsilon + s^2 |x|^2, so that one eta suits large and small errors.
enum class Learning : uint8_t { gradient, normalised };

/// Where s = d(measured)/d(command) comes from: one, the last two steps, or the caller.
enum class Slope : uint8_t { one, secant, given };

template <class Real>
struct NeuralOptions {
    Learning learning = Learning::gradient;
    Slope slope = Slope::one;
    Real rates[3] = {Real(0), Real(0), Real(0)};  // eta_i
    Real lowest[3] = {Real(0), Real(0), Real(0)};
    Real highest[3] = {Real(1e3), Real(1e3), Real(1e3)};
    Real epsilon = Real(1e-3);                       // keeps the normalised rule finite where all inputs vanish
    Real slope_limits[2] = {Real(0.01), Real(100)};  // of the secant: noise must turn neither its sign nor its size
    Real smallest_move = Real(1e-3);                 // of the command, for a secant to be read

    constexpr bool valid() const {
        bool fine = is_finite(epsilon) && epsilon > Real(0) && is_finite(slope_limits[0]) &&
                    is_finite(slope_limits[1]) && slope_limits[0] <= slope_limits[1] && is_finite(smallest_move) &&
                    smallest_move > Real(0);
        for (int i = 0; i < 3; ++i)
            fine = fine && is_finite(rates[i]) && rates[i] >= Real(0) && is_finite(lowest[i]) &&
                   is_finite(highest[i]) && lowest[i] <= highest[i];
        return fine;
    }
};

/// The command of a step comes from the weights before it; then the weights learn. Outside its limits a command does
/// not move what is measured, so s is zero there and nothing is learned, unless anti-windup is `none` (as printed).
template <class Real>
class NeuralPid {
public:
    constexpr NeuralPid(const Common<Real>& common, const Real (&weights)[3], const NeuralOptions<Real>& options)
        : common_(common), options_(options) {
        for (int i = 0; i < 3; ++i) start_[i] = weights_[i] = within(weights[i], options.lowest[i], options.highest[i]);
    }

    /// As `Pid::step`. `slope` counts where the options say `given`, in units of scale over command.
    constexpr Real step(Real target, Real measured, Real slope = Real(1)) {
        if (!inputs_.update(common_, target, measured)) return command_;
        const Real* x = inputs_.x();
        const Real wanted = weights_[0] * x[0] + weights_[1] * x[1] + weights_[2] * x[2];
        if (!is_finite(wanted)) return command_;
        const Real s = slope_at(measured / common_.scale, slope);
        const Real x0 = x[0], x1 = x[1], x2 = x[2];  // before the limit changes the sum
        previous_command_ = command_;
        command_ = inputs_.limited(common_, wanted, weights_[1]);
        if (!inputs_.saturated() || common_.anti_windup == AntiWindup::none) learn(x0, x1, x2, s);
        return command_;
    }

    /// Back to the first weights and no memory.
    constexpr void reset() {
        inputs_.reset();
        for (int i = 0; i < 3; ++i) weights_[i] = start_[i];
        command_ = previous_command_ = Real(0);
        measured_before_ = Real(0);
        secant_ = Real(1);
        seen_ = false;
    }

    constexpr const Common<Real>& common() const { return common_; }
    constexpr const Real* weights() const { return weights_; }
    constexpr const Inputs<Real>& inputs() const { return inputs_; }

private:
    /// The secant pairs the last change of the measurement with the change of the command just before it.
    constexpr Real slope_at(Real measured, Real given) {
        if (options_.slope == Slope::one) return Real(1);
        if (options_.slope == Slope::given) return is_finite(given) ? given : Real(0);
        const Real move = command_ - previous_command_;
        if (seen_ && magnitude(move) >= options_.smallest_move)
            secant_ = within((measured - measured_before_) / move, options_.slope_limits[0], options_.slope_limits[1]);
        measured_before_ = measured;
        seen_ = true;
        return secant_;
    }

    constexpr void learn(Real x0, Real x1, Real x2, Real s) {
        const Real x[3] = {x0, x1, x2};
        Real size = Real(1);
        if (options_.learning == Learning::normalised) size = options_.epsilon + s * s * (x0 * x0 + x1 * x1 + x2 * x2);
        for (int i = 0; i < 3; ++i) {
            const Real next = weights_[i] + options_.rates[i] * x0 * x[i] * s / size;
            if (is_finite(next)) weights_[i] = within(next, options_.lowest[i], options_.highest[i]);
        }
    }

    Common<Real> common_;
    NeuralOptions<Real> options_;
    Real start_[3] = {};
    Real weights_[3] = {};
    Inputs<Real> inputs_;
    Real command_ = Real(0);
    Real previous_command_ = Real(0);
    Real measured_before_ = Real(0);
    Real secant_ = Real(1);
    bool seen_ = false;
};

}  // namespace control
}  // namespace softlimb
