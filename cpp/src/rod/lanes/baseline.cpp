#define SOFTLIMB_INSTRUCTION_SET baseline
#define SOFTLIMB_INSTRUCTION_SET_NAME "baseline"
#define SOFTLIMB_LANES 2
#include "pieces.ipp"
