#pragma once
// Block-tridiagonal systems of 6 x 6 blocks: one block row a plate, or a node. Knows no mechanics.
#include <vector>

#include "softlimb/solve/block6.hpp"

namespace softlimb::solve {

class BlockTridiagonal {
public:
    using Block = Block6;
    using Vector = Eigen::Matrix<double, 6, 1>;

    void resize(int rows) {
        diagonal.resize(rows), lower.resize(rows), upper.resize(rows);
        inverse_.resize(rows), pivots_.resize(rows);
    }
    void set_zero() {
        for (std::size_t k = 0; k < diagonal.size(); ++k) diagonal[k].setZero(), lower[k].setZero(), upper[k].setZero();
    }
    int rows() const { return static_cast<int>(diagonal.size()); }

    /// Block LU from the first row on; false when a pivot is singular or not finite.
    bool factor() {
        for (int k = 0; k < rows(); ++k) {
            pivots_[k] = diagonal[k];
            if (k > 0) pivots_[k].noalias() -= lower[k] * inverse_[k - 1] * upper[k - 1];
            if (!invert(pivots_[k], inverse_[k])) return false;
        }
        return true;
    }
    /// The same for a symmetric matrix that must be positive definite: false when it is not.
    bool factor_positive() {
        for (int k = 0; k < rows(); ++k) {
            pivots_[k] = diagonal[k];
            if (k > 0) pivots_[k].noalias() -= lower[k] * inverse_[k - 1] * upper[k - 1];
            if (!invert_positive(pivots_[k], inverse_[k])) return false;
        }
        return true;
    }
    /// Overwrites the right-hand side with the solution.
    void solve(std::vector<Vector>& x) const {
        for (int k = 1; k < rows(); ++k) x[k].noalias() -= lower[k] * (inverse_[k - 1] * x[k - 1]);
        for (int k = rows() - 1; k >= 0; --k) {
            if (k + 1 < rows()) x[k].noalias() -= upper[k] * x[k + 1];
            x[k] = (inverse_[k] * x[k]).eval();
        }
    }
    /// Last block row of the inverse: what each block row of a right-hand side gives the last unknowns.
    void last_of_inverse(std::vector<Block>& row) const {
        row.resize(rows());
        if (rows() > 0) row.back() = inverse_.back();
        for (int k = rows() - 1; k > 0; --k) row[k - 1].noalias() = -(row[k] * lower[k]).eval() * inverse_[k - 1];
    }
    /// Pivots of the last factorisation: for a symmetric matrix their inertia adds up to that of the matrix.
    const std::vector<Block>& pivots() const { return pivots_; }

    std::vector<Block> diagonal, lower, upper;  // lower[k] couples k to k-1, upper[k] couples k to k+1

private:
    std::vector<Block> inverse_, pivots_;
};

}  // namespace softlimb::solve
