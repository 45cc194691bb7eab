#include "softlimb/actuator/wall.hpp"

#include <algorithm>
#include <numbers>

namespace softlimb::actuator {

template WallEnergy<double> Wall::energy(const Shape<double>& q) const;
template WallEnergy<Dual<1>> Wall::energy(const Shape<Dual<1>>& q) const;
template WallEnergy<Dual<2>> Wall::energy(const Shape<Dual<2>>& q) const;

int Wall::points_for(double x_in, double x_out) {
    // In x = ln s the energy is analytic except where s + w - 1 = 0, a distance of at least pi off the real axis. The
    // error of n points is about e^(-2 n ln(sigma)), sigma the size of the ellipse through that singularity. Two
    // digits more than 1e-12 pay for the large stiffness of fibres beside that of silicone.
    const double half = 0.5 * (x_out - x_in), distance = std::numbers::pi / half;
    const double sigma = distance + std::sqrt(1.0 + distance * distance);
    const int points = static_cast<int>(std::ceil(14.0 * std::numbers::ln10 / (2.0 * std::log(sigma))));
    return std::clamp(points, 3, GaussRule::max_points);
}

namespace {

std::vector<WallPoint> wall_points(double x_in, double x_out, int count) {
    const GaussRule rule = gauss_rule(count);
    const double middle = 0.5 * (x_in + x_out), half = 0.5 * (x_out - x_in);
    std::vector<WallPoint> points;
    for (int i = 0; i < rule.points; ++i) {
        const double x = middle + half * rule.node[i], s = std::exp(x);
        points.push_back({s, 1.0 / s, std::exp(-0.5 * x), half * rule.weight[i] * s});
    }
    return points;
}

}  // namespace

Wall::Wall(const std::vector<Layer>& layers, bool tension_only, int points)
    : tension_only_(tension_only), slack_rule_(gauss_rule(6)), fine_slack_rule_(gauss_rule(12)) {
    // Up to I1 - 3 = 1 (a stretch of 1.65) the few points of `points_for` are enough for every law but Gent's, whose
    // singularity at I1 - 3 = jm comes near from a fraction of jm on.
    fine_from_ = 1.0;
    for (const Layer& layer : layers)
        if (const auto* gent = std::get_if<materials::Gent>(&layer.law))
            fine_from_ = std::min(fine_from_, 0.2 * gent->jm);
    s_out_ = layers.back().outer / layers.front().inner;
    s_out_ *= s_out_;
    const double scale = 1.0 / layers.front().inner;
    for (const Layer& from : layers) {
        WallLayer to{from.law,
                     from.silicone_fraction(),
                     2.0 * std::log(from.inner * scale),
                     2.0 * std::log(from.outer * scale),
                     from.inner * scale * from.inner * scale,
                     from.outer * scale * from.outer * scale,
                     {},
                     {},
                     {}};
        const int few = points > 0 ? points : points_for(to.x_in, to.x_out);
        to.points = wall_points(to.x_in, to.x_out, few);
        to.fine_points = wall_points(to.x_in, to.x_out, std::min(2 * few + 4, GaussRule::max_points));
        std::vector<Fibres> waiting = from.fibres;
        while (!waiting.empty()) {
            const Fibres family = waiting.front();
            waiting.erase(waiting.begin());
            if (family.stiffness == 0.0) continue;
            const auto twin = std::find_if(waiting.begin(), waiting.end(), [&](const Fibres& other) {
                return other.angle == -family.angle && other.stiffness == family.stiffness;
            });
            const bool mirrored = twin != waiting.end();
            if (mirrored) waiting.erase(twin);
            const double right_angle = 0.5 * std::numbers::pi;
            const bool lengthwise = std::abs(family.angle) >= right_angle;
            const double cosine = lengthwise ? 0.0 : std::cos(family.angle);
            to.families.push_back({cosine, std::sin(family.angle), family.stiffness, mirrored});
            if (!mirrored && family.angle != 0.0 && !lengthwise) balanced_ = false;
        }
        layers_.push_back(std::move(to));
    }
}

namespace {

// At rest the stretch is one to rounding throughout: that counts as taut.
constexpr double rounding = 2e-15;

/// Without twist I4 - 1 = A + B/s with constants A and B: taut on one side of s = -B/A.
Wall::TautParts untwisted_taut_parts(const WallLayer& layer, const WallFamily& family, const Shape<double>& q) {
    const double l = q.stretch, sine_squared = family.sine * family.sine;
    const double a = ((1.0 - l) + sine_squared * (l * l * l - 1.0)) / l;
    const double b = (q.volume - 1.0) * family.cosine * family.cosine / l;
    const auto excess = [&](double s) {
        const double value = a + b / s;
        return std::abs(value) <= rounding ? 0.0 : value;
    };
    const bool inside = excess(layer.s_in) >= 0.0, outside = excess(layer.s_out) >= 0.0;
    Wall::TautParts parts;
    if (inside == outside) {
        parts.whole = inside;
        return parts;
    }
    const double boundary = std::clamp(std::log(-b / a), layer.x_in, layer.x_out);
    parts.count = 1;
    parts.from[0] = inside ? layer.x_in : boundary, parts.moving_from[0] = outside;
    parts.to[0] = inside ? boundary : layer.x_out, parts.moving_to[0] = inside;
    return parts;
}

}  // namespace

Wall::TautParts Wall::taut_parts(const WallLayer& layer, const WallFamily& family, const Shape<double>& q) {
    if (q.twist == 0.0) return untwisted_taut_parts(layer, family, q);
    constexpr int most = GaussRule::max_points + 2;
    struct Sample {
        double x, excess, slope;
    };
    const auto sample = [&](double x) {
        Sample at{x, 0.0, 0.0};
        squared_stretch(family, q, x, at.excess, at.slope);
        at.excess -= 1.0;
        if (std::abs(at.excess) <= rounding) at.excess = 0.0;
        return at;
    };
    const auto root = [&](Sample left, Sample right) {  // safeguarded Newton
        double x = 0.5 * (left.x + right.x);
        for (int i = 0; i < 60; ++i) {
            const Sample at = sample(x);
            ((at.excess >= 0.0) == (left.excess >= 0.0) ? left : right) = at;
            double next = at.x - at.excess / at.slope;
            if (!(next > left.x && next < right.x)) next = 0.5 * (left.x + right.x);
            // The energy there is the square of what is left: more digits than these change nothing.
            if (std::abs(next - x) <= 1e-15) return next;
            x = next;
        }
        return x;
    };

    Sample samples[2 * most];
    int count = 0;
    samples[count++] = sample(layer.x_in);
    constexpr int inside = 4;
    for (int i = 1; i < inside; ++i) samples[count++] = sample(layer.x_in + (layer.x_out - layer.x_in) * i / inside);
    samples[count++] = sample(layer.x_out);

    TautParts parts;
    double crossing[max_parts * 2];
    int crossings = 0;
    const auto add_root = [&](const Sample& a, const Sample& b) {
        if (crossings < 2 * max_parts - 1) crossing[crossings++] = root(a, b);
    };
    for (int i = 0; i + 1 < count; ++i) {
        const Sample &a = samples[i], &b = samples[i + 1];
        if ((a.excess >= 0.0) != (b.excess >= 0.0)) {
            add_root(a, b);
        } else if (a.excess * a.slope < 0.0 && b.excess * b.slope > 0.0) {
            // Heads for zero from both sides: look at the turning point between.
            Sample left = a, right = b, middle = a;
            for (int step = 0; step < 50; ++step) {
                middle = sample(0.5 * (left.x + right.x));
                if ((middle.excess >= 0.0) != (a.excess >= 0.0)) break;
                (middle.slope * a.slope > 0.0 ? left : right) = middle;
            }
            if ((middle.excess >= 0.0) != (a.excess >= 0.0)) add_root(a, middle), add_root(middle, b);
        }
    }
    bool taut = samples[0].excess >= 0.0;
    if (crossings == 0) {
        parts.whole = taut;
        return parts;
    }
    double from = layer.x_in;
    bool moving = false;
    for (int i = 0; i <= crossings; ++i) {
        const double to = i < crossings ? crossing[i] : layer.x_out;
        if (taut && parts.count < max_parts) {
            parts.from[parts.count] = from, parts.moving_from[parts.count] = moving;
            parts.to[parts.count] = to, parts.moving_to[parts.count] = i < crossings;
            ++parts.count;
        }
        taut = !taut;
        from = to;
        moving = true;
    }
    return parts;
}

}  // namespace softlimb::actuator
