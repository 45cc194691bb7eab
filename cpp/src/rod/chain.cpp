#include "softlimb/rod/chain.hpp"

#include <Eigen/Eigenvalues>

#include "softlimb/solve/block6.hpp"

namespace softlimb::rod {

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
    ends_ = elements_[0];
    for (int k = 1; k < elements(); ++k) {
        const ElementStiffness& next = elements_[k];
        Elimination& e = eliminations_[k - 1];
        e.pivot = ends_.stiffness.bottomRightCorner<6, 6>() + next.stiffness.topLeftCorner<6, 6>();
        e.pivot.diagonal() += shift;
        if (symmetric) e.pivot = 0.5 * (e.pivot + e.pivot.transpose()).eval();
        const bool regular =
            need_positive ? solve::invert_positive(e.pivot, e.inverse) : solve::invert(e.pivot, e.inverse);
        if (!regular) return false;
        e.first_row = ends_.stiffness.topRightCorner<6, 6>();
        e.next_row = next.stiffness.bottomLeftCorner<6, 6>();
        e.by_first.noalias() = e.inverse * ends_.stiffness.bottomLeftCorner<6, 6>();
        e.by_next.noalias() = e.inverse * next.stiffness.topRightCorner<6, 6>();
        e.right = e.inverse * (ends_.force.tail<6>() + next.force.head<6>());

        ends_.stiffness.topLeftCorner<6, 6>().noalias() -= e.first_row * e.by_first;
        ends_.stiffness.topRightCorner<6, 6>().noalias() = -e.first_row * e.by_next;
        ends_.stiffness.bottomLeftCorner<6, 6>().noalias() = -e.next_row * e.by_first;
        ends_.stiffness.bottomRightCorner<6, 6>() = next.stiffness.bottomRightCorner<6, 6>();
        ends_.stiffness.bottomRightCorner<6, 6>().noalias() -= e.next_row * e.by_next;
        ends_.force.head<6>() -= e.first_row * e.right;
        ends_.force.tail<6>() = next.force.tail<6>() - e.next_row * e.right;
    }
    return true;
}

int Chain::negative_pivots() const {
    int negative = 0;
    for (const Elimination& e : eliminations_) negative += negative_eigenvalues(e.pivot);
    return negative;
}

void Chain::recover(std::vector<Vector6>& nodes) const {
    for (int k = elements() - 1; k >= 1; --k) {
        const Elimination& e = eliminations_[k - 1];
        nodes[k] = -(e.by_first * nodes[0] + e.by_next * nodes[k + 1] + e.right);
    }
}

Vector12 Chain::condense_loads(const std::vector<Vector12>& loads, std::vector<Vector6>& interior) const {
    Vector12 ends = loads[0];
    for (int k = 1; k < elements(); ++k) {
        const Elimination& e = eliminations_[k - 1];
        interior[k] = e.inverse * (ends.tail<6>() + loads[k].head<6>());
        ends.head<6>() -= e.first_row * interior[k];
        ends.tail<6>() = loads[k].tail<6>() - e.next_row * interior[k];
    }
    return ends;
}

void Chain::recover_with(const std::vector<Vector6>& interior, std::vector<Vector6>& nodes) const {
    for (int k = elements() - 1; k >= 1; --k) {
        const Elimination& e = eliminations_[k - 1];
        nodes[k] = -(e.by_first * nodes[0] + e.by_next * nodes[k + 1] + interior[k]);
    }
}

}  // namespace softlimb::rod
