#pragma once
// Inverses of 6 x 6 blocks: the unit of work of chains and plates. Eigen's fixed-size inverse goes through its blocked
// routines from five rows on and takes about five times as long (tests/cpp/test_block6.cpp holds it as the reference).
#include <Eigen/Core>
#include <cmath>

namespace softlimb::solve {

using Block6 = Eigen::Matrix<double, 6, 6>;

/// Gauss and Jordan in place, with row pivoting. False when a pivot vanishes or something is not finite.
inline bool invert(const Block6& matrix, Block6& inverse) {
    inverse = matrix;
    double (&a)[36] = *reinterpret_cast<double (*)[36]>(inverse.data());  // a[6 column + row]
    int swapped[6];
    for (int k = 0; k < 6; ++k) {
        int best = k;
        for (int r = k + 1; r < 6; ++r)
            if (std::abs(a[6 * k + r]) > std::abs(a[6 * k + best])) best = r;
        swapped[k] = best;
        if (best != k)
            for (int c = 0; c < 6; ++c) std::swap(a[6 * c + k], a[6 * c + best]);
        const double pivot = a[6 * k + k];
        if (!(std::abs(pivot) > 0.0) || !std::isfinite(pivot)) return false;
        const double scale = 1.0 / pivot;
        double column[6];
        for (int r = 0; r < 6; ++r) column[r] = a[6 * k + r], a[6 * k + r] = 0.0;
        column[k] = 0.0, a[6 * k + k] = 1.0;
        for (int c = 0; c < 6; ++c) {
            const double row = a[6 * c + k] * scale;
            for (int r = 0; r < 6; ++r) a[6 * c + r] -= column[r] * row;
            a[6 * c + k] = row;
        }
    }
    for (int k = 5; k >= 0; --k)
        if (swapped[k] != k)
            for (int r = 0; r < 6; ++r) std::swap(a[6 * k + r], a[6 * swapped[k] + r]);
    double sum = 0.0;
    for (double x : a) sum += 0.0 * x;
    return sum == 0.0;
}

/// Cholesky's factor of the lower triangle: false when the block is not positive definite, NaN included.
inline bool cholesky(const Block6& matrix, Block6& lower) {
    for (int k = 0; k < 6; ++k) {
        double column[6];
        for (int r = k; r < 6; ++r) column[r] = matrix(r, k);
        for (int j = 0; j < k; ++j) {
            const double factor = lower(k, j);
            for (int r = k; r < 6; ++r) column[r] -= factor * lower(r, j);
        }
        if (!(column[k] > 0.0) || !(column[k] < 1e308)) return false;
        const double scale = 1.0 / std::sqrt(column[k]);
        for (int r = k; r < 6; ++r) lower(r, k) = column[r] * scale;
    }
    return true;
}

/// Inverse of a symmetric positive definite block (its lower triangle is read); false when it is not one.
inline bool invert_positive(const Block6& matrix, Block6& inverse) {
    Block6 l, m;
    if (!cholesky(matrix, l)) return false;
    // m = l^-1, column by column, then the inverse is m^T m.
    for (int c = 0; c < 6; ++c) {
        double x[6] = {};
        x[c] = 1.0 / l(c, c);
        for (int r = c + 1; r < 6; ++r) {
            double sum = 0.0;
            for (int j = c; j < r; ++j) sum -= l(r, j) * x[j];
            x[r] = sum / l(r, r);
        }
        for (int r = 0; r < 6; ++r) m(r, c) = x[r];
    }
    double finite = 0.0;
    for (int c = 0; c < 6; ++c)
        for (int r = c; r < 6; ++r) {
            double sum = 0.0;
            for (int j = r; j < 6; ++j) sum += m(j, r) * m(j, c);
            inverse(r, c) = inverse(c, r) = sum;
            finite += 0.0 * sum;
        }
    return finite == 0.0;
}

}  // namespace softlimb::solve
