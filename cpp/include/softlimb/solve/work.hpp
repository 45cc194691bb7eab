#pragma once
// A bound on the work of one solve, and the way out of it: no scene, however mad, may run for ever or ignore Ctrl-C.
// Counted in evaluations, not in seconds, so that the same scene ends the same way on every machine.
#include <exception>
#include <functional>
#include <utility>

namespace softlimb::solve {

/// Thrown out of a solve when the caller's `interrupted` says so.
struct Interrupted : std::exception {
    const char* what() const noexcept override { return "interrupted"; }
};

class Work {
public:
    explicit Work(long budget, std::function<bool()> interrupted = {})
        : left_(budget), interrupted_(std::move(interrupted)) {}

    /// Takes `amount` evaluations off the budget; false when it is used up. Raises Interrupted.
    bool spend(long amount) {
        left_ -= amount;
        pass_time(amount);
        return left_ > 0;
    }

    /// For work that takes as long as `amount` evaluations but belongs to a step already paid for. Raises Interrupted.
    void pass_time(long amount) {
        unasked_ += amount;
        // An evaluation takes a few microseconds: the caller is asked about every ten milliseconds.
        if (unasked_ > 3000 && interrupted_) {
            unasked_ = 0;
            if (interrupted_()) throw Interrupted();
        }
    }
    bool exhausted() const { return left_ <= 0; }

private:
    long left_, unasked_ = 0;
    std::function<bool()> interrupted_;
};

}  // namespace softlimb::solve
