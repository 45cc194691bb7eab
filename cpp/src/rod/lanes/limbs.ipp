// Newton for limbs side by side, a limb a lane; included by pieces.ipp, in its namespace. The same equations as
// limb::Equilibrium, which says where they come from.

namespace limbs {

constexpr double share_of_tip = 1e-3;  // of a wrench's relative error in the error of the tip, as in limb::Equilibrium
// Of the bound on how much the stiffness changes with a step. Over the last step of 1184 random rows of the reference
// limb the eigenvalue nearest to zero changed by a fortieth of the bound at most.
constexpr double share_of_change = 0.15;

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

const Pair nothing_at_all() {
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

V larger_part(Mask m, const V& a, const V& b) {
    return {select(m, a.x, b.x), select(m, a.y, b.y), select(m, a.z, b.z)};
}

Pair chosen(Mask m, const Pair& a, const Pair& b) {
    return {larger_part(m, a.first, b.first), larger_part(m, a.second, b.second)};
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
    frame.position = larger_part(where, frame.position + by.first, frame.position);
    frame.axis[0] = larger_part(where, across, frame.axis[0]);
    frame.axis[1] = larger_part(where, cross(tangent, across), frame.axis[1]);
    frame.axis[2] = larger_part(where, tangent, frame.axis[2]);
}

/// What is left of a node of a rod that was eliminated; see `Elimination`.
struct Knot {
    M6 inverse, first_row, by_first, by_next;
    Pair right;
};

struct Piece {
    Linearised linear;
    Pair wrench, wrench_move, start_force, end_force;
    V end_position, end_axis[3];
    Pair end_wrench, gap;
};

struct Rod {
    LaneCompliances k;
    Pack length, rest_length;  // of a piece; of the rod
    LineLoad<Pack> load;
    V base_arm, end_arm;  // of its ends from the plates' origins
    Frame* node;          // elements + 1
    Pair* move;           // elements + 1
    Piece* piece;         // elements
    Knot* knot;           // elements - 1, of nodes 1 ...
    Pair* interior;       // elements - 1
    Pair force[2];
    M6 stiffness[2][2];
};

struct Plate {
    Frame pose;
    Pair residual, move;
    M6 diagonal, lower, upper, inverse;
};

/// Ones and zeros say yes and no.
struct Room {
    Plate* plate;
    Rod* rod;
    Pack running, converged, failed, stable, asked_again;
    Pack iterations, residual, error, neutral;
    Pack moment_unit, force_unit;  // EI/l and EI/l^2, the largest of the rods
};

struct Carver {
    unsigned char* at;
    std::size_t used = 0;
    template <class T>
    T* many(int count) {
        T* first = reinterpret_cast<T*>(at + used);
        used += sizeof(T) * static_cast<std::size_t>(count);
        return first;
    }
};

/// Puts the room's parts into memory, or only counts its bytes.
std::size_t carve(const LimbPlan& plan, void* memory, bool write) {
    Carver carver{static_cast<unsigned char*>(memory)};
    Room* room = carver.many<Room>(1);
    Plate* plate = carver.many<Plate>(plan.plates);
    Rod* rod = carver.many<Rod>(plan.rods);
    if (write) room->plate = plate, room->rod = rod;
    for (int i = 0; i < plan.rods; ++i) {
        const int elements = plan.rod[i].elements;
        Frame* node = carver.many<Frame>(elements + 1);
        Pair* move = carver.many<Pair>(elements + 1);
        Piece* piece = carver.many<Piece>(elements);
        Knot* knot = carver.many<Knot>(elements - 1);
        Pair* interior = carver.many<Pair>(elements - 1);
        if (!write) continue;
        rod[i].node = node, rod[i].move = move, rod[i].piece = piece, rod[i].knot = knot, rod[i].interior = interior;
    }
    return carver.used;
}

std::size_t bytes(const LimbPlan& plan) {
    static_assert(alignof(Room) <= 64 && sizeof(Room) % alignof(Room) == 0);
    return carve(plan, nullptr, false);
}

Room& room_in(void* memory) { return *static_cast<Room*>(memory); }

/// Puts the ends of every rod where the plates say.
void attach(const LimbPlan& plan, Room& room) {
    for (int i = 0; i < plan.rods; ++i) {
        const LimbRod& rod = plan.rod[i];
        Rod& r = room.rod[i];
        const Frame& end = room.plate[rod.plate].pose;
        if (rod.plate > 0) {
            const Frame& base = room.plate[rod.plate - 1].pose;
            r.node[0] = seen_from_base(base, rod.base);
            r.base_arm = r.node[0].position - base.position;
        }
        r.node[rod.elements] = seen_from_base(end, rod.end);
        r.end_arm = r.node[rod.elements].position - end.position;
    }
}

void open(const LimbPlan& plan, void* memory) {
    carve(plan, memory, true);
    Room& room = room_in(memory);
    room.running = room.converged = room.failed = room.stable = room.asked_again = Pack(0.0);
    room.iterations = room.residual = room.error = Pack(0.0);
    room.neutral = room.moment_unit = room.force_unit = Pack(1.0);
    // Lanes that nobody fills are idle, on numbers that do no harm.
    const double upright[12] = {0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0};
    for (int j = 0; j < plan.plates; ++j) room.plate[j].pose = fixed(upright);
    for (int i = 0; i < plan.rods; ++i) {
        Rod& rod = room.rod[i];
        rod.k.degree = 0;
        rod.k.shear = rod.k.bending = rod.k.torsion = Pack(1.0);
        rod.k.coupling = rod.k.rest_twist = rod.k.centre = rod.k.per_range = Pack(0.0);
        rod.k.half_range = Pack(1e300);
        for (Pack& c : rod.k.coefficient) c = Pack(0.0);
        rod.length = rod.rest_length = Pack(1.0);
        rod.load = {nothing_at_all().first, nothing_at_all().first};
        for (int e = 0; e <= plan.rod[i].elements; ++e) rod.node[e] = fixed(upright);
        for (int e = 0; e < plan.rod[i].elements; ++e) rod.piece[e].wrench = nothing_at_all();
        rod.node[0] = fixed(plan.rod[i].base);
        rod.base_arm = rod.node[0].position;
    }
    attach(plan, room);
}

void set(V& v, int lane, const double* x) { v.x.set(lane, x[0]), v.y.set(lane, x[1]), v.z.set(lane, x[2]); }
void set(Frame& f, int lane, const double* x) {
    set(f.position, lane, x);
    for (int c = 0; c < 3; ++c) set(f.axis[c], lane, x + 3 + 3 * c);
}
void get(const V& v, int lane, double* x) { x[0] = v.x.get(lane), x[1] = v.y.get(lane), x[2] = v.z.get(lane); }
void get(const Frame& f, int lane, double* x) {
    get(f.position, lane, x);
    for (int c = 0; c < 3; ++c) get(f.axis[c], lane, x + 3 + 3 * c);
}

/// The state's parts in their order, each with its numbers.
template <class OnFrame, class OnPair>
void for_state(const LimbPlan& plan, Room& room, OnFrame&& frame, OnPair&& pair) {
    for (int j = 0; j < plan.plates; ++j) frame(room.plate[j].pose);
    for (int i = 0; i < plan.rods; ++i) {
        for (int e = 1; e < plan.rod[i].elements; ++e) frame(room.rod[i].node[e]);
        for (int e = 0; e < plan.rod[i].elements; ++e) pair(room.rod[i].piece[e].wrench);
    }
}

void fill(const LimbPlan& plan, void* memory, int lane, const LimbStart& start) {
    Room& room = room_in(memory);
    double moment = 0.0, force = 0.0;
    for (int i = 0; i < plan.rods; ++i) {
        Rod& rod = room.rod[i];
        const Section& section = *start.section[i];
        if (section.axial_law.degree > rod.k.degree) rod.k.degree = section.axial_law.degree;
        rod.k.put(lane, section);
        const double l = start.rest_length[i];
        rod.rest_length.set(lane, l), rod.length.set(lane, l / plan.rod[i].elements);
        set(rod.load.force, lane, start.load + 6 * i), set(rod.load.moment, lane, start.load + 6 * i + 3);
        if (section.bending / l > moment) moment = section.bending / l;
        if (section.bending / (l * l) > force) force = section.bending / (l * l);
    }
    const double* x = start.state;
    for_state(
        plan, room, [&](Frame& f) { set(f, lane, x), x += 12; },
        [&](Pair& p) { set(p.first, lane, x), set(p.second, lane, x + 3), x += 6; });
    attach(plan, room);
    room.moment_unit.set(lane, moment), room.force_unit.set(lane, force);
    room.neutral.set(lane, start.neutral);
    room.running.set(lane, 1.0), room.converged.set(lane, 0.0), room.failed.set(lane, 0.0), room.stable.set(lane, 0.0);
    room.asked_again.set(lane, 0.0), room.iterations.set(lane, 0.0);
}

void take(const LimbPlan& plan, void* memory, int lane, double* state) {
    Room& room = room_in(memory);
    for_state(
        plan, room, [&](Frame& f) { get(f, lane, state), state += 12; },
        [&](Pair& p) { get(p.first, lane, state), get(p.second, lane, state + 3), state += 6; });
    room.running.set(lane, 0.0), room.converged.set(lane, 0.0), room.failed.set(lane, 0.0);
}

LaneReport report(const LimbPlan&, const void* memory, int lane) {
    const Room& room = *static_cast<const Room*>(memory);
    const LaneStatus status = room.converged.get(lane) > 0.0 ? LaneStatus::converged
                              : room.failed.get(lane) > 0.0  ? LaneStatus::failed
                              : room.running.get(lane) > 0.0 ? LaneStatus::running
                                                             : LaneStatus::empty;
    return {status, room.stable.get(lane) > 0.0, static_cast<int>(room.iterations.get(lane)), room.residual.get(lane),
            room.error.get(lane)};
}

// --- Balance of the plates -------------------------------------------------------------------------------------

Pair carried(const Pair& force, const V& arm) { return {force.first, force.second + cross(arm, force.first)}; }

/// Derivative of (dtheta x arm) x force to dtheta, added to the block's turns.
void add_turning_arm(const V& arm, const V& force, double sign, M6& block) {
    const Pack s(sign), along = s * dot(arm, force);
    const Pack a[3] = {arm.x, arm.y, arm.z}, f[3] = {force.x, force.y, force.z};
    for (int r = 0; r < 3; ++r)
        for (int c = 0; c < 3; ++c) {
            Pack x = s * a[r] * f[c];
            if (r == c) x = x - along;
            block(3 + r, 3 + c) = block(3 + r, 3 + c) + x;
        }
}

/// Adds L^T K L': forces of K act at `row_arm` from a plate's origin, and its moves are those at `column_arm` of one.
void add_carried(const M6& k, const V& row_arm, const V& column_arm, M6& to) {
    const auto add = [&](int c, const Pair& force) {
        Pack on_plate[6];
        carried(force, row_arm).write(on_plate);
        for (int r = 0; r < 6; ++r) to(r, c) = to(r, c) + on_plate[r];
    };
    Pair column[6];
    for (int c = 0; c < 6; ++c) column[c] = Pair::of(k.m[c]);
    for (int c = 0; c < 3; ++c) add(c, column[c]);
    const Pack zero(0.0);
    const V unit_cross_arm[3] = {
        {zero, -column_arm.z, column_arm.y}, {column_arm.z, zero, -column_arm.x}, {-column_arm.y, column_arm.x, zero}};
    for (int c = 0; c < 3; ++c) {
        const V& u = unit_cross_arm[c];
        const auto share = [&](const V& x, const V& y, const V& z, const V& own) {
            return own + u.x * x + u.y * y + u.z * z;
        };
        add(3 + c, {share(column[0].first, column[1].first, column[2].first, column[3 + c].first),
                    share(column[0].second, column[1].second, column[2].second, column[3 + c].second)});
    }
}

/// Loads on a plate, and their derivative to its move where a block is given, which loses it.
Pair plate_load(const LimbPlan& plan, const LimbPlate& plate, const Frame& pose, M6* block) {
    Pair load{constant(plate.wrench), constant(plate.wrench + 3)};
    if (plan.following) {
        load = {pose.turned(load.first), pose.turned(load.second)};
        if (block) {
            const auto less_hat = [&](const V& v, int row) {  // of -hat(v), taken away
                M6& b = *block;
                b(row + 1, 3) = b(row + 1, 3) + v.z, b(row + 2, 3) = b(row + 2, 3) - v.y;
                b(row, 4) = b(row, 4) - v.z, b(row + 2, 4) = b(row + 2, 4) + v.x;
                b(row, 5) = b(row, 5) + v.y, b(row + 1, 5) = b(row + 1, 5) - v.x;
            };
            less_hat(load.first, 0), less_hat(load.second, 3);
        }
    }
    const V weight = constant(plate.weight), arm = Pack(plate.weight_arm) * pose.axis[2];
    load.first += weight, load.second += cross(arm, weight);
    if (block) add_turning_arm(arm, weight, -1.0, *block);
    return load;
}

void linearise_rod(const LimbPlan& plan, const LimbRod& rod, Rod& r) {
    for (int e = 0; e < rod.elements; ++e) {
        Piece& piece = r.piece[e];
        Pieces p;
        p.k = r.k, p.load = r.load, p.length = r.length;
        p.n = piece.wrench.first, p.y.moment = piece.wrench.second;
        p.y.position = nothing_at_all().first;
        p.y.tangent = r.node[e].axis[2], p.y.director = r.node[e].axis[0];
        const Frame& second = r.node[e + 1];
        linearise_pieces(p, r.node[e].position, second.position, second.axis, rod.steps, plan.loads, piece.linear);
    }
}

/// Stiffness blocks of a piece: [by_first, -inverse; end_by_first, by_second].
void condense_rod(const LimbRod& rod, Rod& r) {
    const Linearised& first = r.piece[0].linear;
    M6(&k)[2][2] = r.stiffness;
    k[0][0] = first.by_first, k[1][0] = first.end_by_first, k[1][1] = first.by_second;
    for (int c = 0; c < 6; ++c)
        for (int row = 0; row < 6; ++row) k[0][1](row, c) = -first.inverse(row, c);
    r.force[0] = Pair::of(first.force), r.force[1] = Pair::of(first.force + 6);
    for (int e = 1; e < rod.elements; ++e) {
        const Linearised& next = r.piece[e].linear;
        Knot& knot = r.knot[e - 1];
        M6 pivot = k[1][1];
        for (int c = 0; c < 6; ++c)
            for (int row = 0; row < 6; ++row) pivot(row, c) = pivot(row, c) + next.by_first(row, c);
        invert_block(pivot, knot.inverse);
        knot.first_row = k[0][1];
        knot.right = times(knot.inverse, r.force[1] + Pair::of(next.force));
        r.force[0] = r.force[0] - times(knot.first_row, knot.right);
        r.force[1] = Pair::of(next.force + 6) - times(next.end_by_first, knot.right);
        set_zero(knot.by_first), set_zero(knot.by_next);
        add_product(knot.inverse, k[1][0], 1.0, knot.by_first);
        add_product(knot.inverse, next.inverse, -1.0, knot.by_next);
        add_product(knot.first_row, knot.by_first, -1.0, k[0][0]);
        set_zero(k[0][1]), set_zero(k[1][0]);
        add_product(knot.first_row, knot.by_next, -1.0, k[0][1]);
        add_product(next.end_by_first, knot.by_first, -1.0, k[1][0]);
        k[1][1] = next.by_second;
        add_product(next.end_by_first, knot.by_next, -1.0, k[1][1]);
    }
}

void linearise_limbs(const LimbPlan& plan, Room& room) {
    for (int j = 0; j < plan.plates; ++j) {
        Plate& plate = room.plate[j];
        set_zero(plate.diagonal), set_zero(plate.lower), set_zero(plate.upper);
        plate.residual = -plate_load(plan, plan.plate[j], plate.pose, &plate.diagonal);
    }
    for (int i = 0; i < plan.rods; ++i) {
        const LimbRod& rod = plan.rod[i];
        Rod& r = room.rod[i];
        linearise_rod(plan, rod, r);
        condense_rod(rod, r);
        Plate& end = room.plate[rod.plate];
        add_carried(r.stiffness[1][1], r.end_arm, r.end_arm, end.diagonal);
        add_turning_arm(r.end_arm, r.force[1].first, 1.0, end.diagonal);
        end.residual = end.residual + carried(r.force[1], r.end_arm);
        if (rod.plate == 0) continue;
        Plate& base = room.plate[rod.plate - 1];
        add_carried(r.stiffness[0][0], r.base_arm, r.base_arm, base.diagonal);
        add_carried(r.stiffness[0][1], r.base_arm, r.end_arm, base.upper);
        add_carried(r.stiffness[1][0], r.end_arm, r.base_arm, end.lower);
        add_turning_arm(r.base_arm, r.force[0].first, 1.0, base.diagonal);
        base.residual = base.residual + carried(r.force[0], r.base_arm);
    }
    for (int j = 0; j < plan.plates; ++j) {
        M6 pivot = room.plate[j].diagonal;
        if (j > 0) {
            M6 product;
            set_zero(product);
            add_product(room.plate[j - 1].inverse, room.plate[j - 1].upper, 1.0, product);
            add_product(room.plate[j].lower, product, -1.0, pivot);
        }
        invert_block(pivot, room.plate[j].inverse);
    }
}

/// Moves of the plates that meet the residuals, and of the ends of the rods.
void balance(const LimbPlan& plan, Room& room) {
    for (int j = 0; j < plan.plates; ++j) {
        Pair right = -room.plate[j].residual;
        if (j > 0) right = right - times(room.plate[j].lower, times(room.plate[j - 1].inverse, room.plate[j - 1].move));
        room.plate[j].move = right;
    }
    for (int j = plan.plates - 1; j >= 0; --j) {
        Pair right = room.plate[j].move;
        if (j + 1 < plan.plates) right = right - times(room.plate[j].upper, room.plate[j + 1].move);
        room.plate[j].move = times(room.plate[j].inverse, right);
    }
    const auto at = [](const Pair& move, const V& arm) {
        return Pair{move.first + cross(move.second, arm), move.second};
    };
    for (int i = 0; i < plan.rods; ++i) {
        const LimbRod& rod = plan.rod[i];
        Rod& r = room.rod[i];
        r.move[0] = rod.plate > 0 ? at(room.plate[rod.plate - 1].move, r.base_arm) : nothing_at_all();
        r.move[rod.elements] = at(room.plate[rod.plate].move, r.end_arm);
    }
}

/// Moves of the interior nodes, given `right` of each, and of the wrenches, given the gap of each piece.
template <class Right, class Gap>
void recover(const LimbPlan& plan, Room& room, Right&& right_of, Gap&& gap_of) {
    for (int i = 0; i < plan.rods; ++i) {
        Rod& r = room.rod[i];
        const int elements = plan.rod[i].elements;
        for (int e = elements - 1; e >= 1; --e) {
            const Knot& knot = r.knot[e - 1];
            r.move[e] = -(times(knot.by_first, r.move[0]) + times(knot.by_next, r.move[e + 1]) + right_of(r, e));
        }
        for (int e = 0; e < elements; ++e) {
            Piece& piece = r.piece[e];
            const Pair &first = r.move[e], &second = r.move[e + 1];
            // A x1, where A's first three columns are those of the identity.
            const V& turn = first.second;
            const Variation<Pack>* a = piece.linear.by_turn;
            const Pair with{first.first + turn.x * a[0].position + turn.y * a[1].position + turn.z * a[2].position,
                            turn.x * a[0].rotation + turn.y * a[1].rotation + turn.z * a[2].rotation};
            piece.wrench_move = times(piece.linear.inverse, second - with - gap_of(piece));
        }
    }
}

void propose(const LimbPlan& plan, Room& room) {
    balance(plan, room);
    recover(
        plan, room, [](const Rod& r, int e) -> const Pair& { return r.knot[e - 1].right; },
        [](const Piece& piece) { return Pair::of(piece.linear.gap); });
}

/// Moves that meet the residual of an integration of `finer` times the steps, by the stiffness at hand.
void propose_again(const LimbPlan& plan, Room& room, int finer) {
    for (int j = 0; j < plan.plates; ++j)
        room.plate[j].residual = -plate_load(plan, plan.plate[j], room.plate[j].pose, nullptr);
    for (int i = 0; i < plan.rods; ++i) {
        const LimbRod& rod = plan.rod[i];
        Rod& r = room.rod[i];
        for (int e = 0; e < rod.elements; ++e) {
            Piece& piece = r.piece[e];
            Pieces p;
            p.k = r.k, p.load = r.load, p.length = r.length;
            p.n = piece.wrench.first, p.y.moment = piece.wrench.second;
            p.y.position = nothing_at_all().first;
            p.y.tangent = r.node[e].axis[2], p.y.director = r.node[e].axis[0];
            advance(p, finer * rod.steps, nullptr, 0);
            const Frame& second = r.node[e + 1];
            const V axes[3] = {p.y.director, cross(p.y.tangent, p.y.director), p.y.tangent};
            piece.gap = {p.y.position + (r.node[e].position - second.position), turn_between(axes, second.axis)};
            const Pair change = -times(piece.linear.inverse, piece.gap);
            piece.start_force = -(piece.wrench + change);
            V moment = p.y.moment;
            Pack by[6];
            change.write(by);
            for (int c = 0; c < 6; ++c) {
                const Pack* m = piece.linear.moment_by_wrench[c];
                moment += V{by[c] * m[0], by[c] * m[1], by[c] * m[2]};
            }
            piece.end_force = {p.n + change.first, moment};
        }
        Pair base = r.piece[0].start_force, end = r.piece[0].end_force;
        for (int e = 1; e < rod.elements; ++e) {
            const Knot& knot = r.knot[e - 1];
            r.interior[e - 1] = times(knot.inverse, end + r.piece[e].start_force);
            base = base - times(knot.first_row, r.interior[e - 1]);
            end = r.piece[e].end_force - times(r.piece[e].linear.end_by_first, r.interior[e - 1]);
        }
        Plate& plate = room.plate[rod.plate];
        plate.residual = plate.residual + carried(end, r.end_arm);
        if (rod.plate == 0) continue;
        Plate& before = room.plate[rod.plate - 1];
        before.residual = before.residual + carried(base, r.base_arm);
    }
    balance(plan, room);
    recover(
        plan, room, [](const Rod& r, int e) -> const Pair& { return r.interior[e - 1]; },
        [](const Piece& piece) -> const Pair& { return piece.gap; });
}

// --- Measures --------------------------------------------------------------------------------------------------

/// Grows the largest; a NaN shows in `trace`, which is zero as long as all is finite.
struct Largest {
    Pack square{0.0}, trace{0.0};
    SOFTLIMB_ALWAYS_INLINE void grow(const V& v, const Pack& per_unit_square) {
        const Pack x = per_unit_square * dot(v, v);
        square = select(square < x, x, square);
        trace = trace + Pack(0.0) * x;
    }
    /// Infinite where something was not finite.
    Pack value() const {
        const Pack finite = select(absolute(trace) < Pack(1.0), Pack(1.0), Pack(0.0));
        return select(Pack(0.5) < finite, sqrt(square), Pack(1e300));
    }
};

template <class Use>
void for_pieces(const LimbPlan& plan, Room& room, Use&& use) {
    for (int i = 0; i < plan.rods; ++i)
        for (int e = 0; e < plan.rod[i].elements; ++e) use(room.rod[i], room.rod[i].piece[e], e);
}

/// Largest force and moment inside the rods, or EI/l^2 and EI/l where those are larger; and the largest force alone.
struct Scales {
    Pack force, moment, largest_force;
};

Scales scales_of(const LimbPlan& plan, Room& room) {
    Largest force, moment;
    for_pieces(plan, room, [&](const Rod&, const Piece& piece, int) {
        force.grow(piece.wrench.first, Pack(1.0)), moment.grow(piece.wrench.second, Pack(1.0));
    });
    const Pack f = force.value(), m = moment.value();
    return {select(f < room.force_unit, room.force_unit, f), select(m < room.moment_unit, room.moment_unit, m), f};
}

Pack inverse_square(const Pack& x) { return Pack(1.0) / (x * x); }

/// Largest move; relative change of the wrenches; and by how much the stiffness of the plates may change with them. As
/// in limb::Equilibrium.
struct StepSize {
    Pack move, wrench, stiffness;
    Pack value() const {
        const Pack w = Pack(share_of_tip) * wrench;
        return select(move < w, w, move);
    }
};

StepSize size_of_step(const LimbPlan& plan, Room& room, const Scales& scales) {
    Largest move, wrench;
    const Pack per_length(1.0 / (plan.length * plan.length)), one(1.0);
    for (int j = 0; j < plan.plates; ++j)
        move.grow(room.plate[j].move.first, per_length), move.grow(room.plate[j].move.second, one);
    for (int i = 0; i < plan.rods; ++i)
        for (int e = 0; e <= plan.rod[i].elements; ++e)
            move.grow(room.rod[i].move[e].first, per_length), move.grow(room.rod[i].move[e].second, one);
    const Pack per_force = inverse_square(scales.force), per_moment = inverse_square(scales.moment);
    Pack largest(0.0);
    for_pieces(plan, room, [&](const Rod& r, const Piece& piece, int) {
        wrench.grow(piece.wrench_move.first, per_force), wrench.grow(piece.wrench_move.second, per_moment);
        const Pack x = sqrt(dot(piece.wrench_move.first, piece.wrench_move.first)) * r.rest_length +
                       sqrt(dot(piece.wrench_move.second, piece.wrench_move.second));
        largest = select(largest < x, x, largest);
    });
    const Pack moved = move.value();
    return {moved, wrench.value(), Pack(0.3 * plan.length) * moved * scales.force + largest};
}

/// By what the step is shortened so that nothing turns or is displaced by more than half a radian or half a rod.
Pack bounded_factor(const LimbPlan& plan, Room& room) {
    Largest turn;
    const Pack one(1.0);
    Pack length(0.0);
    for (int i = 0; i < plan.rods; ++i) length = length + room.rod[i].rest_length;
    const Pack per_length = inverse_square(Pack(0.5 / plan.rods) * length);
    for (int j = 0; j < plan.plates; ++j) turn.grow(room.plate[j].move.second, one);
    for_pieces(plan, room, [&](const Rod& r, const Piece&, int e) {
        const Pair &first = r.move[e], &second = r.move[e + 1];
        const V carried = first.first + cross(first.second, r.node[e + 1].position - r.node[e].position);
        turn.grow(second.first - carried, per_length), turn.grow(second.second, one);
    });
    constexpr double largest = 0.5;
    const Pack t = turn.value();
    return select(Pack(largest) < t, Pack(largest) / t, one);
}

Pack relative_residual(const LimbPlan& plan, Room& room, const Scales& scales) {
    Largest residual;
    const Pack per_force = inverse_square(scales.force), per_moment = inverse_square(scales.moment);
    const Pack per_length(1.0 / (plan.length * plan.length)), one(1.0);
    for (int j = 0; j < plan.plates; ++j) {
        residual.grow(room.plate[j].residual.first, per_force);
        residual.grow(room.plate[j].residual.second, per_moment);
    }
    for_pieces(plan, room, [&](const Rod&, const Piece& piece, int) {
        const Pair gap = Pair::of(piece.linear.gap);
        residual.grow(gap.first, per_length), residual.grow(gap.second, one);
    });
    return residual.value();
}

void apply(const LimbPlan& plan, Room& room, const Pack& factor, Mask where) {
    const auto part = [&](const Pair& p) { return Pair{factor * p.first, factor * p.second}; };
    for (int j = 0; j < plan.plates; ++j) move(room.plate[j].pose, part(room.plate[j].move), where);
    for (int i = 0; i < plan.rods; ++i) {
        Rod& r = room.rod[i];
        for (int e = 0; e < plan.rod[i].elements; ++e) {
            if (e > 0) move(r.node[e], part(r.move[e]), where);
            Pair& wrench = r.piece[e].wrench;
            wrench = chosen(where, wrench + part(r.piece[e].wrench_move), wrench);
        }
    }
    attach(plan, room);
}

/// Takes `margin` [N m] off the diagonal: off that of translations by the square of a length.
void lower_diagonal(M6& a, const Pack& margin, const Pack& per_area) {
    for (int c = 0; c < 3; ++c) a(c, c) = a(c, c) - margin * per_area;
    for (int c = 3; c < 6; ++c) a(c, c) = a(c, c) - margin;
}

/// a + b^T halved, a coupling of the symmetric part.
void mean_coupling(const M6& a, const M6& b, M6& to) {
    for (int c = 0; c < 6; ++c)
        for (int r = 0; r < 6; ++r) to(r, c) = Pack(0.5) * (a(r, c) + b(c, r));
}

/// Ones where the symmetric part of the stiffness, of the nodes between held plates and of the plates, is positive
/// definite by more than a margin: see limb::Equilibrium::judge.
Pack surely_stable(const LimbPlan& plan, Room& room, const Pack& changed) {
    const Pack margin = select(changed < room.neutral, room.neutral, changed);
    Pack stable(1.0);
    M6 lower, coupling, pivot;
    for (int i = 0; i < plan.rods; ++i) {
        const Rod& r = room.rod[i];
        const Pack per_area = inverse_square(r.length);
        for (int e = 1; e < plan.rod[i].elements; ++e) {
            const Linearised &before = r.piece[e - 1].linear, &after = r.piece[e].linear;
            for (int c = 0; c < 6; ++c)
                for (int row = 0; row < 6; ++row) pivot(row, c) = before.by_second(row, c) + after.by_first(row, c);
            lower_diagonal(pivot, margin, per_area);
            if (e > 1) less_square(pivot, coupling);
            stable = stable * factor_symmetric(pivot, lower);
            if (e + 1 == plan.rod[i].elements) break;
            for (int c = 0; c < 6; ++c)
                for (int row = 0; row < 6; ++row)
                    coupling(row, c) = Pack(0.5) * (after.end_by_first(c, row) - after.inverse(row, c));
            substitute(lower, coupling);
        }
    }
    const Pack per_area(1.0 / (plan.length * plan.length));
    for (int j = 0; j < plan.plates; ++j) {
        pivot = room.plate[j].diagonal;
        lower_diagonal(pivot, margin, per_area);
        if (j > 0) less_square(pivot, coupling);
        stable = stable * factor_symmetric(pivot, lower);
        if (j + 1 == plan.plates) break;
        mean_coupling(room.plate[j].upper, room.plate[j + 1].lower, coupling);
        substitute(lower, coupling);
    }
    return stable;
}

bool any(const Pack& p) {
    for (int lane = 0; lane < W; ++lane)
        if (p.get(lane) > 0.0) return true;
    return false;
}

SOFTLIMB_ALWAYS_INLINE Pack yes(Mask m) { return select(m, Pack(1.0), Pack(0.0)); }
SOFTLIMB_ALWAYS_INLINE Mask is(const Pack& yes_or_no) { return Pack(0.5) < yes_or_no; }
SOFTLIMB_ALWAYS_INLINE Pack no(const Pack& yes_or_no) { return Pack(1.0) - yes_or_no; }

void round(const LimbPlan& plan, void* memory) {
    Room& room = room_in(memory);
    const Pack one(1.0), tolerance(plan.tolerance);
    linearise_limbs(plan, room);
    Scales scales = scales_of(plan, room);
    const Pack residual = relative_residual(plan, room, scales);
    room.residual = select(is(room.running), residual, room.residual);
    propose(plan, room);
    const StepSize step = size_of_step(plan, room, scales);
    const Pack size = step.value(), factor = bounded_factor(plan, room);
    const Pack finite = yes(size < Pack(1e100)) * yes(residual < Pack(1e100));
    room.failed = select(is(room.running * no(finite)), one, room.failed);
    room.running = room.running * finite;
    apply(plan, room, factor, is(room.running));
    room.iterations = room.iterations + room.running;

    // Steps with the stiffness at hand shrink what is left by about what has been moved since, as in limb::Equilibrium.
    // Some lane wants them in nearly every round, so they cost the others nothing: they are tried early.
    const Pack arm = Pack(0.05 * plan.length) * scales.largest_force / scales.moment;
    const Pack leverage = select(arm < one, one, arm);
    Pack shrink = Pack(4.0) * size * leverage, changed = step.stiffness, last = size;
    const Pack whole = yes(one < factor + Pack(1e-12));
    const Pack close = room.running * whole * yes(residual < one) * yes(size * leverage < Pack(0.5));
    // A correction of the lanes where it is smaller than a bound; those are left in `lanes`.
    const auto correct = [&](Pack& lanes, int finer, const Pack& bound) {
        propose_again(plan, room, finer);
        scales = scales_of(plan, room);
        const StepSize next = size_of_step(plan, room, scales);
        lanes = lanes * yes(next.value() < bound);
        apply(plan, room, one, is(lanes));
        changed = changed + select(is(lanes), next.stiffness, Pack(0.0));
        return next;
    };
    Pack left = shrink * last;
    Pack coarse = close * yes(Pack(0.5) * tolerance < left);
    for (int pass = 0; pass < 2 && any(coarse); ++pass) {
        const Pack error = correct(coarse, 1, Pack(0.5) * last).value(), ratio = error / last;
        shrink = select(is(coarse * yes(shrink < ratio)), ratio, shrink);
        last = select(is(coarse), error, last);
        left = select(is(coarse), shrink * last, left);
        coarse = coarse * yes(Pack(0.5) * tolerance < left);
    }
    // Now with half the step. What that corrects is what the whole step errs by; the order being eight, half the step
    // errs by a 256th of it. A 32nd is believed.
    constexpr double finer = 32.0;
    Pack fine = close * yes(left < Pack(0.5) * tolerance);
    if (any(fine)) {
        const StepSize next = correct(fine, 2, one);
        const Pack error = next.value(), wrong = Pack(1.0 / finer) * error;
        left = shrink * error;
        const Pack estimate = select(left < wrong, wrong, left);
        const Pack met = fine * yes(estimate < tolerance) * yes(shrink * next.wrench < Pack(5.0) * tolerance);
        // Where the stiffness has changed too much since it was taken to tell, it is taken once more.
        const Pack stable = surely_stable(plan, room, Pack(share_of_change) * changed);
        const Pack done = met * select(is(stable), one, room.asked_again);
        room.stable = select(is(done), stable, room.stable);
        room.asked_again = select(is(met), one, room.asked_again);
        room.error = select(is(done), estimate, room.error);
        room.converged = select(is(done), one, room.converged);
        room.running = room.running * no(done);
    }
    const Pack late = room.running * yes(Pack(plan.most_iterations - 0.5) < room.iterations);
    room.failed = select(is(late), one, room.failed);
    room.running = room.running * no(late);
}

constexpr LimbFunctions functions{&bytes, &open, &fill, &round, &report, &take};

}  // namespace limbs
