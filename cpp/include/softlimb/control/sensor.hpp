#pragma once
// A pressure sensor with noise, offset and a converter.
#include <cstdint>

namespace softlimb::control {

enum class SensorFault : std::uint8_t { none, not_finite, stuck };

struct SensorParameters {
    double low, high;  // what the converter spans [Pa]
    double noise;      // standard deviation of a reading [Pa]
    double offset;     // [Pa]
    int bits;          // of the converter; zero: none, and no limits either
};

/// Normal random numbers from a seed: the same on every machine that rounds alike.
class Noise {
public:
    explicit Noise(std::uint64_t seed) : state_(seed) {}
    double normal();

private:
    double uniform();  // within (0, 1)
    std::uint64_t state_;
    double spare_ = 0.0;
    bool has_spare_ = false;
};

class Sensor {
public:
    Sensor(const SensorParameters& parameters, std::uint64_t seed) : parameters_(parameters), noise_(seed) {}

    /// The next reading. Noise is drawn in any case, so that a fault does not change the readings after it.
    double read(double pressure);

    SensorFault fault = SensorFault::none;
    double bias = 0.0;  // on top of the offset, as a disturbance [Pa]

private:
    SensorParameters parameters_;
    Noise noise_;
    double last_ = 0.0;
};

}  // namespace softlimb::control
