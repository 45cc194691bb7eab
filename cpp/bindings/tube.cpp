#include "bindings.hpp"

namespace softlimb::bindings {

void bind_tube(pybind11::module_&) {}

}  // namespace softlimb::bindings
