#include "softlimb/bench/build_info.hpp"

#ifndef SOFTLIMB_FLAGS  // a definition of CMakeLists.txt; other ways to build do not know it
#define SOFTLIMB_FLAGS "unknown"
#endif

namespace softlimb::bench {
namespace {

std::string compiler() {
#if defined(__clang__)
    return "Clang " __clang_version__;
#elif defined(__GNUC__)
    return "GCC " __VERSION__;
#elif defined(_MSC_VER)
    return "MSVC " + std::to_string(_MSC_FULL_VER);
#else
    return "unknown";
#endif
}

std::string target() {
#if defined(__x86_64__) || defined(_M_X64)
#if defined(__AVX512F__)
    return "x86-64, AVX-512";
#elif defined(__AVX2__)
    return "x86-64, AVX2";
#elif defined(__AVX__)
    return "x86-64, AVX";
#else
    return "x86-64 baseline";
#endif
#elif defined(__aarch64__) || defined(_M_ARM64)
    return "arm64";
#else
    return "unknown";
#endif
}

bool assertions() {
#ifdef NDEBUG
    return false;
#else
    return true;
#endif
}

}  // namespace

BuildInfo build_info() { return {compiler(), SOFTLIMB_FLAGS, std::to_string(__cplusplus), target(), assertions()}; }

}  // namespace softlimb::bench
