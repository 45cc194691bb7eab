#include "bindings.hpp"

namespace softlimb::bindings {

void bind_rod(pybind11::module_&) {}

}  // namespace softlimb::bindings
