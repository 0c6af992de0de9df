/* Contacts that are deeper than a slop are moved to it, after a step:
 *
 *   min d^T M d / 2,   g_i + W_i^T d >= -s_i,   Phi_q d = 0,   W_S^T d = 0 of joints that stick
 *
 * over the islands with a contact deeper than 1.1 s_i, d = M^-1 (W l + Phi_q^T m): by projected
 * Gauss-Seidel on the multipliers, forwards and backwards, with Nesterov's extrapolation between
 * and restarts (O'Donoghue and Candes, Found. Comput. Math. 15 (2015) 715). A tenth of the slop is
 * enough: the next step moves what is deeper. q moves by H d and v stays, so that it gives no
 * kinetic energy (as the split impulses of Catto, GDC 2006).
 *
 * Whether one is deeper follows from the gap at the end of the step by the rows at the point where
 * its contacts were closed: g_N + (t_1 - t) (W^T v + w), with the mean velocity v from there on.
 * Then g and W are those at the end, of every contact near: d turns a body about the contact that
 * it moves, and another corner of the body goes down. A contact that the step did not close, or
 * that is between s_i and 1.1 s_i deep, gets no deeper, W_i^T d >= 0; with a velocity of approach
 * the next step closes it.
 *
 * The slop is the way of a contact in a step of length h, from rest, at the largest acceleration
 * that the forces can give it:
 *
 *   s_i = h^2 / 2 a_i,   a_i = sum over its blocks b of |(W_b, T_b)^T a_b|,   T its tangents
 *
 * in the Euclidean norm: a_b is the acceleration of body b, the norm that of its point in the
 * contact, whatever the axes are. The forces of two bodies add up, as they may have any sign when
 * the neighbours change. The blocks of the kit are bodies. Those of callbacks may hold several, or
 * other coordinates: there each entry is taken as a body.
 *
 * a is M^-1 F, and what the constraints leave of it, as forces may reach a contact through them
 * alone: the larger value of a_i is taken. The second is
 *
 *   M a + Phi_q^T l = F,   Phi_q a = Phi_q (v_1 - v_0) / h
 *
 * of which the second row is the acceleration of the constraints in the step. A contact at rest
 * that is s_i deep remains closed. It is above the rounding of a gap (nsdae_terms_touch). */
#ifndef NSDAE_SLOP_PROJECTION_H
#define NSDAE_SLOP_PROJECTION_H

#include "contact_problem.h"

/* Contacts at the end of the step. */
typedef struct nsdae_slop_contacts {
  int *number; /* of those within reach */
  int *closed; /* by number: 1 if the step closed it */
  int *stuck;  /* f: 1 for frictional joints that stick */
  nsdae_contact_islands islands;
} nsdae_slop_contacts;

/* Multipliers, by rows: after the pair of sweeps before, and where the last one began. */
typedef struct nsdae_slop_pair {
  double *before, *begun;
} nsdae_slop_pair;

/* Accelerations [nv]: M^-1 F, and with the constraints; held NULL: not asked for. */
typedef struct nsdae_slop_accelerations {
  double *free;
  const double *held;
} nsdae_slop_accelerations;

/* A row is a contact of an island or, after these, a row of Phi_q or a frictional joint. */
typedef struct nsdae_slop_projection {
  double *missing;    /* rows: g + s, 0 of Phi_q */
  double *slop;       /* contacts of the island: s */
  double *weight;     /* rows: W^T M^-1 W */
  double *multiplier; /* rows: l, m */
  double *gap;        /* closed contacts, by number: at the end of the step */
  double *moved;      /* the same: W^T d */
  size_t *at;         /* rows: where their values begin */
  double *inverse;    /* values: M^-1 W, part by part */
  double *change;     /* nv: d */
  nsdae_slop_accelerations by;
  nsdae_slop_contacts end;
  nsdae_slop_pair last;
  nsdae_block_factor factor;
  int factored;        /* the block of it; -1: none */
  int contacts, count; /* of the island: contacts, rows */
} nsdae_slop_projection;

void nsdae_slop_layout(nsdae_slop_projection *slop, const nsdae_system *system, nsdae_arena *arena);
/* NSDAE_OK or NSDAE_E_MEMORY. */
int nsdae_slop_grow(nsdae_slop_projection *slop, const nsdae_system *system,
                    const nsdae_room *contacts, const nsdae_room *rows);
void nsdae_slop_release(nsdae_slop_projection *slop);

/* Gaps of the closed contacts at the end of a step of length h. They were closed at the terms'
 * point, a time rest before the end, with the mean velocity v until then. The terms have M, F and
 * all rows. The gaps of a list become those of the end. Returns the way by which the deepest is
 * too deep; 0: none is. held: the accelerations with constraints [nv], which stay until the
 * solution, or NULL, without them. */
double nsdae_slop_find(nsdae_slop_projection *slop, const nsdae_problem *problem,
                       const nsdae_terms *terms, const double *v, const double *held, double rest,
                       double h);

/* change, at the end of the step: the terms have M, Phi_q and contacts, those of a list within a
 * reach. Returns the number of islands that move. NSDAE_ARRAYS_GROW and other statuses of the list
 * of contacts. */
int nsdae_slop_solve(nsdae_slop_projection *slop, nsdae_problem *problem, nsdae_terms *end,
                     double reach, double h);

/* The gaps after the change [nv] that was made, by the rows at the end. */
void nsdae_slop_moved(nsdae_slop_projection *slop, const nsdae_problem *problem,
                      const nsdae_terms *end, const double *change);

#endif
