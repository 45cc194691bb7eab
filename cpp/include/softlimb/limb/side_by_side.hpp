#pragma once
// Limbs of one geometry and one mesh solved side by side, one a lane: Newton from starts that are near. A limb that
// does not converge here, or not to a posture that is surely stable, is for limb::solve. Source: cpp/MECHANICS.md,
// "Limbs side by side".
#include <memory>
#include <vector>

#include "softlimb/limb/scene.hpp"
#include "softlimb/rod/lanes/pieces.hpp"

namespace softlimb::limb {

/// Pieces of each rod, and steps through each.
struct Mesh {
    std::vector<int> elements, steps;
};

/// An equilibrium on another mesh: nodes and wrenches where its rods, integrated, have them.
Shape on_mesh(const Geometry& geometry, const Scene& scene, const Shape& shape, const Mesh& mesh);

/// A shape as plain numbers: plates and nodes as position and rotation by columns, wrenches; see LimbPlan::numbers.
std::size_t numbers_of(const Geometry& geometry, const Mesh& mesh);
/// The plates alone, which come first.
void numbers_to_plates(const Geometry& geometry, const double* numbers, std::vector<Pose>& plates);
void numbers_to_shape(const Geometry& geometry, const Mesh& mesh, const double* numbers, Shape& shape);
void shape_to_numbers(const Shape& shape, std::vector<double>& numbers);
/// Makes what is nearly a rotation one, in all poses.
void make_orthonormal(const Geometry& geometry, const Mesh& mesh, double* numbers);

class SideBySide {
public:
    /// The loads of `scene` are those of all limbs, its sections and rest lengths are not looked at. It must not hold
    /// any plate. `corrections` by the stiffness at hand follow every step, for all lanes if one wants them: they serve
    /// where most starts are some way off. Works with the kernel that is in use now.
    SideBySide(const Geometry& geometry, const Scene& scene, const Mesh& mesh, double tolerance, int corrections = 1);

    int width() const { return kernel_.lanes; }
    /// Puts a limb into a lane: its scene, and the numbers of the shape that it starts from. One that was taken while
    /// it was running goes on with the report that it had.
    void fill(int lane, const Scene& scene, const double* start, const rod::lanes::LaneReport* so_far = nullptr);
    /// A step of every limb.
    void round() { kernel_.limbs.round(plan_, room_.get()); }
    rod::lanes::LaneReport report(int lane) const { return kernel_.limbs.report(plan_, room_.get(), lane); }
    /// Takes the limb out of a lane: the numbers of its shape.
    void take(int lane, double* numbers) { kernel_.limbs.take(plan_, room_.get(), lane, numbers); }

private:
    struct Free {
        void operator()(void* room) const;
    };
    const Geometry& geometry_;
    const rod::lanes::Kernel& kernel_;
    std::vector<rod::lanes::LimbRod> rods_;
    std::vector<rod::lanes::LimbPlate> plates_;
    rod::lanes::LimbPlan plan_;
    std::unique_ptr<void, Free> room_;
    std::vector<const Section*> sections_;
    std::vector<double> lengths_, loads_;
};

}  // namespace softlimb::limb
