#include "softlimb/solve/bounded_least_squares.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <vector>

namespace softlimb::solve {

using Eigen::MatrixXd, Eigen::VectorXd;

VectorXd bounded_least_squares(const MatrixXd& matrix, const VectorXd& right, const VectorXd& lower,
                               const VectorXd& upper) {
    enum class Place : char { free, at_lower, at_upper };
    const Eigen::Index n = matrix.cols();
    VectorXd x = VectorXd::Zero(n);
    // What stands on a bound stays there until its slope says otherwise.
    std::vector<Place> place(n, Place::free);
    for (Eigen::Index j = 0; j < n; ++j) {
        if (lower(j) >= 0.0)
            place[j] = Place::at_lower;
        else if (upper(j) <= 0.0)
            place[j] = Place::at_upper;
    }
    std::vector<char> kept(n, 0);  // entries that left their bound only to be sent back at once: rounding
    std::vector<Eigen::Index> free;
    MatrixXd columns(matrix.rows(), n);
    Eigen::ColPivHouseholderQR<MatrixXd> qr(matrix.rows(), n);
    Eigen::Index released = -1;
    // Each round fixes an entry or frees one; a handful of each is the rule.
    for (Eigen::Index round = 0; round < 10 * (n + 1); ++round) {
        free.clear();
        VectorXd rest = right;
        for (Eigen::Index j = 0; j < n; ++j) {
            if (place[j] == Place::free) {
                columns.col(static_cast<Eigen::Index>(free.size())) = matrix.col(j);
                free.push_back(j);
            } else {
                rest -= matrix.col(j) * x(j);
            }
        }
        const Eigen::Index count = static_cast<Eigen::Index>(free.size());
        VectorXd wanted;
        if (count > 0) wanted = qr.compute(columns.leftCols(count)).solve(rest);

        // As far as the first bound on the way.
        double share = 1.0;
        Eigen::Index first = -1;
        for (Eigen::Index k = 0; k < count; ++k) {
            const Eigen::Index j = free[k];
            const double bound = wanted(k) < lower(j) ? lower(j) : upper(j);
            if (wanted(k) >= lower(j) && wanted(k) <= upper(j)) continue;
            const double way = wanted(k) - x(j);
            const double part = way == 0.0 ? 0.0 : (bound - x(j)) / way;
            if (part < share || first < 0) share = std::max(part, 0.0), first = j;
        }
        for (Eigen::Index k = 0; k < count; ++k) x(free[k]) += share * (wanted(k) - x(free[k]));
        if (first >= 0) {
            const Eigen::Index k = std::find(free.begin(), free.end(), first) - free.begin();
            place[first] = wanted(k) < lower(first) ? Place::at_lower : Place::at_upper;
            x(first) = place[first] == Place::at_lower ? lower(first) : upper(first);
            if (first == released && share == 0.0) kept[first] = 1;
            released = -1;
            continue;
        }

        // The best on these bounds: is there one that holds back a decrease?
        const VectorXd slope = matrix.transpose() * (right - matrix * x);  // downhill
        double largest = 1e-15 * right.norm();                             // below it a slope is rounding
        released = -1;
        for (Eigen::Index j = 0; j < n; ++j) {
            if (place[j] == Place::free || kept[j] || lower(j) == upper(j)) continue;
            const double inwards = place[j] == Place::at_lower ? slope(j) : -slope(j);
            const double share_of_column = inwards / matrix.col(j).norm();
            if (share_of_column > largest) largest = share_of_column, released = j;
        }
        if (released < 0) break;
        place[released] = Place::free;
    }
    return x;
}

}  // namespace softlimb::solve
