#pragma once
// Starts for the rows of a long sweep: polynomials fitted to some of its rows that are solved. Shapes are described
// segment by segment in the frame that each stands on. There a segment depends on its own rods, on the way that the
// loads point, and on the segments beyond it. Source: cpp/MECHANICS.md, "Starts of a long sweep".
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
    /// Polynomials of one segment. Its variables are the rest lengths of its rods, the direction of the loads seen from
    /// its footing where there is one that may turn, and the rest lengths of the rods beyond it. The first term is one;
    /// each other is an earlier one times a variable.
    struct Sheet {
        std::vector<int> earlier, variable;  // of the terms after the first
        std::vector<double> coefficients;    // a row a term: what the start is a sum of
        std::size_t terms() const { return earlier.size() + 1; }
    };
    /// Everything that an atlas is, as plain numbers that may travel.
    struct Content {
        limb::Mesh mesh;
        std::vector<int> first_rod;         // of each segment, and behind the last
        std::vector<double> direction;      // of the loads, base axes, three numbers; or none
        std::vector<double> middle, scale;  // of each rod's rest length [m]; scale 0 where it does not vary
        std::vector<Sheet> sheets;          // one a segment
    };

    explicit Atlas(Content content);
    /// Fits the anchors; none where they are too few, or their rods too long for a mesh that all share. Without `mesh`
    /// it is chosen by them.
    static std::optional<Atlas> fitted(const limb::Geometry& geometry, const std::vector<Anchor>& anchors,
                                       double tolerance, const limb::Mesh* mesh = nullptr);

    const Content& content() const { return content_; }
    const limb::Mesh& mesh() const { return content_.mesh; }
    /// Starts that are found at once.
    static constexpr int together = rod::lanes::combined;
    /// Room for `starts`, and what it finds: numbers of the shapes to start from (limb/side_by_side.hpp).
    struct Room {
        std::vector<double> variables, terms, outputs, numbers[together];
    };
    /// Starts for `count` limbs, `together` at most, by their rods.
    void starts(const limb::Geometry& geometry, const std::vector<limb::RodAtPressure>* const* rods, int count,
                Room& room) const;

private:
    /// Coefficients as Kernel::combine wants them.
    struct Panels {
        std::vector<double> numbers;
        std::size_t count = 0;
    };
    std::size_t variables(std::size_t segment) const;
    /// Variables of a segment, `together` apart, given the plate that it stands on.
    void fill_variables(std::size_t segment, const std::vector<limb::RodAtPressure>& rods, const Matrix3* footing,
                        double* to) const;
    void fill_terms(const Sheet& sheet, const double* variables, double* terms) const;
    /// A segment from its sums, into the numbers of a shape.
    void decode(const limb::Geometry& geometry, int segment, const double* sums, double* numbers) const;

    Content content_;
    std::vector<std::size_t> rod_at_;  // where each rod's numbers are
    std::vector<Panels> panels_;       // one a segment
};

}  // namespace softlimb::sweep
