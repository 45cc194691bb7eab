#pragma once
// One function a binding file. A binding converts and forwards; it holds no physics.
#include <pybind11/pybind11.h>

namespace softlimb::bindings {

void bind_section(pybind11::module_& m);
void bind_materials(pybind11::module_& m);
void bind_tube(pybind11::module_& m);
void bind_rod(pybind11::module_& m);
void bind_limb(pybind11::module_& m);

}  // namespace softlimb::bindings
