#pragma once
// A short list of coefficients without heap, for laws that are sums of like terms.
#include <array>
#include <string_view>

#include "softlimb/arguments.hpp"
#include "softlimb/materials/law.hpp"

namespace softlimb::materials {

/// Up to `capacity` numbers. Published Ogden fits have one to three terms; more are not identifiable from tension.
struct Terms {
    static constexpr int capacity = 4;
    int count = 0;
    std::array<double, capacity> value{};

    double operator[](int i) const { return value[i]; }
    bool operator==(const Terms&) const = default;

    /// From any sized range of numbers; raises std::invalid_argument when there are none or too many.
    template <class Range>
    static Terms from(std::string_view name, const Range& numbers) {
        if (std::size(numbers) < 1 || std::size(numbers) > capacity)
            reject(std::string("number of terms in ") + std::string(name), std::size(numbers), "from 1 to 4");
        Terms terms;
        for (const double number : numbers) terms.value[terms.count++] = number;
        return terms;
    }
};

inline void require_bound(std::string_view name, const Terms& terms, Bound bound) {
    for (int i = 0; i < terms.count; ++i)
        require_bound(std::string(name) + "[" + std::to_string(i) + "]", terms[i], bound);
}

}  // namespace softlimb::materials
