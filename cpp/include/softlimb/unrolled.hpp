#pragma once
// Loops whose index is known to the compiler, so that zero coefficients of a tableau vanish.
#include <type_traits>

#include "softlimb/always_inline.hpp"

namespace softlimb {

/// Calls f(I), ..., f(N-1) with the index as a constant.
template <int I, int N, class F>
SOFTLIMB_ALWAYS_INLINE void unrolled(F&& f) {
    if constexpr (I < N) {
        f(std::integral_constant<int, I>{});
        unrolled<I + 1, N>(f);
    }
}

}  // namespace softlimb
