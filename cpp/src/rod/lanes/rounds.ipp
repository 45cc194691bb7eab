// Measures of a step, counts of modes, and the rounds of limbs side by side; included by limbs.ipp, in its namespace.

// Of the bound on how much the stiffness changes with a step. Over the last step of 1184 random rows of the reference
// limb the eigenvalue nearest to zero changed by a fortieth of the bound at most.
constexpr double share_of_change = 0.15;

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
        const Pack w = Pack(solve::wrench_in_tip) * wrench;
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
    return {moved, wrench.value(), Pack(solve::stiffness_by_move * plan.length) * moved * scales.force + largest};
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
    const Pack t = turn.value(), largest(solve::largest_turn);
    return select(largest < t, largest / t, one);
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
        const Pack per_area = inverse_square(r.material.length);
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

/// The most steps in place of one of the linearisation's.
constexpr int finest = 4;

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
    const Pack arm = Pack(solve::force_arm * plan.length) * scales.largest_force / scales.moment;
    const Pack leverage = select(arm < one, one, arm);
    Pack shrink = Pack(solve::left_by_chord) * size * leverage, changed = step.stiffness, last = size;
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
    // Half a step errs by a 256th of what the whole one does, the order being eight; a 32nd is believed. A correction
    // with finer steps serves where what it leaves meets the tolerance and what it corrects tells of the integration.
    constexpr double believed = 1.0 / 32.0;
    Pack left = shrink * last;
    const auto near = [&] {
        return yes(shrink * left < Pack(0.25) * tolerance) * yes(Pack(2.0 * believed) * left < tolerance);
    };
    Pack coarse = close * no(near());
    for (int pass = 0; pass < plan.corrections && any(coarse); ++pass) {
        const Pack error = correct(coarse, 1, Pack(0.5) * last).value(), ratio = error / last;
        shrink = select(is(coarse * yes(shrink < ratio)), ratio, shrink);
        last = select(is(coarse), error, last);
        left = select(is(coarse), shrink * last, left);
        coarse = coarse * no(near());
    }
    Pack fine = close * near(), met(0.0), found = room.error;
    for (int finer = 2; finer <= finest && any(fine); finer *= 2) {
        const StepSize next = correct(fine, finer, one);
        const Pack error = next.value(), wrong = Pack(believed) * error, two(2.0);
        // Where the correction is more than the tolerance it must be what was promised, and the next one may shrink
        // half as much: the first after a linearisation does so by half of what the others do.
        const Pack loose = yes(Pack(0.5) * tolerance < left), ratio = error / last;
        const Pack kept = loose * yes(two * left < error);
        shrink = select(is(loose), two * select(shrink < ratio, ratio, shrink), shrink);
        left = shrink * error;
        const Pack estimate = select(left < wrong, wrong, left);
        const Pack good =
            fine * no(kept) * yes(estimate < tolerance) * yes(shrink * next.wrench < Pack(5.0) * tolerance);
        found = select(is(good), estimate, found);
        met = met + good;
        fine = fine * no(good) * no(kept) * yes(left < tolerance);  // where the integration is at fault
        last = error;
    }
    if (any(met)) {
        // Where the stiffness has changed too much since it was taken to tell, it is taken once more.
        const Pack stable = surely_stable(plan, room, Pack(share_of_change) * changed);
        const Pack done = met * select(is(stable), one, room.asked_again);
        room.stable = select(is(done), stable, room.stable);
        room.asked_again = select(is(met), one, room.asked_again);
        room.error = select(is(done), found, room.error);
        room.converged = select(is(done), one, room.converged);
        room.running = room.running * no(done);
    }
    const Pack late = room.running * yes(Pack(plan.most_iterations - 0.5) < room.iterations);
    room.failed = select(is(late), one, room.failed);
    room.running = room.running * no(late);
}
