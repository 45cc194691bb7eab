// Geodesic elements side by side; included by pieces.ipp, in its namespace.

void geodesics_pack(const Geodesic* elements, const GeodesicEnd* out, int count) {
    GeodesicData<Pack> d;
    for (int lane = 0; lane < W; ++lane) {
        const Geodesic& e = elements[lane < count ? lane : count - 1];
        const auto put = [lane](V& v, const double* x)
                             SOFTLIMB_LAMBDA_INLINE { v.x.set(lane, x[0]), v.y.set(lane, x[1]), v.z.set(lane, x[2]); };
        put(d.rho, e.twist), put(d.phi, e.twist + 3);
        d.beta.set(lane, e.beta[0]), d.beta_slope.set(lane, e.beta[1]), d.beta_curvature.set(lane, e.beta[2]);
        for (int c = 0; c < 3; ++c) {
            put(d.first.column[c], e.first_rotation + 3 * c);
            put(d.second.column[c], e.second_rotation + 3 * c);
        }
        d.stiffness.shear.set(lane, e.shear), d.stiffness.axial.set(lane, e.axial);
        d.stiffness.bending.set(lane, e.bending), d.stiffness.torsion.set(lane, e.torsion);
        d.stiffness.coupling.set(lane, e.coupling);
        d.length.set(lane, e.length), d.rest_twist.set(lane, e.rest_twist);
        put(d.half_force, e.half_force), put(d.half_moment, e.half_moment);
    }
    const GeodesicResult<Pack> r = geodesic(d);

    // By lanes in memory first: from there each element's numbers are read one by one, which costs less than to take
    // them out of the registers.
    Pack force[12], stiffness[144];
    const auto keep = [](Pack* to, const V& v) SOFTLIMB_LAMBDA_INLINE { to[0] = v.x, to[1] = v.y, to[2] = v.z; };
    for (int i = 0; i < 2; ++i)
        for (int u = 0; u < 2; ++u) {
            const int row = 6 * i + 3 * u;
            keep(force + row, r.force[i][u]);
            for (int j = 0; j < 2; ++j)
                for (int v = 0; v < 2; ++v)
                    for (int c = 0; c < 3; ++c)
                        keep(stiffness + 12 * (6 * j + 3 * v + c) + row, r.stiffness[i][j].at[u][v].column[c]);
        }
    for (int lane = 0; lane < count; ++lane) {
        const double* from = reinterpret_cast<const double*>(force) + lane;
        for (int k = 0; k < 12; ++k) out[lane].force[k] = from[W * k];
        from = reinterpret_cast<const double*>(stiffness) + lane;
        for (int k = 0; k < 144; ++k) out[lane].stiffness[k] = from[W * k];
    }
}

void geodesics(const Geodesic* elements, const GeodesicEnd* out, int count) {
    for (int first = 0; first < count; first += W)
        geodesics_pack(elements + first, out + first, count - first < W ? count - first : W);
}
