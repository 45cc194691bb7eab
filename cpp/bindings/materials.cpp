#include "bindings.hpp"

namespace softlimb::bindings {

void bind_materials(pybind11::module_&) {}

}  // namespace softlimb::bindings
