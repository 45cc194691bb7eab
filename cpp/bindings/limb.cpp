#include "bindings.hpp"

namespace softlimb::bindings {

void bind_limb(pybind11::module_&) {}

}  // namespace softlimb::bindings
