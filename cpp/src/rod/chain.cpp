#include "softlimb/rod/chain.hpp"

#include <Eigen/Eigenvalues>

#include "softlimb/solve/definite.hpp"

namespace softlimb::rod {
namespace {

// The kernel reads elements as plain numbers.
static_assert(sizeof(ElementStiffness) == 156 * sizeof(double));
static_assert(sizeof(lanes::Elimination) == 186 * sizeof(double));

Eigen::Map<const Matrix6> matrix(const double (&x)[36]) { return Eigen::Map<const Matrix6>(x); }
Eigen::Map<const Vector6> vector(const double (&x)[6]) { return Eigen::Map<const Vector6>(x); }

}  // namespace

int negative_eigenvalues(const Matrix6& pivot) {
    const Matrix6 symmetric = 0.5 * (pivot + pivot.transpose());
    // Nearly every pivot is positive definite; Cholesky says so at a tenth of the cost.
    Matrix6 lower;
    if (solve::cholesky(symmetric, lower)) return 0;
    const Eigen::SelfAdjointEigenSolver<Matrix6> eigen(symmetric, Eigen::EigenvaluesOnly);
    return static_cast<int>((eigen.eigenvalues().array() < 0.0).count());
}

void Chain::resize(int elements) {
    elements_.resize(elements);
    eliminations_.resize(elements > 0 ? elements - 1 : 0);
}

bool Chain::condense(const Vector6& shift, bool symmetric, bool need_positive) {
    if (elements() == 1) {
        ends_ = elements_[0];
        return true;
    }
    return lanes::kernel().condense(elements_.front().force.data(), elements(), ends_.force.data(),
                                    eliminations_.data(), shift.data(), symmetric, need_positive);
}

int Chain::negative_pivots() const {
    int negative = 0;
    for (const lanes::Elimination& e : eliminations_) negative += negative_eigenvalues(matrix(e.pivot));
    return negative;
}

bool Chain::positive_beyond(const Vector6& margin) const {
    solve::DefiniteRows rows;
    for (int k = 1; k < elements(); ++k) {
        const Matrix12 &before = elements_[k - 1].stiffness, &after = elements_[k].stiffness;
        const Matrix6 whole = before.bottomRightCorner<6, 6>() + after.topLeftCorner<6, 6>();
        Matrix6 pivot = 0.5 * (whole + whole.transpose());
        pivot.diagonal() -= margin;
        if (!rows.add(pivot)) return false;
        if (k + 1 < elements())
            rows.couple(0.5 * (after.bottomLeftCorner<6, 6>() + after.topRightCorner<6, 6>().transpose()));
    }
    return true;
}

void Chain::recover(std::vector<Vector6>& nodes) const {
    for (int k = elements() - 1; k >= 1; --k) {
        const lanes::Elimination& e = eliminations_[k - 1];
        nodes[k] = -(matrix(e.by_first) * nodes[0] + matrix(e.by_next) * nodes[k + 1] + vector(e.right));
    }
}

Vector12 Chain::condense_loads(const std::vector<Vector12>& loads, std::vector<Vector6>& interior) const {
    Vector12 ends = loads[0];
    for (int k = 1; k < elements(); ++k) {
        const lanes::Elimination& e = eliminations_[k - 1];
        interior[k] = matrix(e.inverse) * (ends.tail<6>() + loads[k].head<6>());
        ends.head<6>() -= matrix(e.first_row) * interior[k];
        ends.tail<6>() = loads[k].tail<6>() - elements_[k].stiffness.bottomLeftCorner<6, 6>() * interior[k];
    }
    return ends;
}

void Chain::recover_with(const std::vector<Vector6>& interior, std::vector<Vector6>& nodes) const {
    for (int k = elements() - 1; k >= 1; --k) {
        const lanes::Elimination& e = eliminations_[k - 1];
        nodes[k] = -(matrix(e.by_first) * nodes[0] + matrix(e.by_next) * nodes[k + 1] + interior[k]);
    }
}

}  // namespace softlimb::rod
