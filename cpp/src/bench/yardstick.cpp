// Nothing of the package is used here, and CMakeLists.txt fixes the instruction set: what makes the package faster must
// not shorten what it is measured with. The checksum fixes the arithmetic.
#include "softlimb/bench/yardstick.hpp"

#include <algorithm>
#include <chrono>
#include <limits>

namespace softlimb::bench {
namespace {

// Passed by value: references cost GCC 12 five per cent more instructions here.
struct Vector {
    double x, y, z;
};

inline Vector plus(Vector a, Vector b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
inline Vector times(double s, Vector a) { return {s * a.x, s * a.y, s * a.z}; }
inline double inner(Vector a, Vector b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline Vector outer(Vector a, Vector b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

/// Compliances of a section, 1/GA, 1/EA [1/N] and 1/EI, 1/GJ [1/(N m^2)].
struct Softness {
    double shear, axial, bending, torsion;
};

/// Of a point of a rod: position [m], rotation as a quaternion (w, x, y, z), internal moment [N m]; base axes.
struct Point {
    Vector position;
    double w, x, y, z;
    Vector moment;
};

/// Derivative of a point to the arclength: Zhang et al. eq. 4-6 with the force n known. MECHANICS, "Rod": a section
/// without preferred axis across needs the tangent t alone, K^-1 = a + (b - a) t t^T.
inline Point rate(const Softness& c, const Point& at, const Vector& n) {
    const Vector t{2 * (at.x * at.z + at.w * at.y), 2 * (at.y * at.z - at.w * at.x),
                   1 - 2 * (at.x * at.x + at.y * at.y)};
    const Vector strain = plus(plus(t, times(c.shear, n)), times((c.axial - c.shear) * inner(t, n), t));
    const Vector spin = plus(times(c.bending, at.moment), times((c.torsion - c.bending) * inner(t, at.moment), t));
    return {strain,
            0.5 * (-spin.x * at.x - spin.y * at.y - spin.z * at.z),
            0.5 * (spin.x * at.w + spin.y * at.z - spin.z * at.y),
            0.5 * (spin.y * at.w + spin.z * at.x - spin.x * at.z),
            0.5 * (spin.z * at.w + spin.x * at.y - spin.y * at.x),
            times(-1.0, outer(strain, n))};
}

inline Point moved(const Point& at, double h, const Point& k) {
    return {plus(at.position, times(h, k.position)), at.w + h * k.w, at.x + h * k.x, at.y + h * k.y, at.z + h * k.z,
            plus(at.moment, times(h, k.moment))};
}

inline Point end_of_rod(const Softness& c, double length, Point at, const Vector& base_force, const Vector& load,
                        int steps) {
    const double h = length / steps, sixth = h / 6;
    for (int i = 0; i < steps; ++i) {
        const Vector first = plus(base_force, times(-h * i, load));  // n' = -load
        const Vector middle = plus(first, times(-0.5 * h, load)), last = plus(first, times(-h, load));
        const Point k1 = rate(c, at, first);
        const Point k2 = rate(c, moved(at, 0.5 * h, k1), middle);
        const Point k3 = rate(c, moved(at, 0.5 * h, k2), middle);
        const Point k4 = rate(c, moved(at, h, k3), last);
        at = moved(moved(moved(moved(at, sixth, k1), 2 * sixth, k2), 2 * sixth, k3), sixth, k4);
    }
    return at;
}

constexpr int rods = 9, steps = 8, passes = 2000;
constexpr double length = 0.2;             // [m]
constexpr Vector base_force{0.1, 0, 0.2};  // [N]
constexpr Vector load{0.1, 0.2, -1.0};     // [N/m]
constexpr double first_moment = 0.05;      // [N m], about x
constexpr double moment_a_pass = 1e-6,
                 moment_a_rod = 1e-3;  // [N m]: no two rods alike, or the compiler would drop them

}  // namespace

Yardstick yardstick(int repetitions) {
    const Softness softness{1 / 200.0, 1 / 600.0, 1 / 0.03, 1 / 0.02};
    double least = std::numeric_limits<double>::infinity(), sum = 0;
    for (int repetition = 0; repetition < repetitions; ++repetition) {
        sum = 0;
        const auto began = std::chrono::steady_clock::now();
        for (int pass = 0; pass < passes; ++pass)
            for (int rod = 0; rod < rods; ++rod) {
                const Point base{{0, 0, 0}, 1, 0, 0, 0, {first_moment, moment_a_pass * pass, moment_a_rod * rod}};
                const Point end = end_of_rod(softness, length, base, base_force, load, steps);
                sum += end.position.x + end.position.y + end.position.z;
            }
        const std::chrono::duration<double, std::micro> took = std::chrono::steady_clock::now() - began;
        least = std::min(least, took.count() / passes);
    }
    return {least, sum / (passes * rods)};
}

}  // namespace softlimb::bench
