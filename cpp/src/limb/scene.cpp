#include "softlimb/limb/scene.hpp"

#include <algorithm>

namespace softlimb::limb {

Pose Geometry::distal_face(int j, const Pose& plate) const {
    Pose face = plate;
    face.position += segments[j].plate_thickness * face.rotation.col(2);
    return face;
}

Pose Geometry::footing(int j, const std::vector<Pose>& plates) const {
    return j == 0 ? Pose{} : distal_face(j - 1, plates[j - 1]);
}

rod::LineLoad<double> Scene::line_load(int i) const {
    rod::LineLoad<double> load = rods[i].line_load;
    load.force += rods[i].section.mass_per_length * vec3(gravity);
    return load;
}

bool Scene::loads_rods() const {
    for (std::size_t i = 0; i < rods.size(); ++i)
        if (!is_zero(line_load(static_cast<int>(i)))) return true;
    return false;
}

bool Scene::holds_plates() const {
    return std::any_of(holds.begin(), holds.end(), [](const Hold& hold) { return hold.any(); });
}

bool Scene::conservative() const {
    for (std::size_t j = 0; j < wrenches.size(); ++j) {
        const auto& held = holds[j].held;
        const bool turns = !(held[3] && held[4] && held[5]);
        if (turns && !wrenches[j].tail<3>().isZero(0.0)) return false;
        if (turns && following && !wrenches[j].isZero(0.0)) return false;
    }
    for (const RodAtPressure& rod : rods)
        if (!is_zero(rod.line_load.moment)) return false;
    return true;
}

namespace {

/// frame * place; most rods stand along their plate's axis, so that nothing needs turning.
void put(const Pose& frame, const Pose& place, Pose& out) {
    out.position = frame.position + frame.rotation * place.position;
    if (place.rotation == Matrix3::Identity())
        out.rotation = frame.rotation;
    else
        out.rotation.noalias() = frame.rotation * place.rotation;
}

}  // namespace

void attach_rods(const Geometry& geometry, Shape& shape) {
    int i = 0;
    for (int j = 0; j < geometry.plates(); ++j) {
        const Pose foot = geometry.footing(j, shape.plates);
        for (const Placement& place : geometry.segments[j].rods) {
            RodShape& rod = shape.rods[i++];
            put(foot, place.base, rod.nodes.front());
            put(shape.plates[j], place.end, rod.nodes.back());
        }
    }
}

}  // namespace softlimb::limb
