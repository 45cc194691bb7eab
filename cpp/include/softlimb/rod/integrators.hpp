#pragma once
// The list of integrators. A new one is a tableau in `integrators/` and one entry here; the shared order test iterates
// the list. An explicit tableau has `stages`, `order`, a (strictly lower triangular), b, c.
#include "softlimb/rod/integrators/rk4.hpp"
#include "softlimb/rod/integrators/rk6.hpp"
#include "softlimb/rod/integrators/rk8.hpp"
#include "softlimb/type_list.hpp"

namespace softlimb::rod {

using Integrators = TypeList<Rk4, Rk6, Rk8>;

}  // namespace softlimb::rod
