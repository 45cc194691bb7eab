#pragma once
// Three numbers of any scalar (double, a pack of lanes, Dual). The rod equations are written in these so that one
// source serves every scalar; Eigen takes over where matrices begin (se3.hpp has the way between).
#include <cmath>

#include "softlimb/always_inline.hpp"

namespace softlimb {

template <class S>
struct Vec3 {
    S x{}, y{}, z{};

    SOFTLIMB_ALWAYS_INLINE friend Vec3 operator+(const Vec3& a, const Vec3& b) {
        return {a.x + b.x, a.y + b.y, a.z + b.z};
    }
    SOFTLIMB_ALWAYS_INLINE friend Vec3 operator-(const Vec3& a, const Vec3& b) {
        return {a.x - b.x, a.y - b.y, a.z - b.z};
    }
    SOFTLIMB_ALWAYS_INLINE friend Vec3 operator-(const Vec3& a) { return {-a.x, -a.y, -a.z}; }
    SOFTLIMB_ALWAYS_INLINE friend Vec3 operator*(const S& s, const Vec3& a) { return {s * a.x, s * a.y, s * a.z}; }
    SOFTLIMB_ALWAYS_INLINE Vec3& operator+=(const Vec3& b) {
        x = x + b.x, y = y + b.y, z = z + b.z;
        return *this;
    }
};

template <class S>
SOFTLIMB_ALWAYS_INLINE S dot(const Vec3<S>& a, const Vec3<S>& b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
template <class S>
SOFTLIMB_ALWAYS_INLINE Vec3<S> cross(const Vec3<S>& a, const Vec3<S>& b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline bool is_zero(const Vec3<double>& a) { return a.x == 0.0 && a.y == 0.0 && a.z == 0.0; }
template <class S>
SOFTLIMB_ALWAYS_INLINE Vec3<S> normalised(const Vec3<S>& a) {
    using std::sqrt;
    return (S(1.0) / sqrt(dot(a, a))) * a;
}

}  // namespace softlimb
