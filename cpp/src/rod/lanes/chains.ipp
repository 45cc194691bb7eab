// Elimination of a chain's interior nodes; included by pieces.ipp, in its namespace. Here the lanes are the rows of a
// column of six, filled up with zeros.

constexpr int parts = (6 + W - 1) / W;  // packs a column

struct Column {
    Pack part[parts];

    SOFTLIMB_ALWAYS_INLINE friend Column operator+(const Column& a, const Column& b) {
        Column c;
        for (int i = 0; i < parts; ++i) c.part[i] = a.part[i] + b.part[i];
        return c;
    }
    SOFTLIMB_ALWAYS_INLINE friend Column operator*(const Pack& s, const Column& a) {
        Column c;
        for (int i = 0; i < parts; ++i) c.part[i] = s * a.part[i];
        return c;
    }
    /// a - s b.
    SOFTLIMB_ALWAYS_INLINE friend Column less(const Column& a, const Pack& s, const Column& b) {
        Column c;
        for (int i = 0; i < parts; ++i) c.part[i] = a.part[i] - s * b.part[i];
        return c;
    }
    SOFTLIMB_ALWAYS_INLINE double get(int row) const { return part[row / W].get(row % W); }
    SOFTLIMB_ALWAYS_INLINE void set(int row, double x) { part[row / W].set(row % W, x); }
};

SOFTLIMB_ALWAYS_INLINE Column nothing() {
    Column c;
    for (int i = 0; i < parts; ++i) c.part[i] = Pack(0.0);
    return c;
}

SOFTLIMB_ALWAYS_INLINE Column load(const double* from) {
    Column c;
    for (int i = 0; i < parts; ++i) {
        const int rows = 6 - W * i < W ? 6 - W * i : W;
        c.part[i] = load_some(from + W * i, rows);
    }
    return c;
}

SOFTLIMB_ALWAYS_INLINE void store(double* to, const Column& c) {
    for (int i = 0; i < parts; ++i) store_some(to + W * i, c.part[i], 6 - W * i < W ? 6 - W * i : W);
}

/// A 6 x 6 block with its numbers in memory, where they are read one by one as factors of columns.
struct Block {
    alignas(64) double x[6][W * parts];
    SOFTLIMB_ALWAYS_INLINE Column column(int c) const {
        Column out;
        for (int i = 0; i < parts; ++i) out.part[i] = load_some(&x[c][W * i], W);
        return out;
    }
    SOFTLIMB_ALWAYS_INLINE void put(int c, const Column& a) {
        for (int i = 0; i < parts; ++i) store_some(&x[c][W * i], a.part[i], W);
    }
};

SOFTLIMB_ALWAYS_INLINE void read(const double* from, int stride, Block& to) {
    for (int c = 0; c < 6; ++c) to.put(c, load(from + stride * c));
}

SOFTLIMB_ALWAYS_INLINE void write(const Block& from, double* to, int stride) {
    for (int c = 0; c < 6; ++c) store(to + stride * c, from.column(c));
}

SOFTLIMB_ALWAYS_INLINE Column times(const Column* a, const double* b) {
    Column sum = Pack(b[0]) * a[0];
    for (int k = 1; k < 6; ++k) sum = less(sum, Pack(-b[k]), a[k]);
    return sum;
}

SOFTLIMB_ALWAYS_INLINE void columns_of(const Block& block, Column* to) {
    for (int c = 0; c < 6; ++c) to[c] = block.column(c);
}

/// Gauss and Jordan in place on columns. Without `positive` columns are exchanged for the largest pivot of a row; with
/// it the block is symmetric, needs no exchange, and must have positive pivots. False where it has not, or a pivot
/// vanishes or is no number.
SOFTLIMB_ALWAYS_INLINE bool invert(Block& a, bool positive) {
    int exchanged[6];
    bool any = false;
    for (int k = 0; k < 6; ++k) {
        exchanged[k] = k;
        if (!positive) {
            int best = k;
            for (int c = k + 1; c < 6; ++c)
                if (std::abs(a.x[c][k]) > std::abs(a.x[best][k])) best = c;
            exchanged[k] = best;
            if (best != k) {
                any = true;
                const Column one = a.column(k), other = a.column(best);
                a.put(k, other), a.put(best, one);
            }
        }
        const double pivot = a.x[k][k];
        const bool regular = positive ? pivot > 0.0 && pivot < 1e308 : std::abs(pivot) > 0.0 && std::abs(pivot) < 1e308;
        if (!regular) return false;
        const double scale = 1.0 / pivot;
        double factor[6];
        for (int c = 0; c < 6; ++c) factor[c] = a.x[c][k];
        Column unit = nothing();
        unit.set(k, 1.0);
        // Row k of the other columns becomes zero, exactly, and the pivot's own column that of the inverse.
        const Column own = less(Pack(scale) * less(a.column(k), Pack(pivot), unit), Pack(-scale), unit);
        for (int c = 0; c < 6; ++c)
            if (c != k) a.put(c, less(less(a.column(c), Pack(factor[c]), unit), Pack(factor[c]), own));
        a.put(k, own);
    }
    if (any)
        for (int k = 5; k >= 0; --k)
            if (exchanged[k] != k)
                for (int c = 0; c < 6; ++c) {
                    const double x = a.x[c][k];
                    a.x[c][k] = a.x[c][exchanged[k]], a.x[c][exchanged[k]] = x;
                }
    return true;
}

bool condense(const double* elements, int count, double* ends, Elimination* out, const double* shift, bool symmetric,
              bool positive) {
    // Blocks of the chain so far, between its first node (0) and its last one (1); an element is 12 forces and 144.
    constexpr int size = 156;
    Block k00, k01, k10, k11;
    const auto block = [](const double* element, int row, int column)
                           SOFTLIMB_LAMBDA_INLINE { return element + 12 + 72 * column + 6 * row; };
    read(block(elements, 0, 0), 12, k00), read(block(elements, 0, 1), 12, k01);
    read(block(elements, 1, 0), 12, k10), read(block(elements, 1, 1), 12, k11);
    Column f0 = load(elements), f1 = load(elements + 6);
    for (int e = 1; e < count; ++e) {
        const double* next = elements + size * e;
        Elimination& o = out[e - 1];
        Block pivot;
        for (int c = 0; c < 6; ++c) pivot.put(c, k11.column(c) + load(block(next, 0, 0) + 12 * c));
        for (int c = 0; c < 6; ++c) pivot.x[c][c] += shift[c];
        if (symmetric)
            for (int c = 0; c < 6; ++c)
                for (int r = 0; r < c; ++r) pivot.x[c][r] = pivot.x[r][c] = 0.5 * (pivot.x[c][r] + pivot.x[r][c]);
        write(pivot, o.pivot, 6);
        if (!invert(pivot, positive)) return false;
        write(pivot, o.inverse, 6);
        write(k01, o.first_row, 6);

        Column inverse[6], first_row[6], next_row[6];
        columns_of(pivot, inverse), columns_of(k01, first_row);
        for (int c = 0; c < 6; ++c) next_row[c] = load(block(next, 1, 0) + 12 * c);
        Block force, by_first, by_next;
        force.put(0, f1 + load(next));
        const Column right = times(inverse, force.x[0]);
        store(o.right, right);
        force.put(0, right);
        const Column on_first = times(first_row, force.x[0]), on_next = times(next_row, force.x[0]);
        f0 = less(f0, Pack(1.0), on_first), f1 = less(load(next + 6), Pack(1.0), on_next);
        for (int c = 0; c < 6; ++c) {
            by_first.put(c, times(inverse, k10.x[c]));
            by_next.put(c, times(inverse, block(next, 0, 1) + 12 * c));
        }
        write(by_first, o.by_first, 6), write(by_next, o.by_next, 6);
        for (int c = 0; c < 6; ++c) {
            k00.put(c, less(k00.column(c), Pack(1.0), times(first_row, by_first.x[c])));
            k01.put(c, Pack(-1.0) * times(first_row, by_next.x[c]));
            k10.put(c, Pack(-1.0) * times(next_row, by_first.x[c]));
            k11.put(c, less(load(block(next, 1, 1) + 12 * c), Pack(1.0), times(next_row, by_next.x[c])));
        }
    }
    store(ends, f0), store(ends + 6, f1);
    write(k00, ends + 12, 12), write(k01, ends + 12 + 72, 12);
    write(k10, ends + 12 + 6, 12), write(k11, ends + 12 + 72 + 6, 12);
    return true;
}

/// Column whose lower half is `x`.
SOFTLIMB_ALWAYS_INLINE Column below(double x, double y, double z) {
    Column c = nothing();
    c.set(3, x), c.set(4, y), c.set(5, z);
    return c;
}

/// Adds L^T K L' to a block: K couples forces at `row_arm` from a plate's origin with moves at `column_arm` from one.
SOFTLIMB_ALWAYS_INLINE void add_carried(const double* k, const double* row_arm, const double* column_arm, double* to) {
    Column c[6];
    for (int i = 0; i < 6; ++i) c[i] = load(k + 12 * i);
    const Pack x(column_arm[0]), y(column_arm[1]), z(column_arm[2]);
    c[3] = less(less(c[3], z, c[1]), -y, c[2]);
    c[4] = less(less(c[4], -z, c[0]), x, c[2]);
    c[5] = less(less(c[5], y, c[0]), -x, c[1]);
    const double* a = row_arm;
    const Column by_x = below(0.0, a[2], -a[1]), by_y = below(-a[2], 0.0, a[0]), by_z = below(a[1], -a[0], 0.0);
    for (int i = 0; i < 6; ++i) {
        const Column turned =
            less(less(less(c[i], Pack(-c[i].get(0)), by_x), Pack(-c[i].get(1)), by_y), Pack(-c[i].get(2)), by_z);
        store(to + 6 * i, load(to + 6 * i) + turned);
    }
}

void carry(const double* ends, const double* base_arm, const double* end_arm, double* base, double* upper,
           double* lower, double* end) {
    const double* k = ends + 12;
    add_carried(k + 78, end_arm, end_arm, end);
    if (base == nullptr) return;
    add_carried(k, base_arm, base_arm, base);
    add_carried(k + 72, base_arm, end_arm, upper);
    add_carried(k + 6, end_arm, base_arm, lower);
}
