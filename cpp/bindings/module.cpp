#include "bindings.hpp"

PYBIND11_MODULE(_core, m) {
    m.doc() = "Compiled core of softlimb: sections, laws, tubes, rods, limbs. SI units throughout.";
    softlimb::bindings::bind_section(m);
    softlimb::bindings::bind_materials(m);
    softlimb::bindings::bind_tube(m);
    softlimb::bindings::bind_rod(m);
    softlimb::bindings::bind_limb(m);
    softlimb::bindings::bind_members(m);
    softlimb::bindings::bind_derivatives(m);
    softlimb::bindings::bind_path(m);
    softlimb::bindings::bind_reach(m);
    softlimb::bindings::bind_bench(m);
    softlimb::bindings::bind_sweep(m);
    softlimb::bindings::bind_control(m);
}
