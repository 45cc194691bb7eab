#include "softlimb/limb/energy.hpp"

#include <algorithm>
#include <array>
#include <stdexcept>

#include "softlimb/gauss.hpp"
#include "softlimb/limb/rod_numbers.hpp"

namespace softlimb::limb {
namespace {

using Eigen::VectorXd;

/// Complementary energy of the axial law, the integral of the strain over the force from zero to n3, and its
/// derivatives to the coefficients of the law and to the relative growth of its range.
struct AxialEnergy {
    double value = 0.0, by_growth = 0.0;
    std::array<double, AxialLaw::max_degree + 1> by_coefficient{};
};

AxialEnergy axial_energy(const AxialLaw& law, double n3) {
    // Eight points are exact inside the law's range, where the strain has degree 13 at most, and for the parabola
    // outside.
    static const GaussRule rule = gauss_rule(8);
    AxialEnergy energy;
    const auto add = [&](double from, double to) {
        const double middle = 0.5 * (from + to), half = 0.5 * (to - from);
        for (int p = 0; p < rule.points; ++p) {
            const double force = middle + half * rule.node[p], weight = half * rule.weight[p];
            double strain, compliance;
            axial_strain(law, force, strain, compliance);
            energy.value += weight * strain;
            AxialLaw unit = law;
            for (int k = 0; k <= law.degree; ++k) {
                unit.coefficient.fill(0.0);
                unit.coefficient[k] = 1.0;
                axial_strain(unit, force, strain, compliance);
                energy.by_coefficient[k] += weight * strain;
            }
        }
    };
    const double end = law.linear() ? n3 : std::clamp(n3, law.centre - law.half_range, law.centre + law.half_range);
    add(0.0, end);
    if (end != n3) add(end, n3);
    double strain, compliance;
    axial_strain(law, n3, strain, compliance);
    energy.by_growth = 2.0 * energy.value - n3 * strain;  // the integral of strain - n dstrain/dn
    return energy;
}

/// Of one rod: energy, its derivatives to the rod's numbers, and the wrenches on its two ends.
struct RodEnergy {
    double value = 0.0;
    VectorXd by_numbers;
    Vector12 at_ends;
};

RodEnergy energy_of(const Posture& posture, int i) {
    const RodAtPressure& at = posture.scene.rods[i];
    const RodShape& rod = posture.solution.shape.rods[i];
    const Section& section = at.section;
    // Strains of a piece grow by e^3 at most: twelve points leave rounding.
    static const GaussRule rule = gauss_rule(12);
    std::vector<double> fractions;
    std::vector<double> weights;  // [m]
    for (int e = 0; e < rod.elements(); ++e)
        for (int p = 0; p < rule.points; ++p) {
            fractions.push_back((e + 0.5 * (1.0 + rule.node[p])) / rod.elements());
            weights.push_back(0.5 * rule.weight[p] * at.rest_length / rod.elements());
        }
    fractions.push_back(1.0);
    const std::vector<RodPoint> points = points_along(posture, i, fractions);

    RodEnergy out;
    out.by_numbers = VectorXd::Zero(number_count(section));
    const int law = section.axial_law.degree + 1;
    double by_length = 0.0;
    Vector3 places = Vector3::Zero();
    for (std::size_t k = 0; k < weights.size(); ++k) {
        const Vector3 n = points[k].pose.rotation.transpose() * points[k].force;
        const Vector3 m = points[k].pose.rotation.transpose() * points[k].moment;
        const double shear = n.head<2>().squaredNorm(), bend = m.head<2>().squaredNorm(), w = weights[k];
        const AxialEnergy axial = axial_energy(section.axial_law, n.z());
        const double complementary = 0.5 * shear / section.shear + axial.value +
                                     section.extension_twist * n.z() * m.z() + 0.5 * bend / section.bending +
                                     0.5 * m.z() * m.z() / section.torsion;
        const Vector3 strain = points[k].strain - Vector3::UnitZ();
        const Vector3 curvature = points[k].curvature - section.rest_twist * Vector3::UnitZ();
        out.value += w * (n.dot(strain) + m.dot(curvature) - complementary);
        // At fixed strains the energy changes by as much as the complementary energy at fixed stresses, the other way.
        for (int c = 0; c < law; ++c) out.by_numbers(c) -= w * axial.by_coefficient[c];
        out.by_numbers(law + RodNumber::range) -= w * axial.by_growth;
        out.by_numbers(law + RodNumber::shear) += 0.5 * w * shear / (section.shear * section.shear);
        out.by_numbers(law + RodNumber::bending) += 0.5 * w * bend / (section.bending * section.bending);
        out.by_numbers(law + RodNumber::torsion) += 0.5 * w * m.z() * m.z() / (section.torsion * section.torsion);
        out.by_numbers(law + RodNumber::coupling) -= w * n.z() * m.z();
        out.by_numbers(law + RodNumber::rest_twist) -= w * m.z();
        by_length -= w * (complementary + n.z() + m.z() * section.rest_twist);
        places += w * points[k].pose.position;
    }
    const Vector3 load = eigen(posture.scene.line_load(i).force);
    out.value -= load.dot(places);
    by_length -= load.dot(places);
    out.by_numbers(law + RodNumber::length) = by_length / at.rest_length;
    out.by_numbers.tail<3>() = -places;
    out.at_ends << -rod.wrenches.front(), points.back().force, points.back().moment;
    return out;
}

/// Centre of mass of plate j.
Vector3 centre_of(const Posture& posture, int j) {
    const Pose& plate = posture.solution.shape.plates[j];
    return plate.position + 0.5 * posture.geometry->segments[j].plate_thickness * plate.rotation.col(2);
}

void require_potential(bool has_one) {
    if (!has_one)
        throw std::runtime_error(
            "the loads have no potential (a moment on a plate that may turn, a following wrench, a moment along a "
            "rod): "
            "no energy");
}

}  // namespace

double potential_energy(const Posture& posture) {
    const Geometry& geometry = *posture.geometry;
    require_potential(posture.scene.conservative());
    double energy = 0.0;
    for (int i = 0; i < geometry.rods(); ++i) energy += energy_of(posture, i).value;
    for (int j = 0; j < geometry.plates(); ++j) {
        energy -= posture.scene.wrenches[j].head<3>().dot(posture.solution.shape.plates[j].position);
        energy -= geometry.segments[j].plate_mass * posture.scene.gravity.dot(centre_of(posture, j));
    }
    return energy;
}

std::vector<double> potential_energy_slopes(const Posture& posture, const std::vector<SceneRate>& rates) {
    const Geometry& geometry = *posture.geometry;
    const Scene& scene = posture.scene;
    const Shape& shape = posture.solution.shape;
    require_potential(scene.conservative());
    std::vector<RodEnergy> rods;
    for (int i = 0; i < geometry.rods(); ++i) rods.push_back(energy_of(posture, i));
    std::vector<double> slopes;
    for (const SceneRate& rate : rates) {
        double slope = 0.0;
        for (int i = 0; i < geometry.rods(); ++i)
            slope += rods[i].by_numbers.tail<3>().dot(rate.line_force(scene, i, {}));
        for (const auto& [i, change] : rate.rods) {
            const Vector3 own = rate.line_force(scene, i, change) - rate.line_force(scene, i, {});
            slope += rods[i].by_numbers.dot(rod_numbers(scene.rods[i].section, change, own));
        }
        for_each_end_move(geometry, shape, rate,
                          [&](int i, const Vector12& move) { slope += rods[i].at_ends.dot(move); });
        for (int j = 0; j < geometry.plates(); ++j)
            slope -= geometry.segments[j].plate_mass * rate.gravity.dot(centre_of(posture, j));
        for (const auto& [j, change] : rate.plates) {
            const auto& held = scene.holds[j].held;
            const bool turns = !(held[3] && held[4] && held[5]);
            const auto& wrench = change.wrench;
            require_potential(!turns || (wrench.tail<3>().isZero(0.0) && !(scene.following && !wrench.isZero(0.0))));
            slope -= wrench.head<3>().dot(shape.plates[j].position);
            slope -= change.mass * scene.gravity.dot(centre_of(posture, j));
            slope -= 0.5 * change.thickness * geometry.segments[j].plate_mass *
                     scene.gravity.dot(shape.plates[j].rotation.col(2));
        }
        slopes.push_back(slope);
    }
    return slopes;
}

}  // namespace softlimb::limb
