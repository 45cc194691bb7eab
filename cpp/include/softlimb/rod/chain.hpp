#pragma once
// Static condensation of a chain of elements onto its two ends: the rod as the limb sees it. Interior nodes are
// eliminated one by one (a block-tridiagonal factorisation), so the cost is linear in the number of elements and strong
// tension, which makes single shooting useless, does no harm. Source: cpp/MECHANICS.md, "Chain".
#include <vector>

#include "softlimb/rod/element.hpp"

namespace softlimb::rod {

class Chain {
public:
    /// Makes room; called before a solve, never in it.
    void resize(int elements);
    int elements() const { return static_cast<int>(elements_.size()); }
    ElementStiffness& element(int i) { return elements_[i]; }
    const ElementStiffness& element(int i) const { return elements_[i]; }

    /// Eliminates the interior nodes and leaves force and stiffness of the rod's ends in `ends()`. `shift` is added to
    /// the diagonal of each interior node (a trust-region multiplier times its metric); `symmetric` symmetrises the
    /// pivots first, which the descent's model wants. With `need_positive` the elimination stops at the first pivot
    /// that is not positive definite. False when a pivot is not, or cannot be inverted.
    bool condense(const Vector6& shift, bool symmetric, bool need_positive);
    /// Negative eigenvalues of the (symmetrised) pivots of the last elimination: unstable modes with both ends held.
    int negative_pivots() const;
    /// Whether the symmetric part of the interior stiffness less `margin` on the diagonal of each node is positive
    /// definite: a chain of a stiffness that differs by less has no unstable mode with both ends held either.
    bool positive_beyond(const Vector6& margin) const;
    const ElementStiffness& ends() const { return ends_; }

    /// Moves of the interior nodes, given those of the ends; `nodes` has elements()+1 entries, of which first and last
    /// are inputs.
    void recover(std::vector<Vector6>& nodes) const;

    /// Forces at the ends (g1, g2) of a load on the interior and element ends: `loads[e]` are the forces of element e;
    /// used for responses to parameters. Call after `condense`; `recover_with` uses the same loads.
    Vector12 condense_loads(const std::vector<Vector12>& loads, std::vector<Vector6>& interior) const;
    void recover_with(const std::vector<Vector6>& interior, std::vector<Vector6>& nodes) const;

private:
    std::vector<ElementStiffness> elements_;
    std::vector<lanes::Elimination> eliminations_;
    ElementStiffness ends_;
};

/// Number of negative eigenvalues of the symmetric part of a pivot.
int negative_eigenvalues(const Matrix6& pivot);

}  // namespace softlimb::rod
