#include "softlimb/section.hpp"

#include "softlimb/arguments.hpp"

namespace softlimb {

void Section::check() const {
    require_positive("axial stiffness EA", axial);
    require_positive("shear stiffness GA", shear);
    require_positive("bending stiffness EI", bending);
    require_positive("torsion stiffness GJ", torsion);
    require_not_negative("mass_per_length", mass_per_length);
    require_finite("rest_twist", rest_twist);
    require_finite("extension_twist", extension_twist);
    const double coupling = extension_twist * extension_twist * axial * torsion;
    if (!(coupling < 1.0)) reject("extension_twist^2 EA GJ", coupling, "below 1 (the section must resist every load)");
}

Section Section::make(double axial, double shear, double bending, double torsion, double mass_per_length,
                      double rest_twist, double extension_twist) {
    Section section;
    section.axial = axial;
    section.shear = shear;
    section.bending = bending;
    section.torsion = torsion;
    section.mass_per_length = mass_per_length;
    section.rest_twist = rest_twist;
    section.extension_twist = extension_twist;
    section.check();
    section.axial_law.coefficient[0] = 1.0 / axial;
    return section;
}

}  // namespace softlimb
