#pragma once
// Choices that Python gives by name.
#include <initializer_list>
#include <string>
#include <string_view>
#include <utility>

#include "softlimb/actuator/tube.hpp"
#include "softlimb/arguments.hpp"

namespace softlimb::bindings {

template <class Enum>
Enum named(std::string_view argument, std::string_view value,
           std::initializer_list<std::pair<const char*, Enum>> choices) {
    std::string all;
    for (const auto& [name, choice] : choices) {
        if (value == name) return choice;
        all += std::string(all.empty() ? "\"" : ", \"") + name + "\"";
    }
    reject(argument, "\"" + std::string(value) + "\"", "one of " + all);
}

inline actuator::SectionModel section_model(std::string_view name) {
    using actuator::SectionModel;
    return named<SectionModel>(
        "section model", name,
        {{"tangent", SectionModel::tangent}, {"nonlinear", SectionModel::nonlinear}, {"paper", SectionModel::paper}});
}

inline actuator::TubeParameter::Kind tube_parameter(std::string_view name) {
    using Kind = actuator::TubeParameter::Kind;
    return named<Kind>("parameter of a tube", name,
                       {{"pressure", Kind::pressure},
                        {"length", Kind::length},
                        {"mass", Kind::mass},
                        {"cap_length", Kind::cap_length},
                        {"radius", Kind::radius},
                        {"angle", Kind::angle},
                        {"fraction", Kind::fraction},
                        {"modulus", Kind::modulus},
                        {"stiffness", Kind::stiffness},
                        {"coefficient", Kind::coefficient},
                        {"density", Kind::density}});
}

inline actuator::Valve valve_of(std::string_view name) {
    using actuator::Valve;
    return named<Valve>("valve", name, {{"open", Valve::open}, {"locked", Valve::locked}});
}

}  // namespace softlimb::bindings
