#pragma once
// One outcome for every solver of the package.
#include <stdexcept>
#include <string>
#include <string_view>

namespace softlimb::solve {

enum class SolveStatus {
    converged,          // the answer is right to the tolerance asked for
    max_iterations,     // the budget ran out; the best point is returned
    no_progress,        // no step improves the point any more
    singular_jacobian,  // a fold, or a mechanism
    not_finite,         // the model has no finite value there
    limit_point,        // the load is beyond the largest that the model can carry
};

constexpr std::string_view name_of(SolveStatus status) {
    switch (status) {
        case SolveStatus::converged:
            return "converged";
        case SolveStatus::max_iterations:
            return "max_iterations";
        case SolveStatus::no_progress:
            return "no_progress";
        case SolveStatus::singular_jacobian:
            return "singular_jacobian";
        case SolveStatus::not_finite:
            return "not_finite";
        case SolveStatus::limit_point:
            return "limit_point";
    }
    return "unknown";
}

/// The outcome of that name; raises std::invalid_argument for another.
inline SolveStatus status_named(std::string_view name) {
    for (int i = 0; i <= static_cast<int>(SolveStatus::limit_point); ++i)
        if (name_of(static_cast<SolveStatus>(i)) == name) return static_cast<SolveStatus>(i);
    throw std::invalid_argument("unknown status: " + std::string(name));
}

}  // namespace softlimb::solve
