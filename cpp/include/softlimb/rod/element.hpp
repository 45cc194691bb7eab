#pragma once
// A piece of rod between two nodes, linearised: the wrenches that it exerts on the nodes and their derivatives to the
// nodes' poses. Two kinds fill the same struct: the exact element (shooting through the rod equations) for the
// solution, and the geodesic element (constant strain on SE(3)) for the descent from a far start.
// All quantities in base axes; node variations are (dp, dtheta). Source: cpp/MECHANICS.md, "Element".
#include <Eigen/LU>
#include <vector>

#include "softlimb/rod/integrators.hpp"
#include "softlimb/rod/kernel.hpp"
#include "softlimb/rod/lanes/pieces.hpp"
#include "softlimb/se3.hpp"

namespace softlimb::rod {

/// Generalised forces (first node, second node) needed to hold the nodes, and their derivative. At equilibrium the
/// force on the first node is minus the internal wrench there, that on the second plus the internal wrench.
struct ElementStiffness {
    Vector12 force;
    Matrix12 stiffness;
};

/// What a rod is made of between its plates, uniform along it.
struct RodPiece {
    const Section* section;
    double length;  // rest length of the piece [m]
    LineLoad<double> load;

    bool loaded() const { return !is_zero(load); }
};

/// Order and number of steps of the integration through one piece.
struct Integration {
    int order = 6;
    int steps = 1;
};

struct EndState {
    Pose pose;
    Vector6 wrench;  // internal (n, m)

    /// Where the lanes put it.
    lanes::End target() { return {pose.position.data(), pose.rotation.data(), wrench.data()}; }
};

/// Integrates the state alone from the base of the piece to its end.
EndState end_of(const RodPiece& piece, const Pose& base, const Vector6& base_wrench, Integration integration);

/// States at `fractions` of the piece (ascending, 0..1), for drawing; appended to `out`.
void states_along(const RodPiece& piece, const Pose& base, const Vector6& base_wrench, Integration integration,
                  const double* fractions, int count, EndState* out);

/// Derivative of the end pose (dp, dtheta) and end wrench to one parameter: base pose and base wrench fixed, the
/// section and the length varying as given, the weight per length with the section's mass.
struct EndSlope {
    Vector6 pose, wrench;
};
EndSlope end_slope(const RodPiece& piece, const Section& section_slope, double length_slope,
                   const Vector3& line_force_slope, const Pose& base, const Vector6& base_wrench,
                   Integration integration);

/// Derivative of the end pose (dp, dtheta) to base pose (dp, dtheta) and base wrench.
Eigen::Matrix<double, 6, 12> end_columns(const RodPiece& piece, const Pose& base, const Vector6& base_wrench,
                                         Integration integration);

/// The exact element: Newton on "the piece, shot from the first node with base wrench w, ends on the second node".
/// One call linearises at the present w; `update` moves w once the nodes have moved.
class ExactElement {
public:
    /// Fills `out` (the mismatch of the end is condensed into its forces). False when something is not finite or the
    /// map wrench -> end pose is singular (a conjugate point).
    bool linearise(const RodPiece& piece, const Pose& first, const Pose& second, const Vector6& base_wrench,
                   Integration integration, ElementStiffness& out);
    /// The same in a lane beside other pieces: what the kernel fills; `out` as above.
    lanes::Linear target(const Pose& second, ElementStiffness& out);
    /// Whether the last linearisation is finite and could be inverted.
    bool regular() const { return regular_; }
    /// Change of the base wrench when the nodes move by the given variations and the end misses its node by `gap`.
    Vector6 wrench_change(const Vector6& first, const Vector6& second, const Vector6& gap) const;
    /// Change of the base wrench that closes the mismatch `gap` of the end pose (dp, dtheta), nodes fixed.
    Vector6 wrench_for_gap(const Vector6& gap) const { return -(end_by_wrench_inverse_ * gap); }
    /// End pose of the piece minus the second node: (dp, rotation vector), at linearisation.
    const Vector6& gap() const { return gap_; }
    const EndState& end() const { return end_; }
    const Matrix6& end_wrench_by_base_wrench() const { return wrench_by_wrench_; }

private:
    EndState end_;
    Vector6 gap_;
    Matrix6 end_by_pose_, end_by_wrench_inverse_, wrench_by_wrench_;
    bool regular_ = false;
};

/// Pieces to be integrated side by side, all added in the same way. Filled, run, cleared; `reserve` makes room once.
class Batch {
public:
    void reserve(int pieces);
    void clear();
    void add(const RodPiece& piece, const Pose& base, const Vector6& base_wrench);
    /// With its linearisation.
    void add(const RodPiece& piece, const Pose& base, const Vector6& base_wrench, const lanes::Linear& out) {
        add(piece, base, base_wrench);
        linear_.push_back(out);
    }
    /// With its end.
    void add(const RodPiece& piece, const Pose& base, const Vector6& base_wrench, EndState& end) {
        add(piece, base, base_wrench);
        ends_.push_back(end.target());
    }
    /// With the derivative of its end, as `end_slope` gives it.
    void add(const RodPiece& piece, const Pose& base, const Vector6& base_wrench, const Section& section_slope,
             double length_slope, const Vector3& line_force_slope, EndSlope& end);
    /// Integrates all that was added, `steps` steps of the eighth-order method each.
    void run(int steps) const;

private:
    std::vector<lanes::Start> starts_;
    std::vector<lanes::Linear> linear_;
    std::vector<lanes::End> ends_;
    std::vector<lanes::Slope> slopes_;
    std::vector<lanes::EndSlopes> end_slopes_;
    lanes::Loads loads_ = lanes::Loads::none;
};

/// Mismatch of two poses: (p_a - p_b, rotation vector of R_a R_b^T), base axes.
Vector6 pose_gap(const Pose& a, const Pose& b);

/// The geodesic element: strain constant along the SE(3) geodesic between the nodes, quadratic energy of the section's
/// tangent stiffness, distributed load lumped on the nodes. An energy of the nodes alone, so that a descent can trust
/// it. The energy [J] has the potential of the lumped forces in it; lumped moments have none and enter the forces only.
/// `twist` is log(first^-1 second), `positions` the sum of the two nodes'.
double geodesic_energy(const RodPiece& piece, const Vector6& twist, const Vector3& positions);
void geodesic_element(const RodPiece& piece, const Pose& first, const Pose& second, ElementStiffness& out);
/// The same in a lane beside other elements: what the kernel asks for; the nodes' rotations must outlive it.
lanes::Geodesic geodesic_lane(const RodPiece& piece, const Vector6& twist, const Matrix3& first, const Matrix3& second);
/// Base wrench and strains of the geodesic between the nodes: the start of the exact element.
Vector6 geodesic_base_wrench(const RodPiece& piece, const Pose& first, const Pose& second);

}  // namespace softlimb::rod
