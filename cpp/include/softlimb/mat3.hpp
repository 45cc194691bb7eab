#pragma once
// A 3 x 3 matrix of any scalar (double, a pack of lanes), by columns: what Vec3 is to vectors.
#include "softlimb/vec3.hpp"

namespace softlimb {

template <class S>
struct Mat3 {
    Vec3<S> column[3];

    SOFTLIMB_ALWAYS_INLINE friend Vec3<S> operator*(const Mat3& a, const Vec3<S>& b) {
        return b.x * a.column[0] + b.y * a.column[1] + b.z * a.column[2];
    }
    SOFTLIMB_ALWAYS_INLINE friend Mat3 operator*(const Mat3& a, const Mat3& b) {
        return {{a * b.column[0], a * b.column[1], a * b.column[2]}};
    }
    SOFTLIMB_ALWAYS_INLINE friend Mat3 operator+(const Mat3& a, const Mat3& b) {
        return {{a.column[0] + b.column[0], a.column[1] + b.column[1], a.column[2] + b.column[2]}};
    }
    SOFTLIMB_ALWAYS_INLINE friend Mat3 operator-(const Mat3& a, const Mat3& b) {
        return {{a.column[0] - b.column[0], a.column[1] - b.column[1], a.column[2] - b.column[2]}};
    }
    SOFTLIMB_ALWAYS_INLINE friend Mat3 operator*(const S& s, const Mat3& a) {
        return {{s * a.column[0], s * a.column[1], s * a.column[2]}};
    }
    SOFTLIMB_ALWAYS_INLINE Mat3& add_to_diagonal(const S& s) {
        column[0].x = column[0].x + s, column[1].y = column[1].y + s, column[2].z = column[2].z + s;
        return *this;
    }
};

template <class S>
SOFTLIMB_ALWAYS_INLINE Mat3<S> transposed(const Mat3<S>& a) {
    const auto& [x, y, z] = a.column;
    return {{{x.x, y.x, z.x}, {x.y, y.y, z.y}, {x.z, y.z, z.z}}};
}

/// a b^T.
template <class S>
SOFTLIMB_ALWAYS_INLINE Mat3<S> outer(const Vec3<S>& a, const Vec3<S>& b) {
    return {{b.x * a, b.y * a, b.z * a}};
}

/// Skew matrix: hat(a) b = a x b.
template <class S>
SOFTLIMB_ALWAYS_INLINE Mat3<S> hat(const Vec3<S>& a) {
    const S zero(0.0);
    return {{{zero, a.z, -a.y}, {-a.z, zero, a.x}, {a.y, -a.x, zero}}};
}

}  // namespace softlimb
