#include "allocations.hpp"
#include "check.hpp"
#include "examples.hpp"
#include "softlimb/sweep/members.hpp"

using namespace softlimb;
using namespace softlimb::tests;
using actuator::SectionModel;
using actuator::Tube;
using actuator::Valve;
using sweep::Member;
using sweep::Members;

namespace {

std::shared_ptr<const Tube> shared(Tube tube) { return std::make_shared<const Tube>(std::move(tube)); }

/// The reference limb with a rod of its own in its midst; of the proximal tubes one is a copy.
Members mixed() {
    const auto proximal_tube = shared(proximal());
    std::vector<Member> members = {{proximal_tube}, {shared(proximal())}, {proximal_tube}};
    members.push_back({nullptr, soft_section(), 0.15, 0.004});
    members.push_back({shared(distal())});
    return Members(std::move(members));
}

constexpr std::array pressures = {30 * kPa, 30 * kPa, 55 * kPa, 30 * kPa};

}  // namespace

CLAIM(members_have_the_sections_of_their_tubes_at_their_pressures) {
    const Members members = mixed();
    CHECK(members.rods() == 5 && members.actuators() == 4);
    const std::array tubes = {proximal(), proximal(), proximal(), distal()};
    for (const SectionModel model : {SectionModel::tangent, SectionModel::nonlinear, SectionModel::paper})
        for (const Valve valve : {Valve::open, Valve::locked}) {
            std::vector<limb::RodAtPressure> rods(5);
            for (limb::RodAtPressure& rod : rods) rod.line_load.force.x = 3.0;
            CHECK(!members.at_pressures(pressures.data(), model, valve, rods));
            for (int i = 0; i < 4; ++i) {
                const limb::RodAtPressure& rod = rods[i < 3 ? i : 4];
                const actuator::SectionAtPressure at = tubes[i].section(pressures[i], model, valve);
                CHECK(rod.section == at.section && rod.rest_length == at.rest_length);
            }
            CHECK(rods[3].section == soft_section() && rods[3].rest_length == 0.15);
            for (const limb::RodAtPressure& rod : rods) CHECK(rod.line_load.force.x == 3.0);
        }
}

CLAIM(an_actuator_without_a_state_is_named_and_counts_as_unpressurised) {
    const auto balloon = shared(plain_tube());
    const Members members({{balloon}, {balloon}, {balloon}});
    std::vector<limb::RodAtPressure> rods(3);
    const std::array beyond = {95 * kPa, 20 * kPa, 95 * kPa};
    const Members::Refusal refusal = members.at_pressures(beyond.data(), SectionModel::tangent, Valve::open, rods);
    CHECK(refusal && refusal.actuator == 2 && refusal.pressure == 95 * kPa);
    CHECK(refusal.status == solve::SolveStatus::limit_point);
    CHECK(members.reason(refusal).starts_with("actuator 2 has no stable state at 95 kPa: "));
    const double rest = balloon->section(0.0).rest_length;
    CHECK(rods[0].rest_length == rest && rods[2].rest_length == rest && rods[1].rest_length > rest);
    CHECK(members.reason({}).empty());
    std::vector<limb::RodAtPressure> too_few(2);
    CHECK_RAISES(std::invalid_argument,
                 members.at_pressures(beyond.data(), SectionModel::tangent, Valve::open, too_few));
}

CLAIM(sections_of_all_rods_at_new_pressures_take_no_memory) {
    const Members members = mixed();
    std::vector<limb::RodAtPressure> rods(5);
    Draw draw(11);
    for (const SectionModel model : {SectionModel::tangent, SectionModel::nonlinear, SectionModel::paper}) {
        members.at_pressures(pressures.data(), model, Valve::open, rods);  // tables made once for the program
        const long before = allocations();
        for (int i = 0; i < 100; ++i) {
            std::array<double, 4> drawn;
            for (double& pressure : drawn) pressure = draw(0.0, 90 * kPa);
            members.at_pressures(drawn.data(), model, Valve::open, rods);
        }
        CHECK(allocations() == before);
    }
}
