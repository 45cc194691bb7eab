#pragma once
// Balance of the plates: the rods' end forces and stiffnesses, carried to the plates' origins by their lever arms, plus
// the loads. One block row a plate; rods couple a plate only to its neighbours. Source: Zhang et al. eq. 7-10 with the
// lever arms of cpp/MECHANICS.md, "Limb".
#include <vector>

#include "softlimb/limb/scene.hpp"
#include "softlimb/rod/chain.hpp"
#include "softlimb/solve/block_tridiagonal.hpp"

namespace softlimb::limb {

class Balance {
public:
    void resize(int plates);

    /// Assembles residual and stiffness from the condensed chains at the shape's plates, confined to the free freedoms:
    /// held directions get the equation "close the gap to the hold". `symmetric` takes the symmetric part and projects
    /// rows and columns, which a descent wants (its shapes meet the holds).
    void assemble(const Geometry& geometry, const Scene& scene, const std::vector<Pose>& plates,
                  const std::vector<rod::Chain>& chains, bool symmetric);
    /// Adds this to the diagonal as it was assembled, instead of what was added before.
    void shift(int plate, const Vector6& by);

    bool factor() { return system_.factor(); }
    bool factor_positive() { return system_.factor_positive(); }
    /// Solves K x = -rhs for the moves of the plates.
    void solve(const std::vector<Vector6>& rhs, std::vector<Vector6>& moves) const;

    const std::vector<Vector6>& residual() const { return residual_; }            // confined, if holds were applied
    const std::vector<Vector6>& full_residual() const { return full_residual_; }  // before the holds
    const solve::BlockTridiagonal& system() const { return system_; }
    /// Projector onto the free freedoms of plate j (identity where nothing is held).
    const Matrix6& projector(int j) const { return projector_[j]; }
    /// Turns a gap to the hold of plate j into the right-hand side of its held rows (zero where nothing is held).
    const Matrix6& hold_map(int j) const { return hold_map_[j]; }

    /// Carries end forces of the rods to the plates: the transpose of the rods' attachment.
    static void carry(const Geometry& geometry, const std::vector<Pose>& plates,
                      const std::vector<Vector12>& rod_forces, std::vector<Vector6>& plate_forces);
    /// Adds those of one rod of segment j.
    static void add_carried(const Geometry& geometry, const std::vector<Pose>& plates, int j, const Placement& place,
                            const Vector12& rod_force, std::vector<Vector6>& plate_forces);
    /// Puts the moves of every rod's two ends, first and last of its `nodes`, where those of the plates take them (base
    /// plate: zero).
    static void move_ends(const Geometry& geometry, const std::vector<Pose>& plates, const std::vector<Vector6>& moves,
                          std::vector<std::vector<Vector6>>& nodes);

private:
    void apply_holds(const Scene& scene, const std::vector<Pose>& plates, bool symmetric);

    solve::BlockTridiagonal system_;
    std::vector<Vector6> residual_, full_residual_, unshifted_;
    std::vector<Matrix6> projector_, hold_map_;
};

/// Wrench of all loads on plate j about its origin, base axes, and (unless null) its derivative to (dp, dtheta).
Vector6 plate_load(const Geometry& geometry, const Scene& scene, const Pose& plate, int j, Matrix6* derivative);

/// Gap of a held plate: (p - p_hold, rotation vector of R R_hold^T), and the rows that turn (dp, dtheta) into its
/// change.
Vector6 hold_gap(const Hold& hold, const Pose& plate);
Matrix6 hold_rows(const Hold& hold, const Pose& plate);

}  // namespace softlimb::limb
