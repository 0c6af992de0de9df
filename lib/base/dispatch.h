/* Functions for what the processor at hand can do and that which is compiled for need not:
 * NSDAE_DISPATCH(feature, f, body, parameters, arguments) defines a static f, which runs body, a
 * function marked NSDAE_INLINED, compiled with the feature or without. Both must round alike. */
#ifndef NSDAE_DISPATCH_H
#define NSDAE_DISPATCH_H

/* 1: as on a processor that has none of them, so that a test can hold one against the other. */
extern int nsdae_dispatch_plain;

#if defined(__GNUC__) && defined(__x86_64__)
#define NSDAE_INLINED static inline __attribute__((always_inline))
#define NSDAE_DISPATCH(feature, f, body, parameters, arguments)    \
  __attribute__((target(feature))) static void f##_with parameters \
  {                                                                \
    body arguments;                                                \
  }                                                                \
  static void f##_without parameters                               \
  {                                                                \
    body arguments;                                                \
  }                                                                \
  static void f parameters                                         \
  {                                                                \
    if (!nsdae_dispatch_plain && __builtin_cpu_supports(feature))  \
      f##_with arguments;                                          \
    else                                                           \
      f##_without arguments;                                       \
  }
#else
#define NSDAE_INLINED static inline
#define NSDAE_DISPATCH(feature, f, body, parameters, arguments) \
  static void f parameters                                      \
  {                                                             \
    body arguments;                                             \
  }
#endif

#endif
