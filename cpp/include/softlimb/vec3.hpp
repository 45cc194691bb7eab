#pragma once
// Three numbers of any scalar (double, a pack of lanes, Dual). The rod kernel is written in these so that one source
// serves every scalar; Eigen takes over where matrices begin.
#include <Eigen/Core>

namespace softlimb {

template <class S>
struct Vec3 {
    S x{}, y{}, z{};

    friend Vec3 operator+(const Vec3& a, const Vec3& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
    friend Vec3 operator-(const Vec3& a, const Vec3& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
    friend Vec3 operator-(const Vec3& a) { return {-a.x, -a.y, -a.z}; }
    friend Vec3 operator*(const S& s, const Vec3& a) { return {s * a.x, s * a.y, s * a.z}; }
    Vec3& operator+=(const Vec3& b) {
        x += b.x, y += b.y, z += b.z;
        return *this;
    }
};

template <class S>
inline S dot(const Vec3<S>& a, const Vec3<S>& b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
template <class S>
inline Vec3<S> cross(const Vec3<S>& a, const Vec3<S>& b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
template <class S>
inline Vec3<S> normalised(const Vec3<S>& a) {
    using std::sqrt;
    return (S(1.0) / sqrt(dot(a, a))) * a;
}

inline Vec3<double> vec3(const Eigen::Vector3d& a) { return {a.x(), a.y(), a.z()}; }
inline Eigen::Vector3d eigen(const Vec3<double>& a) { return {a.x, a.y, a.z}; }

}  // namespace softlimb
