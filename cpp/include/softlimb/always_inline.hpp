#pragma once
// For code that is compiled once an instruction set: a function that the compiler left out of line there would be
// shared with the rest of the library, and run on machines that do not know its instructions.

// Under a sanitizer, which checks every access of what is inlined, one such kernel would compile for a quarter of an
// hour; that build runs where it is made, and inlines what it likes.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define SOFTLIMB_ALWAYS_INLINE inline
#define SOFTLIMB_LAMBDA_INLINE
#elif defined(__GNUC__) || defined(__clang__)
#define SOFTLIMB_ALWAYS_INLINE __attribute__((always_inline)) inline
// Lambdas take the attribute behind their parameters, where MSVC has none.
#define SOFTLIMB_LAMBDA_INLINE __attribute__((always_inline))
#elif defined(_MSC_VER)
#define SOFTLIMB_ALWAYS_INLINE __forceinline
#define SOFTLIMB_LAMBDA_INLINE
#else
#define SOFTLIMB_ALWAYS_INLINE inline
#define SOFTLIMB_LAMBDA_INLINE
#endif

/// For code that is large as it is: with its neighbours in one function it would leave the instruction cache.
#if defined(__GNUC__) || defined(__clang__)
#define SOFTLIMB_NEVER_INLINE __attribute__((noinline))
#elif defined(_MSC_VER)
#define SOFTLIMB_NEVER_INLINE __declspec(noinline)
#else
#define SOFTLIMB_NEVER_INLINE
#endif
