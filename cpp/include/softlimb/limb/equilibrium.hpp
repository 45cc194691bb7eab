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
#include <cstdint>
#include <functional>

#include "softlimb/limb/balance.hpp"
#include "softlimb/limb/moves.hpp"
#include "softlimb/limb/scene.hpp"
#include "softlimb/solve/newton_numbers.hpp"
#include "softlimb/solve/room.hpp"
#include "softlimb/solve/status.hpp"
#include "softlimb/solve/work.hpp"

namespace softlimb::limb {

/// A parameter of the scene that Newton may move as well, within a plane: the border of a pseudo-arclength step.
struct Border {
    Scene before, after;                 // the scene a little before and after the parameter's value
    double span = 0.0;                   // between the two
    const Moves* tangent = nullptr;      // corrections stay perpendicular to (tangent, parameter_tangent) ...
    double parameter_tangent = 1.0;      // ... or leave the parameter alone where `tangent` is null
    double range = 1.0;                  // unit of the parameter in the inner product
    double parameter = 0.0;              // moved along
    std::function<bool(double)> adjust;  // puts the scene at a value of the parameter; false where it has none

    bool move_by(double step) {
        if (step == 0.0) return true;
        parameter += step;
        return adjust(parameter);
    }
};

/// Rates of a rod's section (field by field) and rest length with a parameter of its own, for instance its pressure.
struct RodSlope {
    Section section;
    double rest_length = 0.0;
};

struct NewtonSettings {
    double tolerance = 1e-6;  // tip error relative to the limb's length
    int max_iterations = 60;
    double largest_turn = solve::largest_turn;
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
    bool nearer = false;          // `follow` has taken whole steps: where it gave up, its shape is the better start
    int modes() const { return plate_modes + rod_modes; }
};

/// Tells the linearisations of a program from each other. Zero: none that was given a number.
using LinearisationNumber = std::uint64_t;

/// What an equilibrium works in. Handed from one to the next on a thread, so that a limb solved again and again makes
/// room once.
struct EquilibriumRoom {
    std::vector<rod::Chain> chains_;
    std::vector<std::vector<rod::ExactElement>> exact_;
    std::vector<std::vector<rod::EndState>> ends_, ends_after_;
    std::vector<std::vector<rod::EndSlope>> end_slopes_;
    rod::Batch batch_;
    Balance balance_;
    solve::BlockTridiagonal symmetric_;  // for counting
    Moves moves_, by_parameter_;
    std::vector<Moves> neutral_;  // unit moves that cost nothing, perpendicular to each other
    // Loads on the pieces beside those of the linearisation, and what follows from them.
    std::vector<std::vector<Vector12>> loads_;
    std::vector<std::vector<Vector6>> gaps_, interior_;
    std::vector<Vector12> rod_forces_;
    std::vector<Vector6> plate_forces_, carried_, hold_rows_;
    std::vector<Matrix6> tip_by_plate_;
    LinearisationNumber number_ = 0;  // of the last linearisation
};

class Equilibrium : private solve::Room<EquilibriumRoom> {
    friend class Derivatives;  // which reads the last linearisation

public:
    Equilibrium(const Geometry& geometry, const Scene& scene) : Equilibrium(geometry, scene, 0) {}
    /// With the linearisation of that number at hand, where this thread still has it.
    Equilibrium(const Geometry& geometry, const Scene& scene, LinearisationNumber number);
    bool at_hand(LinearisationNumber number) const { return number != 0 && number == number_; }
    /// Gives the last linearisation a number: it stays at hand for an equilibrium that asks for it, among the last few.
    LinearisationNumber keep_linearisation();

    /// Newton from `shape` (plates, nodes, wrenches); the shape is left at the best point.
    NewtonReport solve(Shape& shape, const NewtonSettings& settings, solve::Work& work, Border* border = nullptr);

    /// From a posture near by, with its stiffness: that of `before`, which has the pieces of `shape`, in its own scene.
    /// One linearisation, at the answer, which judges it and may be kept. Gives up (status: no_progress) where that
    /// takes too many steps or longer ones of the integration than the tolerance allows.
    NewtonReport follow(const Scene& scene_before, const Shape& before, LinearisationNumber number, Shape& shape,
                        const NewtonSettings& settings, solve::Work& work);

    /// Moves of everything by unit parameter, at the last solution.
    Moves response_to_parameter(const Shape& shape, const Border& border);

    /// Linearises at a shape that is an equilibrium already, for the responses below; with `pinned` a neutral mode is
    /// held by a shift far below the rods' stiffness. False where it is singular.
    bool linearise_at(const Shape& shape, bool pinned = false);
    /// So many moves (mean square one over plates and nodes, perpendicular to each other) along which the stiffness at
    /// a shape is nearest to zero, the nearest first. None where it is singular.
    std::vector<Moves> softest_moves(const Shape& shape, int count);
    /// Counts the unstable modes at `shape` into the report. Since the last linearisation the stiffness may have
    /// changed by so much [N m]: where that could change the count it is done again. What a shift of the size of
    /// rounding takes away was no unstable mode but a neutral one.
    void judge(const Shape& shape, NewtonReport& report, double changed);
    const Geometry& geometry() const { return geometry_; }

    /// Condensed stiffness of the plates (free freedoms) at the last solution: rows of the balance, base axes, about
    /// each plate's origin. Valid after a converged solve.
    const Balance& balance() const { return balance_; }

    /// Moves of the tip when the section and rest length of each rod in turn change at the given rates.
    void respond_to_rods(const Shape& shape, const std::vector<RodSlope>& slopes, std::vector<Vector6>& tip_moves);
    /// One Newton step at a shape near balance. Size of the step, of which about the square is left; infinite where
    /// there is none or it had to be cut.
    double step_to_balance(Shape& shape);
    /// Moves of everything when those parameters change by the given amounts, a rod each; after `respond_to_rods`.
    const Moves& moves_with_rods(const Shape& shape, const std::vector<double>& amounts);
    /// Condensed stiffness of the plates at the last solution, dense, on the free freedoms (held ones: identity rows).
    Eigen::MatrixXd dense_stiffness() const;
    /// Its real negative eigenvalues: where it is not symmetric, the ways in which the plates diverge without
    /// oscillating.
    int diverging_modes() const;
    /// Wrench that the ground exerts on the limb about the base origin, and the reaction of the hold on each plate.
    Vector6 base_wrench(const Shape& shape) const;
    std::vector<Vector6> reactions(const Shape& shape) const;

private:
    /// Unstable modes; eigenvalues below `margin` [N m] count as negative, of translations in limb lengths.
    void count_modes(NewtonReport& report, double margin = 0.0);
    /// Blocks of the symmetric part of the plates' stiffness, confined to the free freedoms, less such a margin.
    Matrix6 symmetric_diagonal(int j, double margin) const;
    Matrix6 symmetric_upper(int j) const;
    /// The same margin for the nodes of rod i.
    Vector6 rod_margin(std::size_t i, double margin) const;
    void pin(double share);
    void find_neutral(const Shape& shape);
    void leave_out_neutral();
    void resize(const Shape& shape);
    /// Runs the pieces of all rods through the lanes, `finer` times the rods' own numbers of steps: `add(part, rod,
    /// piece)` puts a piece into the batch.
    template <class Add>
    void integrate(const Scene& scene, const Shape& shape, int finer, Add&& add);
    void shoot(const Scene& scene, const Shape& shape, int finer, std::vector<std::vector<rod::EndState>>& ends);
    bool linearise(const Shape& shape) { return linearise(scene_, shape); }
    bool linearise(const Scene& scene, const Shape& shape);
    void propose(const Shape& shape);
    /// Moves that meet the residual at `shape`, integrated with `finer` times its steps, by the last linearisation's
    /// stiffness. What is not finite there leaves a move of its piece that is not.
    void propose_again(const Shape& shape, int finer);
    bool differ(const Shape& shape, const Border& border);
    void respond_to_gaps(const Shape& shape);
    double stay_perpendicular(const Border& border);
    /// What forces and moments are measured by: the largest inside the rods, or EI/l^2 and EI/l where those are larger.
    struct Scales {
        double force, moment;
        double largest_force;
    };
    Scales scales_at(const Shape& shape) const;
    /// How large the proposed moves are: poses, wrenches relative to the scales, and what counts of both.
    struct Step {
        double moved, wrench, size;
    };
    Step step_now(const Scales& scales) const;
    double largest_wrench_change(const Scales& scales) const;
    /// By how much the proposed moves may change the stiffness of the plates [N m].
    double stiffness_change(const Step& step, const Scales& scales) const;
    /// No mode is unstable, nor would be were the last linearisation wrong by so much [N m]. False leaves it open.
    bool surely_stable(double changed);
    double bounded_factor(const Shape& shape, double largest_turn) const;
    double relative_residual(const Shape& shape, const Scales& scales) const;
    /// By which an end of a piece misses its node at the last linearisation: relative to the limb, or in radians.
    double largest_gap() const;

    static rod::RodPiece piece_of(const Scene& scene, int i, const Shape& shape) {
        return {&scene.rods[i].section, scene.rods[i].rest_length / shape.rods[i].elements(), scene.line_load(i)};
    }
    rod::RodPiece piece(int i, const Shape& shape) const { return piece_of(scene_, i, shape); }

    const Geometry& geometry_;
    const Scene& scene_;
    double length_scale_ = 1.0;
    double stable_beyond_ = -1.0;      // [N m] largest `changed` for which the last linearisation is `surely_stable`
    Vector6 shift_ = Vector6::Zero();  // on every free node and plate, against a neutral mode; else zero
};

/// Whether the pieces and steps suit the wrenches: by the activity (bend plus growth) of each piece, l |m|/EI +
/// l sqrt(|n|/EI) + l |u3*|, l its rest length. Otherwise modes may be missed.
bool mesh_suffices(const Scene& scene, double tolerance, const Shape& shape);

/// Eigenvalues of a limb's stiffness below this count as zero [N m].
double neutral_margin(const Geometry& geometry, const Scene& scene);

/// Activity of a piece beyond which Newton's basin becomes small: for starts from afar.
constexpr double newton_piece = 1.5;
/// The same for a start nearby. Below 3 no piece buckles between its own nodes (cpp/MECHANICS.md, "Stability"), which
/// the count of modes relies on.
constexpr double warm_piece = 2.7, largest_countable_piece = 3.0;

/// How much a rod bends and how fast its solutions grow over a length: what the accuracy of a step depends on.
double activity(const Section& section, const Vector6& wrench, double length);
/// Largest activity of rod i, its whole length taken as one piece.
double rod_activity(const Scene& scene, const Shape& shape, std::size_t i);
/// Activity of a step that should meet the tolerance.
double allowed_step(double tolerance);

/// Chooses pieces and steps of every rod from its internal wrenches, so that a piece turns little and grows little and
/// the integration should meet the tolerance. Splits pieces of `shape` where they are too long; joins short ones where
/// `largest_piece` is that of a warm start and joining is allowed.
enum class Joining { allowed, none };
void choose_mesh(const Scene& scene, double tolerance, Shape& shape, double largest_piece = newton_piece,
                 Joining joining = Joining::allowed);

}  // namespace softlimb::limb
