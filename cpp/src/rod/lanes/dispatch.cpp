#include <atomic>
#include <stdexcept>

#include "softlimb/rod/lanes/pieces.hpp"

namespace softlimb::rod::lanes {

namespace baseline {
extern const Kernel kernel;
}
#ifdef SOFTLIMB_X86_KERNELS
namespace avx2 {
extern const Kernel kernel;
}
namespace avx512 {
extern const Kernel kernel;
}
#endif

const std::vector<const Kernel*>& kernels() {
    static const std::vector<const Kernel*> known = [] {
        std::vector<const Kernel*> list{&baseline::kernel};
#ifdef SOFTLIMB_X86_KERNELS
        __builtin_cpu_init();
        const bool v3 = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") &&
                        __builtin_cpu_supports("bmi") && __builtin_cpu_supports("bmi2");
        if (v3) list.push_back(&avx2::kernel);
        if (v3 && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
            __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512vl") &&
            __builtin_cpu_supports("avx512cd"))
            list.push_back(&avx512::kernel);
#endif
        return list;
    }();
    return known;
}

namespace {
std::atomic<const Kernel*>& chosen() {
    static std::atomic<const Kernel*> kernel{kernels().back()};
    return kernel;
}
}  // namespace

const Kernel& kernel() { return *chosen().load(std::memory_order_relaxed); }

void use(const std::string& instruction_set) {
    std::string known;
    for (const Kernel* k : kernels()) {
        if (instruction_set == k->instruction_set) {
            chosen().store(k, std::memory_order_relaxed);
            return;
        }
        known += known.empty() ? k->instruction_set : std::string(", ") + k->instruction_set;
    }
    throw std::invalid_argument("instruction_set must be one of " + known + " on this machine, got " + instruction_set);
}

}  // namespace softlimb::rod::lanes
