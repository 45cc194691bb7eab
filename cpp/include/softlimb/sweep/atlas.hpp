#pragma once
// Starts for the rows of a long sweep: polynomials in the rods' rest lengths, fitted to some of its rows that were
// solved from nothing. Shapes are described segment by segment in the frame that each stands on, where they depend on
// the rods of other segments through their loads alone. Source: cpp/MECHANICS.md, "Starts of a long sweep".
#include <optional>
#include <string>
#include <vector>

#include "softlimb/limb/side_by_side.hpp"

namespace softlimb::sweep {

/// A row that was solved: what an atlas is fitted to.
struct Anchor {
    limb::Scene scene;  // its rods at their pressures
    limb::Shape shape;
};

class Atlas {
public:
    /// Everything that an atlas is, as plain numbers that may travel.
    struct Content {
        limb::Mesh mesh;
        std::vector<double> middle, scale;  // of each rod's rest length [m]; scale 0 where it does not vary
        std::vector<int> powers;            // of each rod, a row a term
        std::vector<double> coefficients;   // a row a term: what the start is a sum of
    };

    explicit Atlas(Content content);
    /// Fits the anchors; none where they are too few, or their rods too long for a mesh that all share.
    static std::optional<Atlas> fitted(const limb::Geometry& geometry, const std::vector<Anchor>& anchors,
                                       double tolerance);

    const Content& content() const { return content_; }
    const limb::Mesh& mesh() const { return content_.mesh; }
    /// Starts that are found at once.
    static constexpr int together = rod::lanes::combined;
    /// Room for `starts`, and what it finds: numbers of the shapes to start from (limb/side_by_side.hpp).
    struct Room {
        std::vector<double> powers, terms, outputs, numbers[together];
        std::vector<Pose> plates;
    };
    /// Starts for `count` limbs, `together` at most, by their rods.
    void starts(const limb::Geometry& geometry, const std::vector<limb::RodAtPressure>* const* rods, int count,
                Room& room) const;

private:
    /// Terms of one limb, `together` apart.
    void fill_terms(const std::vector<limb::RodAtPressure>& rods, Room& room, double* terms) const;
    void decode(const limb::Geometry& geometry, const double* outputs, Room& room, double* numbers) const;

    Content content_;
    std::vector<int> degree_;     // highest power of each rod
    std::vector<double> panels_;  // the coefficients as Kernel::combine wants them
    std::size_t terms_ = 0, outputs_ = 0, panel_count_ = 0;
};

}  // namespace softlimb::sweep
