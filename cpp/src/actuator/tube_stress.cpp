// Stress through the wall and in the fibres. Source: cpp/MECHANICS.md, "Stress through the wall".
#include <algorithm>
#include <cmath>

#include "softlimb/actuator/tube.hpp"
#include "softlimb/arguments.hpp"

namespace softlimb::actuator {
namespace {

/// Cauchy stress up to the pressure that incompressibility leaves open: differences to the radial stress.
struct Differences {
    double hoop, axial, shear;
};

Differences differences(const WallLayer& layer, const Shape<double>& q, double x, bool tension_only) {
    const double s = std::exp(x), e = s + q.volume - 1.0, rho = e / q.stretch, l = q.stretch, root = std::sqrt(rho);
    const double a = s / (e * l), around = rho * (1.0 / s + q.twist * q.twist);
    Differences d{};
    std::visit(
        [&](const auto& law) {
            const auto w = law.derivatives(a, around + l * l);
            d.hoop = layer.silicone * 2.0 * (w.w_t * around - w.w_a * a);
            d.axial = layer.silicone * 2.0 * (w.w_t * l * l - w.w_a * a);
            d.shear = layer.silicone * 2.0 * w.w_t * root * q.twist * l;
        },
        layer.law);
    for (const WallFamily& family : layer.families) {
        for (int side = 0; side < (family.mirrored ? 2 : 1); ++side) {
            const double sine = side == 0 ? family.sine : -family.sine;
            const double hoop = root * (family.cosine / std::sqrt(s) + q.twist * sine), axial = l * sine;
            const double stretch = std::hypot(hoop, axial);
            if (tension_only && stretch < 1.0) continue;
            const double pull = family.stiffness * (1.0 - 1.0 / stretch);
            d.hoop += pull * hoop * hoop;
            d.axial += pull * axial * axial;
            d.shear += pull * hoop * axial;
        }
    }
    return d;
}

/// Integral of (hoop - radial) dr / r between two places of a layer: minus the rise of the radial stress. Split where
/// a tension-only family goes slack, since the integrand has a kink there.
double radial_drop(const WallLayer& layer, const Shape<double>& q, double from, double to, bool tension_only) {
    static const GaussRule rule = gauss_rule(12);
    std::array<double, 64> cut{};
    int cuts = 0;
    cut[cuts++] = from;
    if (tension_only)
        for (const WallFamily& family : layer.families)
            for (int side = 0; side < (family.mirrored ? 2 : 1); ++side) {
                const WallFamily single{family.cosine, side == 0 ? family.sine : -family.sine, family.stiffness, false};
                const Wall::TautParts parts = Wall::taut_parts(layer, single, q);
                for (int i = 0; i < parts.count; ++i)
                    for (const double x : {parts.from[i], parts.to[i]})
                        if (x > from && x < to && cuts < 62) cut[cuts++] = x;
            }
    std::sort(cut.begin(), cut.begin() + cuts);
    cut[cuts] = to;
    double sum = 0.0;
    for (int i = 0; i < cuts; ++i) {
        const double middle = 0.5 * (cut[i] + cut[i + 1]), half = 0.5 * (cut[i + 1] - cut[i]);
        for (int j = 0; j < rule.points; ++j) {
            const double x = middle + half * rule.node[j], s = std::exp(x);
            sum += half * rule.weight[j] * differences(layer, q, x, tension_only).hoop * 0.5 * s / (s + q.volume - 1.0);
        }
    }
    return sum;
}

}  // namespace

WallStress Tube::stress_at_reference(const TubeState& state, double reference_radius) const {
    // A radius at a face may be off by the rounding of whoever computed it.
    const double slack = 1e-9 * outer_radius();
    if (!(reference_radius >= inner_radius() - slack && reference_radius <= outer_radius() + slack)) {
        std::ostringstream rule;
        rule << "within the wall, " << inner_radius() << " to " << outer_radius();
        reject("reference radius", reference_radius, rule.str());
    }
    const auto& layers = wall_.layers();
    const double x = std::clamp(2.0 * std::log(reference_radius / inner_radius()), 0.0, layers.back().x_out);
    std::size_t here = 0;
    while (here + 1 < layers.size() && x > layers[here].x_out) ++here;
    const Shape<double>& q = state.shape;
    const bool one_way = wall_.tension_only();
    double drop = radial_drop(layers[here], q, x, layers[here].x_out, one_way);
    for (std::size_t i = here + 1; i < layers.size(); ++i)
        drop += radial_drop(layers[i], q, layers[i].x_in, layers[i].x_out, one_way);
    const Differences d = differences(layers[here], q, x, one_way);
    const double s = std::exp(x);
    return {inner_radius() * std::sqrt((s + q.volume - 1.0) / q.stretch),
            reference_radius,
            -drop,
            d.hoop - drop,
            d.axial - drop,
            d.shear};
}

WallStress Tube::stress(const TubeState& state, double radius) const {
    const double slack = 1e-9 * outer_radius();
    if (!(radius >= state.inner_radius - slack && radius <= outer_radius(state) + slack)) {
        std::ostringstream rule;
        rule.precision(10);
        rule << "within the deformed wall, " << state.inner_radius << " to " << outer_radius(state);
        reject("radius", radius, rule.str());
    }
    const double ratio = radius / inner_radius();
    const double s = ratio * ratio * state.shape.stretch - state.shape.volume + 1.0;
    const double largest = std::exp(wall_.layers().back().x_out);
    return stress_at_reference(state, inner_radius() * std::sqrt(std::clamp(s, 1.0, largest)));
}

std::vector<FibreState> Tube::fibres(const TubeState& state) const {
    static const GaussRule rule = gauss_rule(12);
    std::vector<FibreState> all;
    for (std::size_t i = 0; i < layers_.size(); ++i) {
        const WallLayer& layer = wall_.layers()[i];
        for (const Fibres& fibres : layers_[i].fibres) {
            const WallFamily family{std::cos(fibres.angle), std::sin(fibres.angle), fibres.stiffness, false};
            const auto stretch = [&](double x) {
                double squared, slope;
                Wall::squared_stretch(family, state.shape, x, squared, slope);
                return std::sqrt(squared);
            };
            FibreState at{static_cast<int>(i), fibres.angle, stretch(layer.x_in), stretch(layer.x_out), 0.0, 1.0};
            Wall::TautParts parts;
            parts.count = 1, parts.from[0] = layer.x_in, parts.to[0] = layer.x_out;
            if (wall_.tension_only()) {
                const Wall::TautParts taut = Wall::taut_parts(layer, family, state.shape);
                if (!taut.whole) parts = taut;
            }
            double pull = 0.0, taut = 0.0;
            const double volume = std::exp(layer.x_out) - std::exp(layer.x_in);
            for (int part = 0; part < parts.count; ++part) {
                const double middle = 0.5 * (parts.from[part] + parts.to[part]);
                const double half = 0.5 * (parts.to[part] - parts.from[part]);
                for (int j = 0; j < rule.points; ++j) {
                    const double x = middle + half * rule.node[j], weight = half * rule.weight[j] * std::exp(x);
                    pull += weight * (stretch(x) - 1.0);
                    taut += weight;
                }
            }
            at.tension = fibres.stiffness * pull / volume;
            at.taut_fraction = std::clamp(taut / volume, 0.0, 1.0);
            all.push_back(at);
        }
    }
    return all;
}

std::vector<std::string> Tube::remarks(const TubeState& state) const {
    std::vector<std::string> all;
    const auto say = [&](auto&&... parts) {
        std::ostringstream text;
        text.precision(4);
        (text << ... << parts);
        all.push_back(text.str());
    };
    if (state.flags & law_out_of_range)
        say("a stretch in the wall is beyond the range that a material law was fitted to, by a strain of ",
            largest_strain_excess(state.shape));
    if (state.flags & near_law_limit) say("Gent's law is close to its limit: the answer has four to six digits there");
    if (state.flags & locking)
        say("fibres lock: two-way fibres smeared over a thick layer hold each other, which takes ",
            100.0 * locking_share_, " % of the pressure's work; consider a thin layer of fibres or tension_only=True");
    if (state.flags & slack_fibres) say("some fibres are slack");
    if (state.flags & near_ballooning && state.status != solve::SolveStatus::limit_point)
        say("close to the limit pressure of about ", limit_pressure() * 1e-3, " kPa");
    if (state.flags & negative_pressure)
        say("negative pressure: the model does not know collapse of the wall; it is meant for pressures from zero up");
    if (state.flags & unstable) say("the equilibrium is unstable under given pressure");
    return all;
}

std::string Tube::message(const TubeState& state) const {
    std::ostringstream text;
    text.precision(4);
    switch (state.status) {
        case solve::SolveStatus::converged:
            text << "equilibrium found";
            break;
        case solve::SolveStatus::limit_point:
            if (state.limit_pressure > 0.0 && path_.end() == PathEnd::instability)
                text << "the tube loses its stability at about " << state.limit_pressure * 1e-3
                     << " kPa: no stable equilibrium on the way to " << state.pressure * 1e-3 << " kPa";
            else if (state.limit_pressure > 0.0)
                text << "ballooning at about " << state.limit_pressure * 1e-3 << " kPa: no stable equilibrium at "
                     << state.pressure * 1e-3 << " kPa";
            else
                text << "no stable equilibrium under these loads was found on the way from rest";
            break;
        case solve::SolveStatus::no_progress:
            text << "no such state was found; the nearest one is returned";
            break;
        default:
            text << "no equilibrium found (" << solve::name_of(state.status) << ")";
    }
    for (const std::string& remark : remarks(state)) text << "; " << remark;
    return text.str();
}

}  // namespace softlimb::actuator
