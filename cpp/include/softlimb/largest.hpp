#pragma once
// The largest of many numbers, for error measures: a NaN is larger than anything and stays. std::max would lose it.

namespace softlimb {

inline void grow(double& largest, double value) {
    if (!(value <= largest)) largest = largest != largest ? largest : value;
}

}  // namespace softlimb
