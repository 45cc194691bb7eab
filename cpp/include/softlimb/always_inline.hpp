#pragma once
// For code that is compiled once an instruction set: a function that the compiler left out of line there would be
// shared with the rest of the library, and run on machines that do not know its instructions.

#if defined(__GNUC__) || defined(__clang__)
#define SOFTLIMB_ALWAYS_INLINE __attribute__((always_inline)) inline
#elif defined(_MSC_VER)
#define SOFTLIMB_ALWAYS_INLINE __forceinline
#else
#define SOFTLIMB_ALWAYS_INLINE inline
#endif

// Lambdas take the attribute behind their parameters, where MSVC has none.
#if defined(__GNUC__) || defined(__clang__)
#define SOFTLIMB_LAMBDA_INLINE __attribute__((always_inline))
#else
#define SOFTLIMB_LAMBDA_INLINE
#endif
