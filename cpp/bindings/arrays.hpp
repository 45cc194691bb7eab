#pragma once
// Poses and vectors as numpy arrays and back.
#include <pybind11/numpy.h>

#include <algorithm>
#include <vector>

#include "softlimb/se3.hpp"

namespace softlimb::bindings {

using Array = pybind11::array_t<double, pybind11::array::c_style | pybind11::array::forcecast>;

inline Pose pose_at(const Array& a, pybind11::ssize_t i) {
    const double* x = a.data() + 16 * i;
    Pose pose;
    for (int r = 0; r < 3; ++r) {
        for (int c = 0; c < 3; ++c) pose.rotation(r, c) = x[4 * r + c];
        pose.position(r) = x[4 * r + 3];
    }
    return pose;
}

inline Array poses_array(const std::vector<Pose>& poses) {
    Array out({static_cast<pybind11::ssize_t>(poses.size()), pybind11::ssize_t{4}, pybind11::ssize_t{4}});
    for (std::size_t i = 0; i < poses.size(); ++i) write_matrix(poses[i], out.mutable_data() + 16 * i);
    return out;
}

inline Array vectors_array(const std::vector<Vector6>& vectors) {
    Array out({static_cast<pybind11::ssize_t>(vectors.size()), pybind11::ssize_t{6}});
    for (std::size_t i = 0; i < vectors.size(); ++i) std::copy_n(vectors[i].data(), 6, out.mutable_data() + 6 * i);
    return out;
}

template <class Vector>
Array vector_array(const Vector& v) {
    Array out(v.size());
    std::copy_n(v.data(), v.size(), out.mutable_data());
    return out;
}

inline std::vector<Pose> poses_of(const Array& a) {
    std::vector<Pose> poses(a.shape(0));
    for (pybind11::ssize_t i = 0; i < a.shape(0); ++i) poses[i] = pose_at(a, i);
    return poses;
}

}  // namespace softlimb::bindings
