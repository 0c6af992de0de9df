/* Change points: poses in which the rows of Phi_q become dependent, where two branches of the
 * motion meet (a parallelogram whose bars lie in one line). A velocity cannot jump there without
 * an impulse: the motion stays on its branch, which is smooth.
 *
 * At the distance s from such a pose a combination of rows has a sine sigma of the order s, and
 * two errors are divided by it: a drift d of Phi moves the pose by d / sigma and its acceleration
 * by 2 d v^2 / sigma^3, onto the other branch if sigma < d^(1/2). So up to a sine tau, the width,
 * these rows are left out. The directions u that they leave open, M-orthogonal to the velocities
 * that all rows allow, keep the acceleration that they had at the border,
 *
 *   (M u)^T v' = (M u)^T v'(t_0),   |u|_M = 1.
 *
 * The motion at the other border is off by O(tau^2) in u' and O(tau^3) in u, which the rows take
 * back there, and along the branch by O(tau^3): tau = rtol^(1/3). */
#ifndef NSDAE_EVENT_CHANGE_POINT_H
#define NSDAE_EVENT_CHANGE_POINT_H

#include "event_context.h"

/* Directions at once: as many loops in one pose. */
enum { NSDAE_CROSSING_MOST = 8 };

/* Of the width: sines up to it belong to the rows that are left out, as another order of elimination
 * measures them. */
#define NSDAE_CROSSING_NEAR 4

typedef struct nsdae_event_crossing {
  int count;       /* directions that are held; 0: all rows are in force */
  int most;        /* for which there is room */
  int rank;        /* of all rows, at the border */
  int redundant;   /* constraints outside of the basis */
  int at_border;   /* an event is due at a border */
  double width;    /* tau */
  double least;    /* smallest sine at which forces were asked for since it was set to 1 */
  double *basis;   /* of the rows in force: see nsdae_kkt_basis */
  nsdae_rows rows; /* (M u)^T of each direction */
  double *rate;    /* most: (M u)^T v'(t_0) */
  double *x, *a; /* nv */
  double *l, *q;   /* m, 2 nq + nv */
} nsdae_event_crossing;

void nsdae_event_crossing_layout(nsdae_event_crossing *crossing, const nsdae_event_setting *setting,
                                 nsdae_arena *arena);

/* The width, for this rtol. */
void nsdae_event_crossing_prepare(nsdae_event_crossing *crossing, double rtol);

/* The smallest sine of the rows of that rank at the point in work, which keeps its terms. NSDAE_OK
 * or a status. */
int nsdae_event_sine(nsdae_event_setting *setting, int rank, double *sine);

/* Whether the motion from the point in work, with the acceleration a [nv], crosses a change point:
 * it comes nearer, and its continuation beyond fulfils the constraints within their tolerance. Then
 * the directions are held from here on. rank is that of all rows, y begins with q and v. 1, 0, or a
 * status; the setting's kkt has other factors then, and the point in work is the same anew. */
int nsdae_event_cross(nsdae_event_crossing *crossing, nsdae_event_setting *setting, int rank,
                      const double *y, const double *a);

#endif
