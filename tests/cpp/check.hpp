#pragma once
// Claims of the C++ tests: a claim is a function whose name says what holds, and registers itself. A check that fails
// prints where, and the claim goes on, so that one run shows everything.
#include <cmath>
#include <cstdio>
#include <limits>
#include <type_traits>
#include <vector>

namespace softlimb::tests {

struct Claim {
    const char* name;
    void (*run)();
};

inline std::vector<Claim>& claims() {
    static std::vector<Claim> all;
    return all;
}
inline int failures = 0;

inline bool claim(const char* name, void (*run)()) {
    claims().push_back({name, run});
    return true;
}

inline void fail(const char* file, int line, const char* what, double found = 0.0, double allowed = 0.0) {
    ++failures;
    std::fprintf(stderr, "%s:%d: %s", file, line, what);
    if (allowed != 0.0) std::fprintf(stderr, " (off by %.3g, allowed %.3g)", found, allowed);
    std::fprintf(stderr, "\n");
}

/// Largest difference of two numbers or matrices; NaN where either is not finite.
template <class A, class B>
double difference(const A& a, const B& b) {
    if constexpr (std::is_arithmetic_v<A>) {
        return std::abs(a - b);
    } else {
        const auto gap = (a - b).eval();
        return gap.allFinite() ? gap.cwiseAbs().maxCoeff() : std::numeric_limits<double>::quiet_NaN();
    }
}

}  // namespace softlimb::tests

#define CLAIM(name)                                                                           \
    static void name();                                                                       \
    [[maybe_unused]] static const bool claimed_##name = softlimb::tests::claim(#name, &name); \
    static void name()

#define CHECK(condition)                                                         \
    do {                                                                         \
        if (!(condition)) softlimb::tests::fail(__FILE__, __LINE__, #condition); \
    } while (false)

/// A NaN on either side fails.
#define CHECK_NEAR(a, b, tolerance)                                                                          \
    do {                                                                                                     \
        const double found_ = softlimb::tests::difference(a, b), allowed_ = tolerance;                       \
        if (!(found_ <= allowed_)) softlimb::tests::fail(__FILE__, __LINE__, #a " = " #b, found_, allowed_); \
    } while (false)

#define CHECK_RAISES(Error, expression)                                                         \
    do {                                                                                        \
        bool raised_ = false;                                                                   \
        try {                                                                                   \
            static_cast<void>(expression);                                                      \
        } catch (const Error&) {                                                                \
            raised_ = true;                                                                     \
        }                                                                                       \
        if (!raised_) softlimb::tests::fail(__FILE__, __LINE__, #expression " raises " #Error); \
    } while (false)
