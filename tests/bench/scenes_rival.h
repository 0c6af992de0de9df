/* Bodies of one solid each with joints between them, for a peer to be timed on in the same run. */
#ifndef NSDAE_BENCH_SCENES_RIVAL_H
#define NSDAE_BENCH_SCENES_RIVAL_H

#include <nsdae/bodies.h>

typedef struct mechanism {
  nsdae_scene scene;
  nsdae_joint *joint; /* spherical or revolute; body[0] < body[1] is the parent in a tree */
  int joints;
  size_t joint_room, body_room;
  int steps;
} mechanism;

/* A run of the peer; NULL if it is not built or failed. solver: "Newton" or "CG". */
void *mujoco_begin(const mechanism *m, const char *solver);
/* CPU times of the next steps [count, s]; 0, or -1: it became unstable. */
int mujoco_advance(void *run, int count, double *time);
/* Coordinates of all bodies now, as q of nsdae; returns the largest velocity of a degree of
 * freedom. */
double mujoco_state(const void *run, double *q);
void mujoco_end(void *run);

#endif
