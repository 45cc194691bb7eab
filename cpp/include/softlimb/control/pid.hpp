#pragma once
// PID in the positional form that Zhang et al. print (eq 11), with what it lacks: limits, anti-windup, a filter.
#include <stdint.h>

#include "softlimb/control/scalar.hpp"

namespace softlimb {
namespace control {

/// Which difference the error is. `descending` is target - measured. `printed` is the paper's, measured - target: with
/// positive gains it feeds back positively (MECHANICS, "Control").
enum class ErrorSign : uint8_t { descending, printed };

/// What the sum of errors does while the command is at a limit: grow on (the paper), stand still while the error pushes
/// further out, or be drawn back by what the limit cuts off.
enum class AntiWindup : uint8_t { none, conditional, back_calculation };

/// What a controller and its inputs have in common.
template <class Real>
struct Common {
    Real period = Real(1e-3);  // of a step [s]
    Real scale = Real(1);      // errors are divided by it; 1e5 Pa makes weights numbers near one
    Real low = Real(-1);       // limits of the command
    Real high = Real(1);
    ErrorSign sign = ErrorSign::descending;
    AntiWindup anti_windup = AntiWindup::conditional;
    Real tracking_time = Real(0.1);  // of back calculation [s]
    Real filter_time = Real(0);      // of the difference of errors [s]; zero: none

    constexpr bool valid() const {
        return is_finite(period) && period > Real(0) && is_finite(scale) && scale > Real(0) && is_finite(low) &&
               is_finite(high) && low < high && is_finite(tracking_time) && tracking_time > Real(0) &&
               is_finite(filter_time) && filter_time >= Real(0);
    }
};

/// x1 = e, x2 = T sum e, x3 = e_k - e_(k-1) of the scaled error, and what limits and bad readings do to them.
template <class Real>
class Inputs {
public:
    /// False where target or measurement is no number: nothing changes then.
    constexpr bool update(const Common<Real>& c, Real target, Real measured) {
        const Real difference = (c.sign == ErrorSign::descending ? target - measured : measured - target) / c.scale;
        if (!is_finite(difference)) return false;
        const Real step = started_ ? difference - x_[0] : Real(0);
        // First order: the share of a jump that is seen after one period.
        filtered_ += (step - filtered_) * (c.period / (c.filter_time + c.period));
        before_ = x_[1];
        x_[0] = difference;
        x_[1] += c.period * difference;
        x_[2] = filtered_;
        started_ = true;
        return true;
    }

    /// The command within its limits; `wanted` is what the weights make of the inputs, `integral_weight` that of x2.
    constexpr Real limited(const Common<Real>& c, Real wanted, Real integral_weight) {
        const Real command = within(wanted, c.low, c.high);
        saturated_ = command != wanted;
        if (!saturated_) return command;
        if (c.anti_windup == AntiWindup::conditional) {
            const bool further = (wanted - command) * integral_weight * x_[0] > Real(0);
            if (further) x_[1] = before_;
        } else if (c.anti_windup == AntiWindup::back_calculation && integral_weight != Real(0)) {
            x_[1] += (c.period / c.tracking_time) * (command - wanted) / integral_weight;
        }
        return command;
    }

    constexpr const Real* x() const { return x_; }
    constexpr bool saturated() const { return saturated_; }
    constexpr void reset() { *this = Inputs(); }

private:
    Real x_[3] = {};
    Real filtered_ = Real(0);
    Real before_ = Real(0);  // the sum before this step
    bool started_ = false;
    bool saturated_ = false;
};

/// u = w1 x1 + w2 x2 + w3 x3 with fixed weights.
template <class Real>
class Pid {
public:
    constexpr Pid(const Common<Real>& common, const Real (&weights)[3]) : common_(common) {
        for (int i = 0; i < 3; ++i) weights_[i] = weights[i];
    }

    /// The next command. A target or measurement that is no number leaves the state alone and repeats the command;
    /// telling how long that may go on is the guard's task.
    constexpr Real step(Real target, Real measured) {
        if (!inputs_.update(common_, target, measured)) return command_;
        const Real* x = inputs_.x();
        const Real wanted = weights_[0] * x[0] + weights_[1] * x[1] + weights_[2] * x[2];
        if (is_finite(wanted)) command_ = inputs_.limited(common_, wanted, weights_[1]);
        return command_;
    }

    constexpr void reset() {
        inputs_.reset();
        command_ = Real(0);
    }

    constexpr const Common<Real>& common() const { return common_; }
    constexpr const Real* weights() const { return weights_; }
    constexpr const Inputs<Real>& inputs() const { return inputs_; }

private:
    Common<Real> common_;
    Real weights_[3] = {};
    Inputs<Real> inputs_;
    Real command_ = Real(0);
};

}  // namespace control
}  // namespace softlimb
