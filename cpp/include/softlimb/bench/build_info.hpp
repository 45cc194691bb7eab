#pragma once
// What this build of the core is: times and bits belong to it.
#include <string>

namespace softlimb::bench {

struct BuildInfo {
    std::string compiler;  // name and version
    std::string flags;     // as CMake gave them to the compiler, standard and definitions left out
    std::string standard;  // of the language, as in __cplusplus
    std::string target;    // architecture, and what the flags alone let the compiler use of it
    bool assertions;       // true where assert() is compiled in
};

BuildInfo build_info();

}  // namespace softlimb::bench
