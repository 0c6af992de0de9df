/* Projection to the constraints by the least change in the metric of M.
 *
 *   positions:   min (dq)^T M dq / 2,   Phi + Phi_q dq = 0,  g_N + W_N^T dq = g    (Newton)
 *   velocities:  min (dv)^T M dv / 2,   Phi_q (v + dv) + Phi_t = 0                 (linear)
 *
 * both M d + J^T l = 0, J d = -c; q moves by H dq, dq/dt = H v (Ascher and Petzold, Computer
 * Methods for Ordinary Differential Equations, 1998, section 9.2; Eich, SIAM J. Numer. Anal. 30,
 * 1993). A contact only pushes: if l > 0, its row is left out. g is 0, touching, or a depth.
 *
 * Contacts of a list have at each point the numbers of their entries there. Those that take part
 * are found again by id, within the way of a step. One that is not listed there is open.
 *
 * Coordinates of unit length, such as quaternions, the kinematics shows: groups of 4 coordinates
 * that 3 velocities move, or of 2 that 1 moves, with q . H = 0 wherever they are. Their length is a
 * constant of the motion that dq does not change. Blocks are looked at one by one. */
#ifndef NSDAE_SIM_PROJECTION_H
#define NSDAE_SIM_PROJECTION_H

#include "exponential_map.h"
#include "impulses.h"
#include "least.h"
#include "stepper.h"

/* Contacts, by their numbers at the point. */
typedef struct nsdae_projected {
  int any, room;    /* whether contacts are projected; room for them */
  nsdae_room rows;  /* in the rows of a list */
  int *of_row;      /* rows: the contact of a row, -1: a constraint */
  int *closed;      /* contacts that take part; k of fixed and tracked ones */
  double *depth;    /* their gap in the end, <= 0 */
  int alone;        /* they decide when it ends; constraints get as near as they can */
  int kept;         /* of a list: those that took part at the last point, by id */
  long *id;         /* kept */
  double *id_depth; /* kept */
  double reach;     /* within which they are listed at the next point */
  nsdae_ids ids;
  nsdae_arena arena; /* of a list: of all that has room for its contacts */
} nsdae_projected;

typedef struct nsdae_projector {
  nsdae_stepper *tools;
  int rows; /* m, or 0: nothing is projected */
  nsdae_least least;
  nsdae_projected contacts;
  nsdae_units units, other; /* those of the run; what is read of another one */
  double *total;            /* nv: the sum of all changes */
  double *q, *v, *qdot;     /* nq, nv, nq */
  double *H;                /* nq x nv, by blocks: the kinematics, where groups are looked for */
  double *length;           /* of the groups, at most nq: now */
  double *start;            /* 3 m: for looking at a start */
} nsdae_projector;

/* tools, rows and contacts.any are set before; the first takes the arrays of the groups. */
void nsdae_units_layout(nsdae_projector *projection, nsdae_arena *arena);
void nsdae_projector_layout(nsdae_projector *projection, nsdae_arena *arena);
/* Room for the contacts of a list, and for the rows of Phi_q; nothing of fixed contacts. NSDAE_OK
 * or NSDAE_E_MEMORY. */
int nsdae_projector_grow(nsdae_projector *projection, const nsdae_room *contacts,
                         const nsdae_room *rows);
void nsdae_projector_release(nsdae_projector *projection);

/* Looks for the groups at (t, q) and keeps their lengths. NSDAE_OK, or what the kinematics returns.
 */
int nsdae_units_find(nsdae_projector *projection, double t, const double *q);

/* 1 where a group of the terms' point is twice as long as it was, or half as long: then its length
 * is put back. What is near stays as the method left it. */
int nsdae_units_strayed(nsdae_projector *projection, const nsdae_terms *terms);
void nsdae_units_restore(nsdae_projector *projection, nsdae_terms *terms);

/* The next projection begins with the contacts that are closed in `contacts`, of a list with those
 * that are kept there; none: with none. */
void nsdae_projector_clear(nsdae_projector *projection);
/* Moves the terms' point to the constraints and to these contacts; penetrating: contacts that
 * overlap join them. NSDAE_OK, NSDAE_E_CONVERGENCE naming the worst row, and what the terms return.
 */
int nsdae_project_positions(nsdae_projector *projection, nsdae_terms *terms, int penetrating);

/* Moves the terms' point by H d. d is the change, less what of it would move the constraints, by M
 * and Phi_q of `by`. NSDAE_OK, and what the terms return. */
int nsdae_project_change(nsdae_projector *projection, nsdae_terms *terms, const nsdae_terms *by,
                         const double *change);

/* Changes the terms' velocity to that of the constraints. */
int nsdae_project_velocities(nsdae_projector *projection, nsdae_terms *terms);

#endif
