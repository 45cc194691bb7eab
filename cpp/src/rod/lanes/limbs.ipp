// Limbs side by side, a limb a lane: their room, their balance and its linearisation; included by pieces.ipp, in its
// namespace. The same equations as limb::Equilibrium, which says where they come from.

namespace limbs {

#include "blocks.ipp"

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
    Material material;  // of its pieces
    Pack rest_length;
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
        rod.material.k.degree = 0;
        rod.material.k.unit = rod.material.k.shear = rod.material.k.bending = rod.material.k.torsion = Pack(1.0);
        rod.material.k.coupling = rod.material.k.rest_twist = rod.material.k.centre = rod.material.k.per_range =
            Pack(0.0);
        rod.material.k.half_range = Pack(1e300);
        for (Pack& c : rod.material.k.coefficient) c = Pack(0.0);
        rod.material.length = rod.rest_length = Pack(1.0);
        rod.material.load = {no_pair().first, no_pair().first};
        for (int e = 0; e <= plan.rod[i].elements; ++e) rod.node[e] = fixed(upright);
        for (int e = 0; e < plan.rod[i].elements; ++e) rod.piece[e].wrench = no_pair();
        rod.node[0] = fixed(plan.rod[i].base);
        rod.base_arm = rod.node[0].position;
    }
    attach(plan, room);
}

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
        if (section.axial_law.degree > rod.material.k.degree) rod.material.k.degree = section.axial_law.degree;
        rod.material.k.put(lane, section);
        const double l = start.rest_length[i];
        rod.rest_length.set(lane, l), rod.material.length.set(lane, l / plan.rod[i].elements);
        set(rod.material.load.force, lane, start.load + 6 * i),
            set(rod.material.load.moment, lane, start.load + 6 * i + 3);
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
    room.asked_again.set(lane, start.asked_again ? 1.0 : 0.0), room.iterations.set(lane, start.iterations);
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
    return {status,
            room.stable.get(lane) > 0.0,
            static_cast<int>(room.iterations.get(lane)),
            room.residual.get(lane),
            room.error.get(lane),
            room.asked_again.get(lane) > 0.0};
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

/// Piece e of the rod in all lanes, at its base; positions are relative to that.
Pieces at_base(const Rod& r, int e) {
    Pieces p;
    p.n = r.piece[e].wrench.first, p.y.moment = r.piece[e].wrench.second;
    p.y.position = no_pair().first;
    p.y.tangent = r.node[e].axis[2], p.y.director = r.node[e].axis[0];
    return p;
}

void linearise_rod(const LimbPlan& plan, const LimbRod& rod, Rod& r) {
    const StepOf over(r.material, rod.steps);
    for (int e = 0; e < rod.elements; ++e) {
        Pieces p = at_base(r, e);
        const Frame& second = r.node[e + 1];
        linearise_pieces(p, r.material.load.force, over, rod.steps, r.node[e].position, second.position, second.axis,
                         plan.loads, r.piece[e].linear);
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
        r.move[0] = rod.plate > 0 ? at(room.plate[rod.plate - 1].move, r.base_arm) : no_pair();
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
        const StepOf over(r.material, finer * rod.steps);
        for (int e = 0; e < rod.elements; ++e) {
            Piece& piece = r.piece[e];
            Pieces p = at_base(r, e);
            advance(p, over, finer * rod.steps);
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

#include "rounds.ipp"

constexpr LimbFunctions functions{&bytes, &open, &fill, &round, &report, &take};

}  // namespace limbs
