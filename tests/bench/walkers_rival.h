/* The walker of docs/examples/walker.py: a trunk on four legs, hips and knees with limits and
 * position motors of limited torque. Steered open loop, for a peer to be timed on in the same run.
 */
#ifndef NSDAE_BENCH_WALKERS_RIVAL_H
#define NSDAE_BENCH_WALKERS_RIVAL_H

#include <math.h>

enum { WALKER_LEGS = 4, WALKER_MOTORS = 2 * WALKER_LEGS };

/* Height of the hips at the start and length of a link [m]; motors [N m/rad, N m s/rad, N m]. */
static const double walker_height = 0.5, walker_link = 0.24, walker_kp = 200, walker_kd = 2.5,
                    walker_torque = 40, walker_mu = 0.8,
                    walker_landed = 0.25; /* all feet are on the floor [s] */
static const double walker_hip[WALKER_LEGS][2] = {
    {0.2, 0.2}, {0.2, -0.2}, {-0.2, 0.2}, {-0.2, -0.2}};

/* Targets of the motors of walker i at time t: a trot. The walkers differ in the length of their
 * strides. */
static inline void walker_steer(int i, double t, double target[WALKER_MOTORS])
{
  const double pi = 3.14159265358979323846, ramp = fmin(t / 2, 1), stride = 0.1 + 0.001 * (i % 100);
  for (int leg = 0; leg < WALKER_LEGS; leg++) {
    double phase = 6 * pi * t + (leg == 0 || leg == 3 ? 0 : pi);
    target[2 * leg] = stride * ramp * sin(phase) - 0.25;
    target[2 * leg + 1] = 0.5 + 0.4 * ramp * fmax(cos(phase), 0);
  }
}

/* Walkers first .. last - 1, each in turn by steps of dt from 0 to end [s]. height: of the centre
 * of the trunk at the end; deepest: largest depth of a foot in the floor after walker_landed [m],
 * or NULL. Returns 0, or -1: the peer is not built or failed. */
int mujoco_walkers(int first, int last, double dt, double end, double *height, double *deepest);

#endif
