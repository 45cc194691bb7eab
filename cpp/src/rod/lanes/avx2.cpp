#define SOFTLIMB_INSTRUCTION_SET avx2
#define SOFTLIMB_INSTRUCTION_SET_NAME "avx2"
#define SOFTLIMB_LANES 4
#include "pieces.ipp"
