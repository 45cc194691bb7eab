#pragma once
// Rows of an ordered sweep that were solved, and where they lead the next one.
#include <vector>

#include "softlimb/limb/moves.hpp"
#include "softlimb/limb/scene.hpp"

namespace softlimb::sweep {

/// Shapes of solved rows with their pressures. A row starts from the nearest of them; where others lie behind that one
/// on the line to the new pressures, from where the shapes along that line lead, by a parabola or straight on.
class Trail {
public:
    explicit Trail(int actuators) : actuators_(actuators) {}

    void clear() { count_ = 0; }
    /// `pressures` is looked at until the trail is cleared.
    void add(const double* pressures, limb::Shape shape);
    /// None of an empty trail; else good until the trail changes.
    const limb::Shape* start(const limb::Geometry& geometry, const double* pressures);

private:
    struct Row {
        const double* pressures;
        limb::Shape shape;
    };
    /// How far behind row `last` row `other` lies, in units of the step from `last` to the pressures asked for: zero
    /// where it lies aside, or too near or too far to say what comes at that distance.
    double behind(const Row& other, const Row& last, const double* pressures) const;

    int actuators_;
    std::size_t count_ = 0;
    std::vector<Row> rows_;  // the first `count_`; the others keep their memory
    limb::Shape ahead_;
};

}  // namespace softlimb::sweep
