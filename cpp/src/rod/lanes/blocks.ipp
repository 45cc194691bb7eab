// Poses, and blocks of six by six, a limb a lane; included by limbs.ipp, in its namespace.

/// A force and a moment, or a shift and a turn.
struct Pair {
    V first, second;

    SOFTLIMB_ALWAYS_INLINE void write(Pack* x) const {
        x[0] = first.x, x[1] = first.y, x[2] = first.z, x[3] = second.x, x[4] = second.y, x[5] = second.z;
    }
    SOFTLIMB_ALWAYS_INLINE static Pair of(const Pack* x) { return {{x[0], x[1], x[2]}, {x[3], x[4], x[5]}}; }
    SOFTLIMB_ALWAYS_INLINE friend Pair operator+(const Pair& a, const Pair& b) {
        return {a.first + b.first, a.second + b.second};
    }
    SOFTLIMB_ALWAYS_INLINE friend Pair operator-(const Pair& a, const Pair& b) {
        return {a.first - b.first, a.second - b.second};
    }
    SOFTLIMB_ALWAYS_INLINE friend Pair operator-(const Pair& a) { return {-a.first, -a.second}; }
};

Pair no_pair() {
    const V zero{Pack(0.0), Pack(0.0), Pack(0.0)};
    return {zero, zero};
}

Pair times(const M6& m, const Pair& x) {
    Pack out[6], in[6];
    x.write(in);
    for (int r = 0; r < 6; ++r) out[r] = m(r, 0) * in[0];
    for (int c = 1; c < 6; ++c)
        for (int r = 0; r < 6; ++r) out[r] = out[r] + m(r, c) * in[c];
    return Pair::of(out);
}

/// c + s a b.
void add_product(const M6& a, const M6& b, double s, M6& c) {
    for (int column = 0; column < 6; ++column) {
        Pack sum[6];
        for (int r = 0; r < 6; ++r) sum[r] = c(r, column);
        for (int k = 0; k < 6; ++k) {
            const Pack factor = Pack(s) * b(k, column);
            for (int r = 0; r < 6; ++r) sum[r] = sum[r] + a(r, k) * factor;
        }
        for (int r = 0; r < 6; ++r) c(r, column) = sum[r];
    }
}

void set_zero(M6& a) {
    for (int c = 0; c < 6; ++c)
        for (int r = 0; r < 6; ++r) a(r, c) = Pack(0.0);
}

void invert_block(const M6& a, M6& b) { invert(a, b); }

/// Cholesky's factor of the symmetric part of `a`: ones in the lanes where it exists.
Pack factor_symmetric(const M6& a, M6& lower) {
    Pack positive(1.0);
    for (int c = 0; c < 6; ++c) {
        Pack pivot = a(c, c);
        for (int k = 0; k < c; ++k) pivot = pivot - lower(c, k) * lower(c, k);
        positive = select(Pack(0.0) < pivot, positive, Pack(0.0));
        const Pack root = sqrt(pivot), per_root = Pack(1.0) / root;
        lower(c, c) = root;
        for (int r = c + 1; r < 6; ++r) {
            Pack x = Pack(0.5) * (a(r, c) + a(c, r));
            for (int k = 0; k < c; ++k) x = x - lower(r, k) * lower(c, k);
            lower(r, c) = x * per_root;
        }
    }
    return positive;
}

/// lower^-1 b, in place.
void substitute(const M6& lower, M6& b) {
    for (int c = 0; c < 6; ++c)
        for (int r = 0; r < 6; ++r) {
            Pack x = b(r, c);
            for (int k = 0; k < r; ++k) x = x - lower(r, k) * b(k, c);
            b(r, c) = x / lower(r, r);
        }
}

/// a - b^T b.
void less_square(M6& a, const M6& b) {
    for (int c = 0; c < 6; ++c)
        for (int r = 0; r < 6; ++r) {
            Pack x = a(r, c);
            for (int k = 0; k < 6; ++k) x = x - b(k, r) * b(k, c);
            a(r, c) = x;
        }
}

/// A pose: position, and the columns of the rotation.
struct Frame {
    V position, axis[3];

    SOFTLIMB_ALWAYS_INLINE V turned(const V& v) const { return v.x * axis[0] + v.y * axis[1] + v.z * axis[2]; }
};

V constant(const double* x) { return {Pack(x[0]), Pack(x[1]), Pack(x[2])}; }

Frame fixed(const double* pose) {
    return {constant(pose), {constant(pose + 3), constant(pose + 6), constant(pose + 9)}};
}

/// `pose` given in `frame`, in base axes.
Frame seen_from_base(const Frame& frame, const double* pose) {
    return {frame.position + frame.turned(constant(pose)),
            {frame.turned(constant(pose + 3)), frame.turned(constant(pose + 6)), frame.turned(constant(pose + 9))}};
}

V chosen(Mask m, const V& a, const V& b) { return {select(m, a.x, b.x), select(m, a.y, b.y), select(m, a.z, b.z)}; }

Pair chosen(Mask m, const Pair& a, const Pair& b) {
    return {chosen(m, a.first, b.first), chosen(m, a.second, b.second)};
}

/// Moves a frame by (dp, dtheta), a turn of half a radian at most, in the lanes of the mask.
void move(Frame& frame, const Pair& by, Mask where) {
    const V& turn = by.second;
    const Pack z = dot(turn, turn);
    // sin(t)/t and (1 - cos t)/t^2 in z = t^2: below a quarter what is left out is under 1e-17.
    Pack sine(0.0), versine(0.0);
    constexpr int terms = 8;
    for (int k = terms; k >= 0; --k) {
        sine = Pack(1.0) - z * Pack(1.0 / ((2 * k + 2) * (2 * k + 3))) * sine;
        versine = Pack(1.0) - z * Pack(1.0 / ((2 * k + 3) * (2 * k + 4))) * versine;
    }
    versine = Pack(0.5) * versine;
    const auto turned = [&](const V& v) {
        const V once = cross(turn, v);
        return v + sine * once + versine * cross(turn, once);
    };
    const V tangent = normalised(turned(frame.axis[2])), director = turned(frame.axis[0]);
    const V across = normalised(director - dot(director, tangent) * tangent);
    frame.position = chosen(where, frame.position + by.first, frame.position);
    frame.axis[0] = chosen(where, across, frame.axis[0]);
    frame.axis[1] = chosen(where, cross(tangent, across), frame.axis[1]);
    frame.axis[2] = chosen(where, tangent, frame.axis[2]);
}
