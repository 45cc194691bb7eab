#pragma once
// Numbers by which Newton on a limb judges its steps: the same for one limb (limb/equilibrium.cpp) and for limbs side
// by side (rod/lanes/rounds.ipp). Source: cpp/MECHANICS.md, "Newton".
namespace softlimb::solve {

/// Of a wrench's relative error in the error of the tip: it enters the tip through the compliance, but a stiff rod may
/// still push its error of position into a force.
constexpr double wrench_in_tip = 1e-3;

/// Bound on a step: rotations [rad], and translations over half a rod.
constexpr double largest_turn = 0.5;

/// How much a move changes the stiffness of the plates, over forces times the limb's length. Eigenvalues near zero
/// change by less than 0.03 of that in 500 random postures of the reference limb, and ten times as much is allowed for.
constexpr double stiffness_by_move = 0.3;

/// Where forces have long arms against the moments, as under strong tension, an error of position weighs more: by this
/// share of the forces' arm over the moments.
constexpr double force_arm = 0.05;

/// A correction with the stiffness at hand leaves about this times the step since it was taken.
constexpr double left_by_chord = 4.0;

}  // namespace softlimb::solve
