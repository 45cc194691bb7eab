#pragma once
// What the controllers need of numbers. Freestanding, as pid.hpp, neural_pid.hpp and guard.hpp: C++17 without standard
// library, heap, exceptions or type information, for `float` and `double`. The same files compile for a
// microcontroller.

namespace softlimb {
namespace control {

/// False for NaN and infinity. The subtraction needs no library; do not compile it with -ffast-math.
template <class Real>
constexpr bool is_finite(Real x) {
    return x - x == Real(0);
}

template <class Real>
constexpr Real magnitude(Real x) {
    return x < Real(0) ? -x : x;
}

template <class Real>
constexpr Real within(Real x, Real low, Real high) {
    return x < low ? low : (x > high ? high : x);
}

}  // namespace control
}  // namespace softlimb
