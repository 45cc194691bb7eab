#pragma once
// Many pieces of rod at once: each in a lane of the vector registers, all by the same steps of the eighth-order method.
// Plain numbers in and out, so that one source can be compiled for every instruction set; `kernel()` picks at run time.
// A lane does not know of the others: what a piece gives does not depend on which pieces stand beside it.
// Source: cpp/MECHANICS.md, "Element" and "Lanes".
#include <string>
#include <vector>

#include "softlimb/rod/equations.hpp"
#include "softlimb/rod/lanes/limbs.hpp"
#include "softlimb/section.hpp"

namespace softlimb::rod::lanes {

/// A piece and where it starts; base axes.
struct Start {
    const Section* section;
    const double* position;      // of the first node [m], 3
    const double* rotation;      // of the first node, 3 x 3 by columns
    const double* wrench;        // internal (n, m) there [N, N m], 6
    double length;               // rest length [m]
    double force[3], moment[3];  // loads per rest length [N/m, N]
};

/// End of a piece: what `EndState` is made of.
struct End {
    double* position;  // 3
    double* rotation;  // 3 x 3 by columns
    double* wrench;    // 6
};

/// Where the linearisation of a piece goes; matrices by columns.
struct Linear {
    const double* second_position;  // of the second node [m], 3
    const double* second_rotation;  // 3 x 3
    End end;
    double* gap;               // end minus second node: (dp, rotation vector), 6
    double* end_by_pose;       // 6 x 6
    double* inverse;           // of end pose by base wrench, 6 x 6
    double* wrench_by_wrench;  // 6 x 6
    double* force;             // generalised forces on (first, second), 12
    double* stiffness;         // 12 x 12
    bool* regular;             // finite, and the inverse exists
};

/// How a piece changes with a parameter: section field by field (of the axial law the coefficients and the range),
/// rest length, and load per rest length; base pose and base wrench stay.
struct Slope {
    const Section* section;
    double length;
    double force[3];
};

/// Where the derivative of the end goes.
struct EndSlopes {
    double* pose;    // (dp, dtheta), 6
    double* wrench;  // 6
};

/// A geodesic element: what `GeodesicData` (rod/geodesic.hpp) is made of.
struct Geodesic {
    double twist[6];                                  // from the first to the second node: (rho, phi)
    double beta[3];                                   // of phi^2, with its first and second derivative
    const double *first_rotation, *second_rotation;   // 3 x 3 by columns
    double shear, axial, bending, torsion, coupling;  // stiffness of the strains
    double length, rest_twist;
    double half_force[3], half_moment[3];
};

/// Where forces on its nodes (12) and their derivatives (12 x 12 by columns) go.
struct GeodesicEnd {
    double *force, *stiffness;
};

/// What eliminating a chain's interior node leaves; matrices 6 x 6 by columns. The node's move is
/// -(by_first x_first + by_next x_next + right); `first_row` is the node's column in the balance of the chain's first.
struct Elimination {
    double by_first[36], by_next[36], first_row[36], pivot[36], inverse[36], right[6];
};

/// Of a rod alone: axis and moment by RK4 with two columns, or by the eighth order without, or with the director too.
enum class Wanted { slopes, axis, directors };

/// A rod from its tip to its base, piece after piece.
struct RodAlone {
    const Section* section;
    double length;  // of all pieces [m]
    LineLoad<double> load;
    Vec3<double> tip_force;  // internal [N]
    int pieces, steps;       // steps of a piece
    Wanted wanted;
};

/// Sums that `combine` makes at once, and columns of its panels.
constexpr int combined = 8;

/// The functions of one instruction set.
struct Kernel {
    const char* instruction_set;
    int lanes;
    /// Ends of `count` pieces, `steps` steps each.
    void (*shoot)(const Start* starts, const End* ends, int count, int steps);
    /// Derivatives of the ends to one parameter a piece.
    void (*differentiate)(const Start* starts, const Slope* slopes, const EndSlopes* out, int count, int steps);
    /// Ends and linearisations.
    void (*linearise)(const Start* starts, const Linear* out, int count, int steps, Loads loads);
    /// Forces and stiffness of `count` geodesic elements.
    void (*geodesics)(const Geodesic* elements, const GeodesicEnd* out, int count);
    /// Eliminates the interior nodes of a chain of `count` elements, 12 forces and a 12 x 12 stiffness each, into one
    /// of that kind (`ends`). `shift` (6) is added to each pivot's diagonal; `symmetric` symmetrises the pivots first.
    /// False at the first one that cannot be inverted or, with `positive`, is not positive definite.
    bool (*condense)(const double* elements, int count, double* ends, Elimination* out, const double* shift,
                     bool symmetric, bool positive);
    /// Adds the stiffness of such an element, its nodes at these arms (3) from the origins of two plates, to the 6 x 6
    /// blocks of the plates: (base, base), (base, end), (end, base), (end, end). Without `base` its node is on the
    /// ground and the last block alone is meant.
    void (*carry)(const double* ends, const double* base_arm, const double* end_arm, double* base, double* upper,
                  double* lower, double* end);
    /// Sums of `count` rows of numbers: `combined` sums of the same rows, each with its own weight of a row. The
    /// numbers lie in panels of `combined` columns, row by row; weights are `combined` a row; sums lie one behind the
    /// other.
    void (*combine)(const double* panels, int count, int panel_count, const double* weights, double* sums);
    /// States at a rod's nodes, counted from its base, from the last one's; and where slopes are wanted two columns
    /// from the last one's rotations, with dn = dm = 0 there.
    void (*shoot_alone)(const RodAlone& rod, RodState<double>* node, Variation<double> (*column)[2]);
    LimbFunctions limbs;
};

/// The fastest kernel that this machine can run, or the one chosen by `use`.
const Kernel& kernel();
/// All that this machine can run, plainest first.
const std::vector<const Kernel*>& kernels();
/// Takes the kernel of that name from now on; raises std::invalid_argument when the machine has it not. For tests and
/// benchmarks: a choice while solves run on other threads leaves them with either.
void use(const std::string& instruction_set);

}  // namespace softlimb::rod::lanes
