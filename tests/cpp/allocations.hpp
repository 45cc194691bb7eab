#pragma once
// How often the program has taken memory from the heap so far; counted in allocations.cpp.
namespace softlimb::tests {

long allocations();

}  // namespace softlimb::tests
