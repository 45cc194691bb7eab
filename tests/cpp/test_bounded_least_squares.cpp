// Least squares between bounds: what holds at the answer, on random problems of every kind of difficulty.
#include "check.hpp"
#include "examples.hpp"
#include "softlimb/solve/bounded_least_squares.hpp"

using namespace softlimb;
using namespace softlimb::tests;
using Eigen::MatrixXd, Eigen::VectorXd;

CLAIM(no_entry_can_move_within_its_bounds_and_come_nearer) {
    Draw draw(70);
    for (int trial = 0; trial < 300; ++trial) {
        const int n = 1 + trial % 9, m = 6;
        // Rows of a target far heavier than those of a preference, as a search over pressures has them; every third
        // time two columns are all but equal.
        MatrixXd matrix(m + n, n);
        for (int i = 0; i < m; ++i)
            for (int j = 0; j < n; ++j) matrix(i, j) = 1e6 * draw();
        if (trial % 3 == 0 && n > 1) matrix.col(1) = matrix.col(0) * (1.0 + 1e-9);
        matrix.bottomRows(n).setIdentity();
        VectorXd right(m + n), lower(n), upper(n);
        for (int i = 0; i < m; ++i) right(i) = 1e6 * draw();
        for (int j = 0; j < n; ++j) {
            right(m + j) = draw();
            lower(j) = trial % 4 == 0 && j % 2 == 0 ? 0.0 : -std::abs(0.5 * draw());
            upper(j) = trial % 5 == 0 && j % 3 == 0 ? 0.0 : std::abs(0.5 * draw());
        }
        const VectorXd x = solve::bounded_least_squares(matrix, right, lower, upper);
        CHECK((x.array() >= lower.array()).all() && (x.array() <= upper.array()).all());
        const VectorXd downhill = matrix.transpose() * (right - matrix * x);
        for (int j = 0; j < n; ++j) {
            // Rounding of products of a column with the residual.
            const double rounding = 1e-14 * matrix.col(j).norm() * right.norm();
            if (x(j) > lower(j)) CHECK(downhill(j) > -rounding);
            if (x(j) < upper(j)) CHECK(downhill(j) < rounding);
        }
    }
}
