#pragma once
// The heart of the package: equilibrium of a limb whose rods are at their pressures.
//
//   scene (rest lengths, sections, loads)                                      scene.hpp
//     -> a piece of rod: base pose and wrench -> end pose and wrench           rod/kernel.hpp, rod/element.hpp
//     -> a rod: its pieces condensed onto its two ends                         rod/chain.hpp
//     -> the plates: end forces of the rods, lever arms, loads; 6 rows each    balance.hpp
//     -> Newton on plates, nodes and base wrenches together                    here
//     -> finer integration as a check, which also gives the error estimate     here
//
// Unknowns are the poses of plates and interior nodes and the base wrench of every piece. A piece that, shot from its
// base, misses its second node has a gap; gaps and balances vanish together. The wrenches are condensed piece by piece,
// the nodes rod by rod, so that one 6 x 6 block row a plate remains.
// Source: Zhang et al. eq. 4-10; cpp/MECHANICS.md, "Limb" and "Newton".
#include "softlimb/limb/balance.hpp"
#include "softlimb/limb/scene.hpp"
#include "softlimb/solve/status.hpp"
#include "softlimb/solve/work.hpp"

namespace softlimb::limb {

struct NewtonSettings {
    double tolerance = 1e-6;  // tip error relative to the limb's length
    int max_iterations = 60;
    double largest_turn = 0.5;  // [rad] bound on a step's rotation; translations are bounded by this times half a rod
};

struct NewtonReport {
    solve::SolveStatus status = solve::SolveStatus::max_iterations;
    int iterations = 0;
    double error_estimate = 0.0;  // last correction, by the finer integration: relative to the limb's length
    double residual = 0.0;        // largest imbalance of a plate and mismatch of a piece, relative; see Equilibrium
    bool neutral_mode = false;    // a move that costs nothing: the answer is one of a continuum of equal ones
    int plate_modes = 0;          // negative eigenvalues of the condensed stiffness (symmetric part)
    int rod_modes = 0;            // negative pivots of the rods between held plates: conjugate points, exactly, because
                                  // the mesh keeps each piece far too short to buckle between its own nodes
};

class Equilibrium {
public:
    Equilibrium(const Geometry& geometry, const Scene& scene) : geometry_(geometry), scene_(scene) {}

    /// Newton from `shape` (plates, nodes, wrenches); the shape is left at the best point.
    NewtonReport solve(Shape& shape, const NewtonSettings& settings, solve::Work& work);

    /// Linearises at a shape that is an equilibrium already, for the responses below. False where it is singular.
    bool linearise_at(const Shape& shape);

    /// Condensed stiffness of the plates (free freedoms) at the last solution: rows of the balance, base axes, about
    /// each plate's origin. Valid after a converged solve.
    const Balance& balance() const { return balance_; }

    /// Moves of the plates under small extra wrenches on them, at the last solution.
    void respond(const std::vector<Vector6>& plate_wrenches, std::vector<Vector6>& moves) const;
    /// Moves of the plates when rod i's section and rest length change at the given rates.
    void respond_to_rod(const Shape& shape, int i, const Section& section_slope, double length_slope,
                        std::vector<Vector6>& moves) const;
    /// Condensed stiffness of the plates at the last solution, dense, on the free freedoms (held ones: identity rows).
    Eigen::MatrixXd dense_stiffness() const;
    /// Wrench that the ground exerts on the limb about the base origin, and the reaction of the hold on each plate.
    Vector6 base_wrench(const Shape& shape) const;
    std::vector<Vector6> reactions(const Shape& shape) const;

private:
    void count_modes(NewtonReport& report) const;
    void resize(const Shape& shape);
    bool linearise(const Shape& shape);
    bool check_finer(const Shape& shape);
    void propose(const Shape& shape);
    double largest_move(double length) const;  // translations by `length`, rotations in radians
    double step_size(const Shape& shape) const;
    double bounded_factor(double largest_turn) const;
    void apply(double factor, Shape& shape);
    double relative_residual(const Shape& shape) const;

    rod::RodPiece piece(int i, const Shape& shape) const {
        return {&scene_.rods[i].section, scene_.rods[i].rest_length / shape.rods[i].elements(), scene_.line_load(i)};
    }

    const Geometry& geometry_;
    const Scene& scene_;
    std::vector<rod::Chain> chains_;
    std::vector<std::vector<rod::ExactElement>> exact_;
    Balance balance_;
    std::vector<Vector6> moves_;
    std::vector<std::vector<Vector6>> node_moves_, wrench_moves_;
    // Scratch of the finer pass.
    std::vector<std::vector<Vector12>> loads_;
    std::vector<std::vector<Vector6>> gaps_, interior_;
    std::vector<Vector12> rod_forces_;
    std::vector<Vector6> plate_forces_;
    double length_scale_ = 1.0;
    int rod_modes_ = 0;
    Vector6 shift_ = Vector6::Zero();  // on every free node and plate, against a neutral mode; else zero
};

/// Largest activity (bend plus growth, see choose_mesh) of a piece of the shape.
double largest_activity(const Scene& scene, const Shape& shape);

/// Chooses pieces and steps of every rod from its internal wrenches, so that a piece turns little and grows little and
/// the integration should meet the tolerance. Splits pieces of `shape` where they are too long.
void choose_mesh(const Scene& scene, double tolerance, Shape& shape);

}  // namespace softlimb::limb
