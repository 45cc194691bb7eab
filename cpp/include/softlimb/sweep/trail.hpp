#pragma once
// Rows of an ordered sweep that were solved, and where they lead the next one.
#include <optional>
#include <vector>

#include "softlimb/limb/moves.hpp"
#include "softlimb/limb/side_by_side.hpp"

namespace softlimb::sweep {

/// Pressures of solved rows. A row starts from the nearest of them; where others lie behind that one on the line to the
/// new pressures, from where these lead, by a parabola or straight on.
class Trail {
public:
    explicit Trail(int actuators = 0) : actuators_(actuators) {}

    void clear() { rows_.clear(); }
    /// `pressures` is looked at until the trail is cleared.
    void add(const double* pressures) { rows_.push_back(pressures); }
    std::size_t size() const { return rows_.size(); }

    /// The nearest row, and by which weights the differences of others to it are added: straight on with the first
    /// alone.
    struct Lead {
        std::size_t nearest = 0, other[2]{};
        int others = 0;
        double weight[2]{}, straight = 0.0;
    };
    /// None of an empty trail.
    std::optional<Lead> lead(const double* pressures) const;

private:
    /// How far behind row `last` row `other` lies, in units of the step from `last` to the pressures asked for: zero
    /// where it lies aside, or too near or too far to say what comes at that distance.
    double behind(const double* other, const double* last, const double* pressures) const;

    int actuators_;
    std::vector<const double*> rows_;
};

/// The shapes of such rows, on any meshes; shapes of other meshes than the nearest one's do not lead.
class ShapeTrail {
public:
    explicit ShapeTrail(int actuators) : trail_(actuators) {}

    void clear() { trail_.clear(); }
    /// `pressures` is looked at until the trail is cleared.
    void add(const double* pressures, limb::Shape shape);
    /// None of an empty trail; else good until the trail changes.
    const limb::Shape* start(const limb::Geometry& geometry, const double* pressures);

private:
    Trail trail_;
    std::vector<limb::Shape> shapes_;  // the others keep their memory
    limb::Shape ahead_;
};

/// The shapes of such rows on one mesh, as plain numbers (limb/side_by_side.hpp).
class NumberTrail {
public:
    void clear(int actuators) { trail_ = Trail(actuators); }
    /// `pressures` is looked at until the trail is cleared.
    void add(const double* pressures, const std::vector<double>& numbers);
    /// How a start was found: not at all, where the nearest row is, or where others lead on from it.
    enum class Led { none, nearest, on };
    Led start(const limb::Geometry& geometry, const limb::Mesh& mesh, const double* pressures,
              std::vector<double>& numbers) const;

private:
    Trail trail_;
    std::vector<std::vector<double>> numbers_;
};

}  // namespace softlimb::sweep
