// A rod alone, whose pieces follow one another: no lanes, but this instruction set's arithmetic.

/// A double under a name of this namespace: what is compiled with it cannot be shared with the rest of the library.
struct Number {
    double raw = 0.0;

    SOFTLIMB_ALWAYS_INLINE Number() {}
    SOFTLIMB_ALWAYS_INLINE Number(double x) : raw(x) {}  // NOLINT: constants, as in the formulas
    SOFTLIMB_ALWAYS_INLINE friend Number operator+(Number a, Number b) { return a.raw + b.raw; }
    SOFTLIMB_ALWAYS_INLINE friend Number operator-(Number a, Number b) { return a.raw - b.raw; }
    SOFTLIMB_ALWAYS_INLINE friend Number operator*(Number a, Number b) { return a.raw * b.raw; }
    SOFTLIMB_ALWAYS_INLINE friend Number operator/(Number a, Number b) { return a.raw / b.raw; }
    SOFTLIMB_ALWAYS_INLINE friend Number operator-(Number a) { return -a.raw; }
    SOFTLIMB_ALWAYS_INLINE friend Number sqrt(Number a) { return __builtin_sqrt(a.raw); }
    SOFTLIMB_ALWAYS_INLINE friend double value_of(Number a) { return a.raw; }
};

SOFTLIMB_ALWAYS_INLINE Vec3<Number> numbers(const Vec3<double>& a) { return {a.x, a.y, a.z}; }
SOFTLIMB_ALWAYS_INLINE Vec3<double> plain(const Vec3<Number>& a) { return {a.x.raw, a.y.raw, a.z.raw}; }

template <class Rule, int columns, template <class> class State>
SOFTLIMB_ALWAYS_INLINE void shoot_by(const RodAlone& rod, State<Number> y, RodState<double>* node,
                                     Variation<double> (*column)[2]) {
    const Compliances<Number> k(*rod.section);
    const LineLoad<Number> load{numbers(rod.load.force), numbers(rod.load.moment)};
    const Number length = -rod.length / rod.pieces;
    Columns<Number, columns> z;
    for (int c = 0; c < columns; ++c) z.column[c].rotation = numbers(column[rod.pieces][c].rotation);
    Vec3<Number> n = numbers(rod.tip_force);
    for (int i = rod.pieces; i-- > 0;) {
        advance<Rule, columns>(k, load, length, rod.steps, n, y, z);
        node[i].position = plain(y.position), node[i].tangent = plain(y.tangent), node[i].moment = plain(y.moment);
        if constexpr (requires { y.director; }) node[i].director = plain(y.director);
        for (int c = 0; c < columns; ++c)
            column[i][c] = {plain(z.column[c].position), plain(z.column[c].rotation), plain(z.column[c].moment)};
    }
}

void shoot_alone(const RodAlone& rod, RodState<double>* node, Variation<double> (*column)[2]) {
    const RodState<double>& tip = node[rod.pieces];
    const AxisState<Number> axis{numbers(tip.position), numbers(tip.tangent), numbers(tip.moment)};
    if (rod.wanted == Wanted::slopes)
        shoot_by<Rk4, 2>(rod, axis, node, column);
    else if (rod.wanted == Wanted::axis)
        shoot_by<Rk8, 0>(rod, axis, node, nullptr);
    else
        shoot_by<Rk8, 0>(rod, RodState<Number>{axis.position, axis.tangent, numbers(tip.director), axis.moment}, node,
                         nullptr);
}
