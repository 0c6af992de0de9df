/* The pendulum with a stop, run by the C functions alone: what handles.cpp compares with. */
#ifndef NSDAE_TESTS_CPP_PENDULUM_H
#define NSDAE_TESTS_CPP_PENDULUM_H

#ifdef __cplusplus
extern "C" {
#endif

enum { PENDULUM_STEPS = 600, PENDULUM_ROW = 10 };

/* row [10]: time, q, v, multiplier, normal impulse of each step. Returns how many. */
int pendulum_in_c(double row[][PENDULUM_ROW]);

#ifdef __cplusplus
}
#endif
#endif
