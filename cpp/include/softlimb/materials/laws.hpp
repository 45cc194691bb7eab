#pragma once
// The list of material laws. A new law is one file beside this one and one entry here; bindings, command line and the
// shared law tests iterate the list.
#include "softlimb/materials/gent.hpp"
#include "softlimb/materials/mooney_rivlin.hpp"
#include "softlimb/materials/neo_hookean.hpp"
#include "softlimb/materials/ogden.hpp"
#include "softlimb/materials/yeoh.hpp"
#include "softlimb/type_list.hpp"

namespace softlimb::materials {

using Laws = TypeList<NeoHookean, Yeoh, MooneyRivlin, Ogden, Gent>;
using AnyLaw = Laws::Variant;

}  // namespace softlimb::materials
