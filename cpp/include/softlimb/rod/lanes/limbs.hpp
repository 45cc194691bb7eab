#pragma once
// Newton for several limbs side by side, one a lane of the vector registers: limbs of one geometry, on one mesh, under
// the same loads, each with rods of its own. A lane does not know of the others: it converges, fails and is filled
// again by itself, and what it gives does not depend on who stands beside it. Plain numbers in and out, as in
// pieces.hpp. Source: cpp/MECHANICS.md, "Limbs side by side".
#include <cstddef>

#include "softlimb/section.hpp"

namespace softlimb::rod::lanes {

/// How a set of pieces is loaded, hence which base rotations need an integration of their own beside the six columns of
/// the base wrench: without load none (turn base and wrench together and the piece turns with them), with a dead force
/// those across it, else all three.
enum class Loads { none, force, any };

/// A rod as all lanes have it. Poses are a position [m] and a rotation by columns, 12 numbers.
struct LimbRod {
    int plate = 0;     // at its end
    int elements = 1;  // pieces
    int steps = 1;     // of the eighth-order method through each
    double
        base[12];    // in the frame of the plate before, the plate's thickness included; of the first plate: the base's
    double end[12];  // in the plate's frame
};

/// A plate and its loads as all lanes have them.
struct LimbPlate {
    double wrench[6];   // about its origin, base axes or, where it follows, plate axes [N, N m]
    double weight[3];   // [N]
    double weight_arm;  // of its centre of mass along its z axis [m]
};

/// What the limbs in the lanes share.
struct LimbPlan {
    const LimbRod* rod = nullptr;  // plate by plate
    const LimbPlate* plate = nullptr;
    int rods = 0, plates = 0;
    bool following = false;
    Loads loads = Loads::none;
    double length = 1.0;      // what translations are measured by [m]
    double tolerance = 1e-6;  // of the tip, relative to that
    int most_iterations = 10;
    int corrections = 1;  // by the stiffness at hand in a round, before the one that checks

    /// Numbers of a state: plates, then each rod's interior nodes and the base wrenches (n, m) of its pieces.
    int numbers() const {
        int count = 12 * plates;
        for (int i = 0; i < rods; ++i) count += 18 * rod[i].elements - 12;
        return count;
    }
};

/// What one lane is filled with.
struct LimbStart {
    const Section* const* section;  // one a rod
    const double* rest_length;      // one a rod [m]
    const double* load;             // per rest length: force and moment, 6 a rod [N/m, N]
    const double* state;            // as LimbPlan::numbers says
    double neutral;                 // eigenvalues below this count as zero [N m]
    int iterations = 0;             // of a limb that comes back: what its report said
    bool asked_again = false;
};

enum class LaneStatus { empty, running, converged, failed };

/// How a lane stands. Converged: the answer meets the tolerance by an integration of half the step, moves and wrenches,
/// and `stable` says that its stiffness is positive definite with room for all that it may have changed since it was
/// taken. Anything else is for another solver to say.
struct LaneReport {
    LaneStatus status;
    bool stable;
    int iterations;
    double residual, error;  // as in limb::NewtonReport
    bool asked_again;        // its stiffness is taken once more, to tell whether it is stable
};

/// Room is `bytes(plan)` bytes, aligned to 64, that belong to the lanes from `open` on.
struct LimbFunctions {
    std::size_t (*bytes)(const LimbPlan& plan);
    void (*open)(const LimbPlan& plan, void* room);
    void (*fill)(const LimbPlan& plan, void* room, int lane, const LimbStart& start);
    /// One linearisation and what follows from it, for all lanes that are running.
    void (*round)(const LimbPlan& plan, void* room);
    LaneReport (*report)(const LimbPlan& plan, const void* room, int lane);
    /// The lane's state, as LimbPlan::numbers says; the lane is empty then.
    void (*take)(const LimbPlan& plan, void* room, int lane, double* state);
};

}  // namespace softlimb::rod::lanes
