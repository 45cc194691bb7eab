#pragma once
// Whether a symmetric block-tridiagonal matrix is positive definite, told block row by block row from the first:
// elimination without square roots, which keeps nothing but the last row.
#include "softlimb/solve/block6.hpp"

namespace softlimb::solve {

class DefiniteRows {
public:
    /// Takes the next diagonal block, of which the lower triangle is read. False when the rows up to this one are not
    /// positive definite, or no numbers; then nothing more may follow.
    bool add(const Block6& diagonal) {
        row_ = diagonal;
        for (int k = 0; k < 6 && !first_; ++k) subtract(beside_.col(k), per_pivot_[k], 0);
        for (int k = 0; k < 6; ++k) {
            const double pivot = row_(k, k);
            if (!(pivot > 0.0) || !(pivot < 1e308)) return false;
            per_pivot_[k] = 1.0 / pivot;
            subtract(row_.col(k), per_pivot_[k], k + 1);
        }
        return true;
    }
    /// The block that couples the row just added (its columns) to the next one (its rows).
    void couple(const Block6& beside) {
        first_ = false;
        beside_ = beside;
        for (int k = 0; k < 6; ++k)
            for (int c = k + 1; c < 6; ++c) beside_.col(c) -= (row_(c, k) * per_pivot_[k]) * beside_.col(k);
    }

private:
    /// scale x x^T off the lower triangle, from column `from` on.
    void subtract(const Eigen::Matrix<double, 6, 1>& x, double scale, int from) {
        for (int c = from; c < 6; ++c) row_.col(c) -= (scale * x(c)) * x;
    }

    Block6 row_, beside_;  // columns of the last block row below their pivots, and of the coupling behind it
    double per_pivot_[6];
    bool first_ = true;
};

}  // namespace softlimb::solve
