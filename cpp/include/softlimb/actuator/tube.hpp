#pragma once
// A fibre-reinforced tube under pressure: pressure to stretch and back, and the section that it hands to a rod.
// A tube is constant after construction and may be shared between threads. Nothing here depends on what was solved
// before, and no solve allocates memory. Source: cpp/MECHANICS.md, "Actuator" and "Section".
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "softlimb/actuator/equilibrium.hpp"
#include "softlimb/actuator/layer.hpp"
#include "softlimb/actuator/section_values.hpp"
#include "softlimb/actuator/tube_parameter.hpp"
#include "softlimb/actuator/unloaded.hpp"
#include "softlimb/actuator/wall.hpp"
#include "softlimb/section.hpp"
#include "softlimb/solve/status.hpp"

namespace softlimb::actuator {

enum class Ends { free, bonded };  // bonded: twist blocked
enum class TubeModel { thick, paper_reduced };
enum class SectionModel { tangent, nonlinear, paper };
enum class Valve { open, locked };  // constant pressure, constant volume

/// Remarks on an answer that is right as an answer; bits of `TubeState::flags`.
enum TubeFlag : unsigned {
    law_out_of_range = 1u << 0,   // a stretch beyond the data that a material law was fitted to
    locking = 1u << 1,            // two-way fibres smeared over a thick layer hold each other
    slack_fibres = 1u << 2,       // some tension-only fibres carry nothing
    near_ballooning = 1u << 3,    // above nine tenths of the limit pressure
    negative_pressure = 1u << 4,  // outside the range the model is meant for
    unstable = 1u << 5,           // an equilibrium that would not stay under given pressure
    near_law_limit = 1u << 6,  // a Gent law beyond nine tenths of its limit: the integral through the wall loses digits
};

struct TubeOptions {
    bool tension_only = false;
    Ends ends = Ends::free;
    std::optional<double> mass{};  // [kg]; default: silicone density times volume
    double cap_length = 0.0;       // part of the length at each end that a rigid cap keeps at rest [m]
    bool operator==(const TubeOptions&) const = default;
};

/// Equilibrium of a tube.
struct TubeState {
    double stretch = 1.0;              // lz
    double inner_radius = 0.0;         // r_i [m]
    double twist_rate = 0.0;           // per reference length [rad/m]
    double pressure = 0.0;             // [Pa]
    double axial_force = 0.0;          // [N]
    double torque = 0.0;               // applied; with bonded ends the ends' reaction [N m]
    double smallest_eigenvalue = 0.0;  // of S H S, S = diag(1, R_i^2, 1/R_i), over the free unknowns [N]
    double limit_pressure = 0.0;  // where stability is lost under the same force and torque, when that was met [Pa]
    bool stable = false;          // under given pressure
    bool success = false;
    unsigned flags = 0;
    int iterations = 0;
    solve::SolveStatus status = solve::SolveStatus::max_iterations;
    TubeModel model = TubeModel::thick;
    Shape<double> shape;  // scaled unknowns behind the above
};

/// What a rod needs, and its derivative to the pressure, as a SectionSlope has it.
struct SectionAtPressure {
    double rest_length = 0.0;
    Section section;
    double d_rest_length = 0.0;
    Section d_section;
    solve::SolveStatus status = solve::SolveStatus::max_iterations;
};

/// Cauchy stress at a point of the wall [Pa].
struct WallStress {
    double radius = 0.0;            // deformed [m]
    double reference_radius = 0.0;  // [m]
    double radial = 0.0, hoop = 0.0, axial = 0.0, shear = 0.0;
};

/// A fibre family in a state: stretch at the faces of its layer, and mean of k (stretch - 1), the family's tension
/// over the layer's area across the fibres [Pa].
struct FibreState {
    int layer = 0;
    double angle = 0.0, stretch_inside = 1.0, stretch_outside = 1.0, tension = 0.0;
    double taut_fraction = 1.0;
};

class Tube {
public:
    /// Raises std::invalid_argument.
    Tube(double length, std::vector<Layer> layers, const TubeOptions& options = {});

    double length() const { return length_; }
    const std::vector<Layer>& layers() const { return layers_; }
    const TubeOptions& options() const { return options_; }
    double inner_radius() const { return layers_.front().inner; }
    double outer_radius() const { return layers_.back().outer; }
    double mass() const { return mass_; }
    /// Largest pressure of the stable path from rest [Pa], and whether a limit point or instability ends it there.
    double limit_pressure() const { return path_.last().pressure; }
    PathEnd path_end() const { return path_.end(); }
    bool has_limit() const { return path_.end() == PathEnd::limit_point || path_.end() == PathEnd::instability; }
    /// Share of the work of a first small pressure that two-way fibres of one family, smeared over their layer, spend
    /// against each other (those inside pulled, those outside pushed). Fibres in a thin layer spend none.
    double locking_share() const { return locking_share_; }
    const Path& path() const { return path_; }
    const Wall& wall() const { return wall_; }

    TubeState inflate(double pressure, double axial_force = 0.0, double torque = 0.0) const;
    /// Zhang et al. eq. 3 alone: lambda_theta = 1, r = R. For comparison only.
    TubeState paper_reduced(double pressure) const;
    /// The state that encloses a volume [m^3]; continues past the limit point.
    TubeState at_volume(double volume, double axial_force = 0.0, double torque = 0.0) const;
    TubeState at_inner_radius(double radius, double axial_force = 0.0, double torque = 0.0) const;
    /// The state of lowest pressure with a given stretch. Not reachable: the nearest one, success false.
    TubeState at_stretch(double stretch) const;
    /// Other pressures at which the same stretch occurs, ascending; empty when it is unique.
    std::vector<double> pressures_at_stretch(double stretch) const;

    SectionAtPressure section(double pressure, SectionModel model = SectionModel::tangent, Valve valve = Valve::open,
                              bool derivative = false) const;
    /// Derivatives of the section and the rest length to the pressure.
    SectionSlope section_slope(double pressure, SectionModel model, Valve valve) const;
    /// Derivatives of the section and the rest length at a pressure to some of the tube's parameters, into `slopes`,
    /// which has as many. The pressure stays, unless it is the parameter. Source: cpp/MECHANICS.md, "Derivatives".
    void section_slopes(double pressure, SectionModel model, Valve valve, const std::vector<TubeParameter>& parameters,
                        std::vector<SectionSlope>& slopes) const;
    /// The same without derivatives, in place.
    solve::SolveStatus section(double pressure, SectionModel model, Valve valve, Section& section,
                               double& rest_length) const;

    /// Stress at a deformed radius within the wall; at the face between two layers that of the inner one.
    WallStress stress(const TubeState& state, double radius) const;
    WallStress stress_at_reference(const TubeState& state, double reference_radius) const;
    double outer_radius(const TubeState& state) const;
    std::vector<FibreState> fibres(const TubeState& state) const;
    /// What to tell about a state, in words; empty when there is nothing to tell.
    std::vector<std::string> remarks(const TubeState& state) const;
    std::string message(const TubeState& state) const;

    bool operator==(const Tube& other) const {
        return length_ == other.length_ && options_ == other.options_ && layers_ == other.layers_;
    }

private:
    Freedom freedom() const { return {true, true, options_.ends == Ends::free}; }
    TubeState state_of(const Equilibrium& at, const WallLoads& loads) const;
    bool loaded_rest(const WallLoads& loads, Equilibrium& at) const;
    unsigned flags_of(const Shape<double>& q, double pressure) const;
    double largest_strain_excess(const Shape<double>& q) const;
    /// `limit` receives the pressure where stability was lost on the way.
    Equilibrium solve_unloaded(double pressure, double* limit = nullptr) const;
    /// Near the equilibrium at a covered pressure: to rounding where the table reaches, else to about 1e-6.
    Shape<double> near(double pressure) const;
    /// What the section at a pressure follows from, `part` of it at least, out of the table where it reaches.
    UnloadedState<double> unloaded(double pressure, UnloadedTable::Part part, solve::SolveStatus& status) const;
    static UnloadedTable::Part part_for(Valve valve) {
        return valve == Valve::locked ? UnloadedTable::Part::all : UnloadedTable::Part::open;
    }
    UnloadedState<double> rest_state() const;
    double measure_locking() const;
    SectionConstants<double> constants(Valve valve) const;
    /// How these, and the wall's energy at a given shape, change with a parameter.
    SectionConstants<double> constants_slope(const TubeParameter& parameter) const;
    WallEnergy<double> energy_slope(const TubeParameter& parameter, const Shape<double>& q) const;
    /// What `section_slopes` says of a section that moves with a parameter, its axial law linear.
    void write_slope(const SectionValues<Dual<1>>& s, const SectionConstants<double>& d_constants, SectionModel model,
                     SectionSlope& slope) const;
    solve::SolveStatus linear_section(double pressure, SectionModel model, Valve valve, Section& section,
                                      double& rest_length) const;
    /// Pressure below which a tension-only tube behaves as in the limit from above [Pa].
    double smallest_pressure() const { return 1e-5 * pressure_scale_; }
    /// The tube under axial forces: what its nonlinear axial law interpolates. None where no range was short enough.
    struct AxialNodes {
        using Values = std::array<double, AxialLaw::max_degree + 1>;
        int count = 0, rest = 0;                                               // number of the unloaded one
        Values force{}, value{};                                               // and strain of the rod over the force
        std::array<Shape<double>, AxialLaw::max_degree + 1> shape{}, along{};  // and its derivative to the scaled force
    };
    /// Coefficients of powers from values at the nodes.
    static AxialNodes::Values coefficients_of(const AxialNodes::Values& value);
    AxialNodes nonlinear_law(const Equilibrium& rest, double pressure, Valve valve, double rest_length,
                             Section& section) const;

    double length_;
    std::vector<Layer> layers_;
    TubeOptions options_;
    double mass_ = 0.0;
    double area_scale_ = 0.0;  // pi R_i^2
    double linear_axial_ = 0.0, linear_bending_ = 0.0, linear_shear_ = 0.0;
    double largest_stretch_ = 0.0;  // of the laws' fit ranges; 0 not known
    Wall wall_;
    double pressure_scale_;
    Path path_;
    UnloadedTable table_;
    UnloadedState<double> rest_;  // what the section at zero pressure follows from
    double locking_share_ = 0.0;
};

}  // namespace softlimb::actuator
