#pragma once
// Linear least squares between bounds: the step of every bounded search. Source: cpp/MECHANICS.md, "Reach".
#include <Eigen/Core>

namespace softlimb::solve {

/// Minimises |matrix x - right|^2 with lower <= x <= upper by an active set. `matrix` has full column rank; zero lies
/// between the bounds. Entries of x that end on a bound are exactly there.
Eigen::VectorXd bounded_least_squares(const Eigen::MatrixXd& matrix, const Eigen::VectorXd& right,
                                      const Eigen::VectorXd& lower, const Eigen::VectorXd& upper);

}  // namespace softlimb::solve
