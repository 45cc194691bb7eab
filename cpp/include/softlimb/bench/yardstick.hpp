#pragma once
// A fixed piece of work that times of this package are compared with: what they are multiples of means the same on a
// fast machine, a slow one, and one that changes its speed.

namespace softlimb::bench {

struct Yardstick {
    double microseconds;  // of one pass, least of all repetitions
    double checksum;      // mean over rods and passes of x + y + z of the rod's end [m]
};

/// Time of one pass of nine transversely isotropic rods by eight steps of the classical Runge-Kutta method each: pose
/// and moment from base to end, no sensitivities, one rod after the other. `repetitions` (at least 1) times 2000
/// passes.
Yardstick yardstick(int repetitions);

}  // namespace softlimb::bench
