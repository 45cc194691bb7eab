#pragma once
// The coefficients of any law as one flat list: those of a sum of terms one after the other, in the order of
// `parameters()`. For derivatives to them.
#include <array>
#include <cstddef>
#include <string>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <variant>
#include <vector>

#include "softlimb/materials/laws.hpp"
#include "softlimb/materials/terms.hpp"

namespace softlimb::materials {

/// Calls `use(name, term, value, linear)` with every coefficient in turn: `term` is its number among like ones, or -1,
/// `value` a reference into the law.
template <class L, class Use>
void for_each_coefficient(L& law, Use&& use) {
    const auto each = [&](const auto& parameter) {
        auto& held = law.*parameter.member;
        if constexpr (requires { held.count; }) {
            for (int i = 0; i < held.count; ++i) use(parameter.name, i, held.value[i], parameter.linear);
        } else {
            use(parameter.name, -1, held, parameter.linear);
        }
    };
    std::apply([&](const auto&... parameter) { (each(parameter), ...); }, std::remove_const_t<L>::parameters());
}

/// Derivative of something computed from a law, `result(law)`, to coefficient `number`. Where the energy is linear in
/// it the result, linear in the energy, is that of the law with this coefficient alone. Else (an exponent, a limit) it
/// is a central difference of eighth order, whose step is a 128th of `reach`, the distance to where the law as a
/// function of that coefficient is singular: both the terms left out and the rounding are then below 1e-12.
template <class Compute>
auto by_coefficient(const AnyLaw& any, int number, double reach, Compute&& compute) {
    using Result = decltype(compute(any));
    const auto add = [](Result& sum, double factor, const Result& part) {
        if constexpr (std::is_same_v<Result, double>)
            sum += factor * part;
        else
            sum.add(factor, part);
    };
    return std::visit(
        [&](const auto& law) -> Result {
            auto changed = law;
            double* value = nullptr;
            bool linear = true;
            int count = 0;
            for_each_coefficient(changed, [&](std::string_view, int, double& held, bool is_linear) {
                if (count++ == number) value = &held, linear = is_linear;
            });
            if (value == nullptr) reject("number of a law's coefficient", number, "one that the law has");
            if (linear) {
                for_each_coefficient(changed, [&](std::string_view, int, double& held, bool is_linear) {
                    if (is_linear) held = 0.0;
                });
                *value = 1.0;
                return compute(AnyLaw(changed));
            }
            constexpr std::array weights = {4.0 / 5.0, -1.0 / 5.0, 4.0 / 105.0, -1.0 / 280.0};
            const double at = *value, step = reach / 128.0;
            Result result{};
            for (std::size_t k = 0; k < weights.size(); ++k)
                for (const double side : {1.0, -1.0}) {
                    *value = at + side * static_cast<double>(k + 1) * step;
                    add(result, side * weights[k] / step, compute(AnyLaw(changed)));
                }
            return result;
        },
        any);
}

inline double coefficient(const AnyLaw& any, int number) {
    double found = 0.0;
    int count = 0;
    std::visit(
        [&](const auto& law) {
            for_each_coefficient(law, [&](std::string_view, int, double value, bool) {
                if (count++ == number) found = value;
            });
        },
        any);
    return found;
}

/// Names of all coefficients, in order.
inline std::vector<std::string> coefficient_names(const AnyLaw& any) {
    std::vector<std::string> names;
    std::visit(
        [&](const auto& law) {
            for_each_coefficient(law, [&](std::string_view name, int term, double, bool) {
                names.emplace_back(name);
                if (term >= 0) names.back() += "[" + std::to_string(term) + "]";
            });
        },
        any);
    return names;
}

}  // namespace softlimb::materials
