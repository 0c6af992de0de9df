/* Change points: poses in which the rows of Phi_q become dependent, where two branches of the
 * motion meet (a parallelogram whose bars lie in one line). A velocity cannot jump there without
 * an impulse: the motion stays on its branch, which is smooth.
 *
 * At the distance s from such a pose a combination of rows has a sine sigma of the order s, and
 * two errors are divided by it: a drift d of Phi moves the pose by d / sigma and its acceleration
 * by 2 d v^2 / sigma^3, onto the other branch if sigma < d^(1/2). So up to a sine tau, the width,
 * these rows are left out. The directions u that they leave open, M-orthogonal to the velocities
 * that all rows allow, have the accelerations in between those at the two borders t_0 and t_1,
 *
 *   (M u)^T v' = ((t_1 - t) a_0 + (t - t_0) a_1) / (t_1 - t_0),   a = (M u)^T v',   |u|_M = 1.
 *
 * At t_1 the motion of a second order Taylor polynomial is, brought back to all constraints. If it
 * does not fulfil those that were left out within their tolerance, the branches do not meet.
 * The motion is off by O(tau^3) in u' and O(tau^4) in u, which the rows take back at t_1, and along
 * the branch by O(tau^4). The width is 10 rtol^(1/3), or half of it and so on as long as a straight
 * line is not good enough. */
#ifndef NSDAE_EVENT_CHANGE_POINT_H
#define NSDAE_EVENT_CHANGE_POINT_H

#include "event_context.h"

/* Directions at once: as many loops in one pose. */
enum { NSDAE_CROSSING_MOST = 8 };

static inline int nsdae_crossing_most(int m)
{
  return m < NSDAE_CROSSING_MOST ? m : NSDAE_CROSSING_MOST;
}

/* Of the width: sines up to it belong to the rows that are left out, as another order of
 * elimination measures them. */
#define NSDAE_CROSSING_NEAR 4

typedef struct nsdae_crossing_room {
  double *x, *l, *q; /* nv, m, max(nq, nv) */
  double *ahead;     /* q and v at t_1, with room for the forces of y and a stage */
} nsdae_crossing_room;

typedef struct nsdae_event_crossing {
  int count;             /* directions that are held; 0: all rows are in force */
  int at_border;         /* an event is due at a border */
  int rank;              /* of all rows, at the border */
  int redundant;         /* constraints outside of the basis */
  double tau;            /* the largest width */
  double width;          /* of the phase */
  double least;          /* smallest sine at which forces were asked for since it was set to 1 */
  double *basis;         /* of the rows in force: see nsdae_kkt_basis */
  nsdae_rows rows;       /* (M u)^T of each direction */
  double begin, span;    /* t_0, t_1 - t_0 */
  double *start, *slope; /* most: of (M u)^T v' */
  double *a, *a_ahead;   /* nv: v' at both borders */
  nsdae_crossing_room room;
} nsdae_event_crossing;

void nsdae_event_crossing_layout(nsdae_event_crossing *crossing, const nsdae_event_setting *setting,
                                 nsdae_arena *arena);

/* The width, for this rtol. */
void nsdae_event_crossing_prepare(nsdae_event_crossing *crossing, double rtol);

/* The smallest sine of the rows of that rank at the point in work, which keeps its terms. NSDAE_OK
 * or a status. */
int nsdae_event_sine(nsdae_event_setting *setting, int rank, double *sine);

/* Whether the motion from q and v of y [n] at t, the point in work, with the acceleration a, and
 * a_ahead beyond, crosses a change point of rows of the crossing's rank: it comes nearer, and its
 * continuation beyond, room.ahead, fulfils the constraints within their tolerance. At first a_ahead
 * is a, and the tolerance is asked for with the better one that follows from it, again. 1, 0, or a
 * status. The point in work and the setting's kkt are others then. */
int nsdae_event_foresee(nsdae_event_crossing *crossing, nsdae_event_setting *setting, double t,
                        const double *y, int again);

/* After it, with the acceleration a_ahead there: whether a straight line between both is as good as
 * the energy needs it. */
int nsdae_event_is_straight(nsdae_event_crossing *crossing, const nsdae_event_setting *setting,
                            const double *y);
/* If it is not, or the constraints are not fulfilled: the crossing begins at half of the sine, or
 * not at all. */
void nsdae_event_narrow(nsdae_event_crossing *crossing);
/* Before a step: the width again, as far as the sines of the step before allow. */
void nsdae_event_widen(nsdae_event_crossing *crossing);

/* After both: holds the directions from y on. 1, 0 if they are not found, or a status. */
int nsdae_event_hold(nsdae_event_crossing *crossing, nsdae_event_setting *setting, const double *y);

/* (M u)^T v' of direction j at t. */
static inline double nsdae_event_held(const nsdae_event_crossing *c, int j, double t)
{
  return c->start[j] + c->slope[j] * (t - c->begin);
}

#endif
