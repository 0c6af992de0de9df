/* Where a body is and how it moves, as far as formulas need it; and rows of velocities. */
#ifndef NSDAE_BODIES_POSE_H
#define NSDAE_BODIES_POSE_H

#include "jet.h"
#include "space.h"

/* x = r + R s for a point s of the body's own frame, x' = v + w x (x - r). */
typedef struct nsdae_pose {
  double r[3], R[9], v[3], w[3]; /* all in space */
  double angle;                  /* planar: theta, also beyond a turn */
} nsdae_pose;

/* The ground's, and a body's from its part of q and v (v NULL: at rest). */
nsdae_pose nsdae_pose_ground(void);
nsdae_pose nsdae_pose_of(int dimension, const double *q, const double *v);
/* Its place alone; its velocities, once it is placed. */
void nsdae_pose_place(int dimension, const double *q, nsdae_pose *pose);
void nsdae_pose_move(int dimension, const double *v, nsdae_pose *pose);

/* A point s and a direction a of the body's own frame, with v' = 0:
 *   x'' = w x (w x (x - r)),   u' = w x u,   u'' = w x (w x u) */
static inline nsdae_jet3 nsdae_pose_direction(const nsdae_pose *pose, const double *a)
{
  double u[3], rate[3], second[3];
  nsdae_jet3 jet;
  nsdae_turn(pose->R, a, u);
  nsdae_cross3(pose->w, u, rate);
  nsdae_cross3(pose->w, rate, second);
  for (int i = 0; i < 3; i++) jet.at[i] = (nsdae_jet){u[i], rate[i], second[i]};
  return jet;
}

static inline nsdae_jet3 nsdae_pose_point(const nsdae_pose *pose, const double *s)
{
  nsdae_jet3 jet = nsdae_pose_direction(pose, s);
  for (int i = 0; i < 3; i++) {
    jet.at[i].x += pose->r[i];
    jet.at[i].d += pose->v[i];
  }
  return jet;
}

/* x := r + R s */
static inline void nsdae_pose_put(const nsdae_pose *pose, const double *s, double *x)
{
  nsdae_turn(pose->R, s, x);
  for (int i = 0; i < 3; i++) x[i] += pose->r[i];
}

/* The coefficients of a scalar velocity in those of two bodies: its rate is
 * sum_i linear_i . v_i + angular_i . w_i, in space. */
typedef struct nsdae_velocity_row {
  double linear[2][3], angular[2][3];
} nsdae_velocity_row;

/* The row of n . (x'_1 - x'_0) for the points x_i that are fixed to the bodies at this moment. */
nsdae_velocity_row nsdae_relative_row(const nsdae_pose pose[2], nsdae_jet3 x0, nsdae_jet3 x1,
                                      nsdae_jet3 n);

#endif
