#pragma once
#include <array>

namespace softlimb::rod {

/// Order 6 in seven stages. Coefficients: J. C. Butcher, "On Runge-Kutta processes of high order", J. Austral. Math.
/// Soc. 4 (1964) 179-194.
struct Rk6 {
    static constexpr int stages = 7, order = 6;
    static constexpr std::array<std::array<double, 7>, 7> a = {
        {{0},
         {1.0 / 3.0},
         {0, 2.0 / 3.0},
         {1.0 / 12.0, 1.0 / 3.0, -1.0 / 12.0},
         {-1.0 / 16.0, 9.0 / 8.0, -3.0 / 16.0, -3.0 / 8.0},
         {0, 9.0 / 8.0, -3.0 / 8.0, -3.0 / 4.0, 0.5},
         {9.0 / 44.0, -9.0 / 11.0, 63.0 / 44.0, 18.0 / 11.0, 0, -16.0 / 11.0}}};
    static constexpr std::array<double, 7> b = {11.0 / 120.0, 0,           27.0 / 40.0, 27.0 / 40.0,
                                                -4.0 / 15.0,  -4.0 / 15.0, 11.0 / 120.0};
    static constexpr std::array<double, 7> c = {0, 1.0 / 3.0, 2.0 / 3.0, 1.0 / 3.0, 0.5, 0.5, 1.0};
};

}  // namespace softlimb::rod
