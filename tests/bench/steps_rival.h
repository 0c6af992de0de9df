/* A column of balls that falls on a floor and comes to rest, for peers to be timed on in the same
 * run: one degree of freedom a ball, a contact with the floor and one between neighbours. */
#ifndef NSDAE_BENCH_STEPS_RIVAL_H
#define NSDAE_BENCH_STEPS_RIVAL_H

#ifdef __cplusplus
extern "C" {
#endif

typedef struct column {
  int balls, steps;
  double radius, mass, gravity, e, dt; /* m, kg, m/s^2, -, s */
} column;

/* Height of ball i from 0 at the start: every gap 5 mm. */
static inline double column_height(const column *c, int i)
{
  return c->radius * (2 * i + 1) + 5e-3 * (i + 1);
}

/* Time of all steps [s], creation left out; negative where the peer is not built or failed. top:
 * the height of the last ball at the end [m]. */
double siconos_column(const column *c, double *top);
double mujoco_column(const column *c, double *top);

#ifdef __cplusplus
}
#endif
#endif
