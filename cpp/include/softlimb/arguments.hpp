#pragma once
// Checks of what a caller hands in. Each raises std::invalid_argument (ValueError in Python) with a message
// that names the argument, its value and the rule.
#include <cmath>
#include <sstream>
#include <stdexcept>
#include <string>
#include <string_view>

namespace softlimb {

template <class Value>
[[noreturn]] void reject(std::string_view name, const Value& value, std::string_view rule) {
    std::ostringstream text;
    text.precision(10);
    text << name << " must be " << rule << ", got " << value;
    throw std::invalid_argument(text.str());
}

inline void require_finite(std::string_view name, double value) {
    if (!std::isfinite(value)) reject(name, value, "finite");
}

inline void require_positive(std::string_view name, double value) {
    if (!(std::isfinite(value) && value > 0.0)) reject(name, value, "finite and positive");
}

inline void require_not_negative(std::string_view name, double value) {
    if (!(std::isfinite(value) && value >= 0.0)) reject(name, value, "finite and not negative");
}

}  // namespace softlimb
