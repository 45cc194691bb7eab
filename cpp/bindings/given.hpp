#pragma once
// Arguments as the caller gave them, converted where their name is known: what is no number is refused by name, by the
// same rule as in Python (softlimb/arguments.py), and not by a list of C++ signatures.
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <optional>
#include <string>
#include <vector>

namespace softlimb::bindings {

/// Stands for a T in a signature (and in the stubs), and takes anything.
template <class T>
struct Given {
    pybind11::object value;
};

inline pybind11::object checked_by(const char* rule, const char* name, const pybind11::object& value) {
    return pybind11::module_::import("softlimb.arguments").attr(rule)(name, value);
}

inline double taken(const char* name, const Given<double>& given) {
    return checked_by("one_real", name, given.value).cast<double>();
}
inline std::optional<double> taken(const char* name, const std::optional<Given<double>>& given) {
    return given ? std::optional(taken(name, *given)) : std::nullopt;
}
inline std::vector<double> taken(const char* name, const Given<std::vector<double>>& given) {
    return checked_by("real_list", name, given.value).cast<std::vector<double>>();
}
template <class T, int flags>
pybind11::array_t<T, flags> taken(const char* name, const Given<pybind11::array_t<T, flags>>& given) {
    return checked_by("real_array", name, given.value).template cast<pybind11::array_t<T, flags>>();
}
/// Anything else; `rule` completes "must be".
template <class T>
T taken(const char* name, const Given<T>& given, const char* rule) {
    try {
        return given.value.template cast<T>();
    } catch (const pybind11::builtin_exception&) {  // of another type, or None in place of an object
    } catch (const pybind11::error_already_set&) {  // an odd sequence that has no length
    }
    const pybind11::object text = pybind11::module_::import("softlimb.arguments").attr("shown")(given.value);
    throw std::invalid_argument(std::string(name) + " must be " + rule + ", got " + std::string(pybind11::str(text)));
}

}  // namespace softlimb::bindings

namespace pybind11::detail {

template <class T>
struct type_caster<softlimb::bindings::Given<T>> {
    PYBIND11_TYPE_CASTER(softlimb::bindings::Given<T>, make_caster<T>::name);
    bool load(handle source, bool) {
        value.value = reinterpret_borrow<object>(source);
        return true;
    }
};

}  // namespace pybind11::detail
