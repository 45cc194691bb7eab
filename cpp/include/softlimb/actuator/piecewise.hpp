#pragma once
// Smooth functions of one number as Chebyshev polynomials, piece by piece: evaluated in tens of nanoseconds where each
// value behind them took a solve. Source: cpp/MECHANICS.md, "Tables".
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <vector>

namespace softlimb::actuator {

/// Chebyshev's nodes on [-1, 1] and the matrix that takes values there to coefficients.
struct ChebyshevRule {
    /// A tube takes two to four pieces of twenty nodes. Of sixteen it takes twice as many, of eight thirty times.
    static constexpr int nodes = 20;
    std::array<double, nodes> node;
    std::array<std::array<double, nodes>, nodes> weight;  // [coefficient][node]

    ChebyshevRule() {
        for (int j = 0; j < nodes; ++j) {
            const double angle = std::numbers::pi * (j + 0.5) / nodes;
            node[j] = -std::cos(angle);
            // T_k(-x) = (-1)^k T_k(x)
            for (int k = 0; k < nodes; ++k)
                weight[k][j] = (k == 0 ? 1.0 : k % 2 ? -2.0 : 2.0) / nodes * std::cos(k * angle);
        }
    }
};

inline const ChebyshevRule& chebyshev_rule() {
    static const ChebyshevRule rule;
    return rule;
}

/// T_k(u), every second one from the two before it: T_{k+2} = 2 T_2 T_k - T_{k-2}. Neither the even nor the odd ones
/// wait for the others.
struct ChebyshevTerms {
    static constexpr int nodes = ChebyshevRule::nodes;
    std::array<double, nodes> value;

    explicit ChebyshevTerms(double u) {
        const double twice_second = 2.0 * (2.0 * u * u - 1.0);
        value[0] = 1.0, value[1] = u, value[2] = 0.5 * twice_second, value[3] = (twice_second - 1.0) * u;
        for (int k = 4; k < nodes; ++k) value[k] = twice_second * value[k - 2] - value[k - 4];
    }
    /// T_k'(u) = k U_{k-1}(u), which has the same recurrence.
    std::array<double, nodes> slopes() const {
        const double u = value[1], twice_second = 2.0 * value[2];
        std::array<double, nodes> slope;
        slope[0] = 0.0, slope[1] = 1.0, slope[2] = 2.0 * u, slope[3] = twice_second + 1.0;
        for (int k = 4; k < nodes; ++k) slope[k] = twice_second * slope[k - 2] - slope[k - 4];
        for (int k = 2; k < nodes; ++k) slope[k] *= k;
        return slope;
    }
};

/// `count` functions of x. Constant once fitted; knows where it has no values.
template <std::size_t count>
class Piecewise {
public:
    using Values = std::array<double, count>;
    /// What a function says of its values at x: themselves, and how far from them the table may be.
    struct Sample {
        Values value{}, allowed{};
    };

    /// Halves the range until every piece meets the function; where `most_samples` are spent or a piece is a hundredth
    /// of the range (a corner, a limit point) it stays without values. `sample(x, near, out)` is false where there are
    /// none; `near` points to values close to the answer, or is null.
    template <class Function>
    void fit(double from, double to, int most_samples, Function&& sample) {
        pieces_.clear();
        if (!(to > from)) return;
        constexpr int most_halvings = 7;
        const double middle = 0.5 * (from + to);
        split(from, middle, nullptr, most_halvings - 1, most_samples, sample);
        split(middle, to, nullptr, most_halvings - 1, most_samples, sample);
    }

    std::size_t pieces() const { return pieces_.size(); }

    /// Values at x, of the first functions where not all are wanted; false where there are none.
    template <std::size_t wanted>
    bool at(double x, std::array<double, wanted>& y) const {
        const Piece* piece = piece_at(x);
        if (piece) y = piece->template at<wanted>(x);
        return piece != nullptr;
    }
    /// With their derivatives, which lose up to three digits to the values: an error of a polynomial of degree n may
    /// have n^2 times its size over the half width of a piece for a slope.
    template <std::size_t wanted>
    bool at(double x, std::array<double, wanted>& y, std::array<double, wanted>& slope) const {
        const Piece* piece = piece_at(x);
        if (piece) y = piece->at(x, slope);
        return piece != nullptr;
    }

private:
    static constexpr int nodes = ChebyshevRule::nodes;

    struct Piece {
        double from, to, centre, per_half;
        std::array<Values, nodes> coefficient;

        // Sums of T_k(u), all functions side by side so that the compiler packs them. The largest term comes last.
        template <std::size_t wanted = count>
        std::array<double, wanted> at(double x) const {
            const ChebyshevTerms terms((x - centre) * per_half);
            std::array<double, wanted> y{};
            for (int k = 1; k < nodes; ++k)
                for (std::size_t i = 0; i < wanted; ++i) y[i] += terms.value[k] * coefficient[k][i];
            for (std::size_t i = 0; i < wanted; ++i) y[i] += coefficient[0][i];
            return y;
        }
        template <std::size_t wanted>
        std::array<double, wanted> at(double x, std::array<double, wanted>& slope) const {
            const ChebyshevTerms terms((x - centre) * per_half);
            const std::array<double, nodes> slopes = terms.slopes();
            std::array<double, wanted> y{}, s{};
            for (int k = 1; k < nodes; ++k)
                for (std::size_t i = 0; i < wanted; ++i) {
                    y[i] += terms.value[k] * coefficient[k][i];
                    s[i] += slopes[k] * coefficient[k][i];
                }
            for (std::size_t i = 0; i < wanted; ++i) y[i] += coefficient[0][i], slope[i] = per_half * s[i];
            return y;
        }
    };

    const Piece* piece_at(double x) const {
        const auto piece =
            std::lower_bound(pieces_.begin(), pieces_.end(), x, [](const Piece& p, double v) { return p.to < v; });
        return piece == pieces_.end() || !(x >= piece->from) ? nullptr : &*piece;
    }

    template <class Function>
    void split(double from, double to, const Piece* parent, int halvings, int& samples_left, Function& sample) {
        Piece piece;
        bool sampled = false;
        if (try_piece(from, to, parent, samples_left, sample, piece, sampled)) {
            pieces_.push_back(piece);
        } else if (halvings > 0 && samples_left > 0) {
            // A polynomial that is not good enough is still a good first guess.
            const Piece* known = sampled ? &piece : parent;
            const double middle = 0.5 * (from + to);
            split(from, middle, known, halvings - 1, samples_left, sample);
            split(middle, to, known, halvings - 1, samples_left, sample);
        }
    }

    template <class Function>
    static bool try_piece(double from, double to, const Piece* parent, int& samples_left, Function& sample,
                          Piece& piece, bool& sampled) {
        // Next to the ends and in the middle, between nodes, the polynomial errs most.
        constexpr std::array tests = {-0.988, 0.078, 0.988};
        if ((samples_left -= nodes + static_cast<int>(tests.size())) < 0) return false;
        const ChebyshevRule& rule = chebyshev_rule();
        const double centre = 0.5 * (from + to), half = 0.5 * (to - from);
        piece.from = from, piece.to = to, piece.centre = centre, piece.per_half = 1.0 / half;
        const auto sample_at = [&](double x, const Piece* known, Sample& out) {
            if (!known) return sample(x, static_cast<const Values*>(nullptr), out);
            const Values near = known->at(x);
            return sample(x, &near, out);
        };
        std::array<Values, nodes> value;
        Values allowed{};
        for (int j = 0; j < nodes; ++j) {
            Sample at;
            if (!sample_at(centre + half * rule.node[j], parent, at)) return false;
            value[j] = at.value;
            for (std::size_t i = 0; i < count; ++i) allowed[i] = std::max(allowed[i], at.allowed[i]);
        }
        sampled = true;
        for (int k = 0; k < nodes; ++k) {
            Values& c = piece.coefficient[k];
            c = {};
            for (int j = 0; j < nodes; ++j)
                for (std::size_t i = 0; i < count; ++i) c[i] += rule.weight[k][j] * value[j][i];
        }
        for (std::size_t i = 0; i < count; ++i)
            for (int k = nodes - 2; k < nodes; ++k)
                if (!(std::abs(piece.coefficient[k][i]) <= allowed[i])) return false;
        for (const double test : tests) {
            Sample at;
            const double x = centre + half * test;
            if (!sample_at(x, &piece, at)) return false;
            const Values found = piece.at(x);
            for (std::size_t i = 0; i < count; ++i)
                if (!(std::abs(found[i] - at.value[i]) <= 2.0 * allowed[i])) return false;
        }
        return true;
    }

    std::vector<Piece> pieces_;
};

}  // namespace softlimb::actuator
