#pragma once
// An explicit list of types that bindings and tests iterate: `using Laws = TypeList<NeoHookean, Yeoh, ...>`.
#include <cstddef>
#include <variant>

namespace softlimb {

template <class... Types>
struct TypeList {
    static constexpr std::size_t size = sizeof...(Types);
    using Variant = std::variant<Types...>;

    /// Calls `visit.template operator()<T>()` for each type, in order.
    template <class Visitor>
    static void for_each(Visitor&& visit) {
        (visit.template operator()<Types>(), ...);
    }
};

}  // namespace softlimb
