#pragma once
// What a limb is (geometry, constant) and what is asked of it (rods at their pressures, loads, holds).
// Source: Zhang et al. eq. 7-10; cpp/MECHANICS.md, "Limb".
#include <array>
#include <vector>

#include "softlimb/rod/element.hpp"
#include "softlimb/se3.hpp"
#include "softlimb/section.hpp"

namespace softlimb::limb {

/// Where a rod stands: its base in the frame of the proximal plate's distal face, its end in the distal plate's frame.
struct Placement {
    Pose base, end;
    bool operator==(const Placement&) const = default;
};

/// Rods in parallel and the plate at their end. The plate's frame lies on the face where the rods end; the next rods
/// start `thickness` further along its z axis; its centre of mass is half way.
struct Segment {
    std::vector<Placement> rods;
    double plate_thickness = 0.0;  // [m]
    double plate_mass = 0.0;       // [kg]
    bool operator==(const Segment&) const = default;
};

struct Geometry {
    std::vector<Segment> segments;
    double length = 0.0;  // unpressurised rods plus the plates between them [m]: what relative errors refer to

    bool operator==(const Geometry&) const = default;
    int plates() const { return static_cast<int>(segments.size()); }
    int rods() const {
        int count = 0;
        for (const Segment& s : segments) count += static_cast<int>(s.rods.size());
        return count;
    }
    /// Frame on the far side of plate j, where the next rods stand.
    Pose distal_face(int j, const Pose& plate) const;
    /// Frame on which the rods of segment j stand: the base, or the distal face of plate j-1.
    Pose footing(int j, const std::vector<Pose>& plates) const;
};

/// A rod as it is at its pressure.
struct RodAtPressure {
    Section section;
    double rest_length = 0.0;         // [m]
    rod::LineLoad<double> line_load;  // per rest length, weight not included
};

/// Freedoms of a plate that are held: three translations and three rotations about base axes, relative to `pose`.
struct Hold {
    std::array<bool, 6> held{};
    Pose pose;
    bool any() const { return held[0] || held[1] || held[2] || held[3] || held[4] || held[5]; }
    bool all() const { return held[0] && held[1] && held[2] && held[3] && held[4] && held[5]; }
    /// Some rotations are held and some are free: the held direction turns with the plate.
    bool partly_turned() const { return (held[3] || held[4] || held[5]) && !(held[3] && held[4] && held[5]); }
};

struct Scene {
    std::vector<RodAtPressure> rods;  // segment by segment
    Vector3 gravity = Vector3::Zero();
    std::vector<Vector6> wrenches;  // on each plate, about its origin
    bool following = false;         // wrenches turn with their plates (given in plate axes)
    std::vector<Hold> holds;        // one a plate

    /// Load per rest length of rod i, its weight included.
    rod::LineLoad<double> line_load(int i) const;
    /// Some rod carries a load between its ends, its weight included.
    bool loads_rods() const;
    /// Some freedom of some plate is held.
    bool holds_plates() const;
    /// No potential exists: a dead moment or a following wrench on a plate that may turn, or a distributed moment.
    bool conservative() const;
};

/// Nodes and internal wrenches of a rod: elements() + 1 node poses, a base wrench (n, m) an element, base axes.
struct RodShape {
    std::vector<Pose> nodes;
    std::vector<Vector6> wrenches;
    rod::Integration integration{8, 1};  // through each element
    int elements() const { return static_cast<int>(wrenches.size()); }
};

struct Shape {
    std::vector<Pose> plates;
    std::vector<RodShape> rods;
    /// Of all rods together.
    int pieces() const {
        int count = 0;
        for (const RodShape& rod : rods) count += rod.elements();
        return count;
    }
};

/// Puts the first and last node of every rod where the plates say.
void attach_rods(const Geometry& geometry, Shape& shape);

}  // namespace softlimb::limb
