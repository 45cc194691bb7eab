#pragma once
#include <array>

namespace softlimb::rod {

/// The classical method of order 4: the reference that the others are tested against.
struct Rk4 {
    static constexpr int stages = 4, order = 4;
    static constexpr std::array<std::array<double, 4>, 4> a = {{{0}, {0.5}, {0, 0.5}, {0, 0, 1.0}}};
    static constexpr std::array<double, 4> b = {1.0 / 6.0, 1.0 / 3.0, 1.0 / 3.0, 1.0 / 6.0};
    static constexpr std::array<double, 4> c = {0, 0.5, 0.5, 1.0};
};

}  // namespace softlimb::rod
