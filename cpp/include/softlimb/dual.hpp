#pragma once
// Forward-mode derivatives: a value and its derivatives in N directions. The kernels that are templated on their
// scalar (laws, tubes, rods) give exact derivatives when they are called with Dual<N> instead of double.
#include <array>
#include <cmath>

namespace softlimb {

template <int N>
struct Dual {
    double value = 0.0;
    std::array<double, N> slope{};

    constexpr Dual() = default;
    constexpr Dual(double v) : value(v) {}  // NOLINT: a constant converts silently, as in the formulas
    constexpr Dual(double v, const std::array<double, N>& s) : value(v), slope(s) {}

    /// The variable number `direction`: slope one in that direction.
    static constexpr Dual variable(double v, int direction) {
        Dual x(v);
        x.slope[direction] = 1.0;
        return x;
    }

    Dual& operator+=(const Dual& b) { return *this = *this + b; }
    Dual& operator-=(const Dual& b) { return *this = *this - b; }
    Dual& operator*=(const Dual& b) { return *this = *this * b; }
    Dual& operator/=(const Dual& b) { return *this = *this / b; }

    /// f(x) for a scalar function with value f and derivative df at x.
    friend constexpr Dual chain(const Dual& x, double f, double df) {
        Dual y(f);
        for (int i = 0; i < N; ++i) y.slope[i] = df * x.slope[i];
        return y;
    }
    friend constexpr Dual operator+(const Dual& a, const Dual& b) {
        Dual c(a.value + b.value);
        for (int i = 0; i < N; ++i) c.slope[i] = a.slope[i] + b.slope[i];
        return c;
    }
    friend constexpr Dual operator-(const Dual& a, const Dual& b) {
        Dual c(a.value - b.value);
        for (int i = 0; i < N; ++i) c.slope[i] = a.slope[i] - b.slope[i];
        return c;
    }
    friend constexpr Dual operator-(const Dual& a) { return chain(a, -a.value, -1.0); }
    friend constexpr Dual operator+(const Dual& a) { return a; }
    friend constexpr Dual operator*(const Dual& a, const Dual& b) {
        Dual c(a.value * b.value);
        for (int i = 0; i < N; ++i) c.slope[i] = a.slope[i] * b.value + a.value * b.slope[i];
        return c;
    }
    friend constexpr Dual operator/(const Dual& a, const Dual& b) {
        const double inverse = 1.0 / b.value, quotient = a.value * inverse;
        Dual c(quotient);
        for (int i = 0; i < N; ++i) c.slope[i] = (a.slope[i] - quotient * b.slope[i]) * inverse;
        return c;
    }
    friend constexpr bool operator<(const Dual& a, const Dual& b) { return a.value < b.value; }
    friend constexpr bool operator>(const Dual& a, const Dual& b) { return a.value > b.value; }
    friend constexpr bool operator<=(const Dual& a, const Dual& b) { return a.value <= b.value; }
    friend constexpr bool operator>=(const Dual& a, const Dual& b) { return a.value >= b.value; }

    friend Dual sqrt(const Dual& x) {
        const double root = std::sqrt(x.value);
        return chain(x, root, 0.5 / root);
    }
    friend Dual exp(const Dual& x) {
        const double e = std::exp(x.value);
        return chain(x, e, e);
    }
    friend Dual log(const Dual& x) { return chain(x, std::log(x.value), 1.0 / x.value); }
    friend Dual sin(const Dual& x) { return chain(x, std::sin(x.value), std::cos(x.value)); }
    friend Dual cos(const Dual& x) { return chain(x, std::cos(x.value), -std::sin(x.value)); }
    friend Dual pow(const Dual& x, double p) {
        const double lower = std::pow(x.value, p - 1.0);
        return chain(x, lower * x.value, p * lower);
    }
};

/// The plain value behind a scalar of any kind.
inline double value_of(double x) { return x; }
template <int N>
double value_of(const Dual<N>& x) {
    return x.value;
}

}  // namespace softlimb
