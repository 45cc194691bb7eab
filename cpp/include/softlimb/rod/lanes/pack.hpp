// A pack of numbers, one a lane, as the scalar of the rod equations. Included once an instruction set, inside the
// namespace SOFTLIMB_INSTRUCTION_SET, with SOFTLIMB_LANES numbers: every name here is another one each time.
#if defined(__GNUC__) || defined(__clang__)

struct Mask {
    typedef long long Raw __attribute__((vector_size(8 * SOFTLIMB_LANES)));
    Raw raw;
};

struct Pack {
    static constexpr int lanes = SOFTLIMB_LANES;
    typedef double Raw __attribute__((vector_size(8 * SOFTLIMB_LANES)));
    Raw raw;

    SOFTLIMB_ALWAYS_INLINE Pack() {}
    SOFTLIMB_ALWAYS_INLINE Pack(double x) : raw(Raw{} + x) {}  // NOLINT: a constant fills all lanes, as in the formulas
    SOFTLIMB_ALWAYS_INLINE explicit Pack(Raw x) : raw(x) {}
    SOFTLIMB_ALWAYS_INLINE double get(int lane) const { return raw[lane]; }
    SOFTLIMB_ALWAYS_INLINE void set(int lane, double x) { raw[lane] = x; }

    SOFTLIMB_ALWAYS_INLINE friend Pack operator+(Pack a, Pack b) { return Pack(a.raw + b.raw); }
    SOFTLIMB_ALWAYS_INLINE friend Pack operator-(Pack a, Pack b) { return Pack(a.raw - b.raw); }
    SOFTLIMB_ALWAYS_INLINE friend Pack operator*(Pack a, Pack b) { return Pack(a.raw * b.raw); }
    SOFTLIMB_ALWAYS_INLINE friend Pack operator/(Pack a, Pack b) { return Pack(a.raw / b.raw); }
    SOFTLIMB_ALWAYS_INLINE friend Pack operator-(Pack a) { return Pack(-a.raw); }
    SOFTLIMB_ALWAYS_INLINE friend Mask operator<(Pack a, Pack b) { return {a.raw < b.raw}; }
    SOFTLIMB_ALWAYS_INLINE friend Pack select(Mask m, Pack a, Pack b) { return Pack(m.raw ? a.raw : b.raw); }
};

#else  // a compiler without vector types: the same lanes one after the other

struct Mask {
    bool raw[SOFTLIMB_LANES];
};

struct Pack {
    static constexpr int lanes = SOFTLIMB_LANES;
    double raw[SOFTLIMB_LANES];

    Pack() {}
    Pack(double x) {
        for (double& r : raw) r = x;
    }
    double get(int lane) const { return raw[lane]; }
    void set(int lane, double x) { raw[lane] = x; }

    template <class F>
    static SOFTLIMB_ALWAYS_INLINE Pack each(F&& f) {
        Pack out;
        for (int i = 0; i < lanes; ++i) out.raw[i] = f(i);
        return out;
    }
    SOFTLIMB_ALWAYS_INLINE friend Pack operator+(const Pack& a, const Pack& b) {
        return each([&](int i) { return a.raw[i] + b.raw[i]; });
    }
    SOFTLIMB_ALWAYS_INLINE friend Pack operator-(const Pack& a, const Pack& b) {
        return each([&](int i) { return a.raw[i] - b.raw[i]; });
    }
    SOFTLIMB_ALWAYS_INLINE friend Pack operator*(const Pack& a, const Pack& b) {
        return each([&](int i) { return a.raw[i] * b.raw[i]; });
    }
    SOFTLIMB_ALWAYS_INLINE friend Pack operator/(const Pack& a, const Pack& b) {
        return each([&](int i) { return a.raw[i] / b.raw[i]; });
    }
    SOFTLIMB_ALWAYS_INLINE friend Pack operator-(const Pack& a) {
        return each([&](int i) { return -a.raw[i]; });
    }
    SOFTLIMB_ALWAYS_INLINE friend Mask operator<(const Pack& a, const Pack& b) {
        Mask m;
        for (int i = 0; i < lanes; ++i) m.raw[i] = a.raw[i] < b.raw[i];
        return m;
    }
    SOFTLIMB_ALWAYS_INLINE friend Pack select(const Mask& m, const Pack& a, const Pack& b) {
        return each([&](int i) { return m.raw[i] ? a.raw[i] : b.raw[i]; });
    }
};

#endif

SOFTLIMB_ALWAYS_INLINE Pack absolute(Pack a) { return select(a < Pack(0.0), -a, a); }

/// Square root, lane by lane: IEEE's own, so the same in every instruction set.
SOFTLIMB_ALWAYS_INLINE Pack sqrt(Pack a) {
    Pack out;
    for (int i = 0; i < Pack::lanes; ++i) out.set(i, __builtin_sqrt(a.get(i)));
    return out;
}

/// The first `count` lanes from memory, zeros in the others; and back. The count is a constant where these are inlined.
SOFTLIMB_ALWAYS_INLINE Pack load_some(const double* from, int count) {
#ifdef __AVX512F__
    if constexpr (Pack::lanes == 8)
        return Pack(
            static_cast<Pack::Raw>(_mm512_maskz_loadu_pd(static_cast<unsigned char>((1u << count) - 1u), from)));
#endif
    Pack p(0.0);
    for (int i = 0; i < count; ++i) p.set(i, from[i]);
    return p;
}
SOFTLIMB_ALWAYS_INLINE void store_some(double* to, const Pack& p, int count) {
#ifdef __AVX512F__
    if constexpr (Pack::lanes == 8) {
        _mm512_mask_storeu_pd(to, static_cast<unsigned char>((1u << count) - 1u), static_cast<__m512d>(p.raw));
        return;
    }
#endif
    for (int i = 0; i < count; ++i) to[i] = p.get(i);
}
