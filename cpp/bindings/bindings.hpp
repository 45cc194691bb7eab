#pragma once
// One function a binding file. A binding converts and forwards; it holds no physics.
#include <pybind11/pybind11.h>
#include <pybind11/typing.h>

namespace softlimb::bindings {

/// What an object pickles as: `tuple[object, ...]` in the stubs.
using State = pybind11::typing::Tuple<pybind11::object, pybind11::ellipsis>;

/// `a == b` for any Python object b, as the stubs want it.
template <class T>
bool equals(const T& a, const pybind11::object& b) {
    return pybind11::isinstance<T>(b) && a == b.cast<const T&>();
}

void bind_section(pybind11::module_& m);
void bind_materials(pybind11::module_& m);
void bind_tube(pybind11::module_& m);
void bind_rod(pybind11::module_& m);
void bind_limb(pybind11::module_& m);
void bind_members(pybind11::module_& m);
void bind_derivatives(pybind11::module_& m);
void bind_path(pybind11::module_& m);
void bind_reach(pybind11::module_& m);
void bind_bench(pybind11::module_& m);
void bind_sweep(pybind11::module_& m);
void bind_control(pybind11::module_& m);

}  // namespace softlimb::bindings
