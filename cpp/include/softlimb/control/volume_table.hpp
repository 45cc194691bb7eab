#pragma once
// Volume of a chamber over its gauge pressure, from a table of the tube's own answers.
#include <vector>

namespace softlimb::control {

/// Monotone cubic pieces (slopes by Fritsch and Carlson) between the table's points; beyond its ends exponential, which
/// keeps value and slope and stays positive.
class VolumeTable {
public:
    /// Raises std::invalid_argument unless there are two points at least, pressures rise, and volumes are positive and
    /// do not fall.
    VolumeTable(std::vector<double> pressures, std::vector<double> volumes);

    struct Value {
        double volume, slope;
    };
    Value at(double pressure) const;
    double lowest() const { return pressures_.front(); }
    double highest() const { return pressures_.back(); }

private:
    std::vector<double> pressures_, volumes_, slopes_;
};

}  // namespace softlimb::control
