// Runs every claim, or those whose name contains the first argument. Exit code 0 only when all hold.
#include <chrono>
#include <cstring>
#include <exception>

#include "check.hpp"

int main(int count, char** arguments) {
    using namespace softlimb::tests;
    int run = 0, broken = 0;
    for (const Claim& claim : claims()) {
        if (count > 1 && !std::strstr(claim.name, arguments[1])) continue;
        const int before = failures;
        const auto start = std::chrono::steady_clock::now();
        try {
            claim.run();
        } catch (const std::exception& error) {
            fail(claim.name, 0, error.what());
        }
        const std::chrono::duration<double> took = std::chrono::steady_clock::now() - start;
        const bool holds = failures == before;
        std::printf("%s %s (%.2f s)\n", holds ? "holds" : "FAILS", claim.name, took.count());
        std::fflush(stdout);
        ++run, broken += !holds;
    }
    std::printf("%d claims, %d of them do not hold\n", run, broken);
    return run > 0 && broken == 0 ? 0 : 1;
}
