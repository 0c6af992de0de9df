/* A problem without its masses: with M = L L^T by blocks, J = L^-1 H and y = L^T v,
 *
 *   y = L^-1 f + J r,   u = J^T y + w + C r,   W = J^T J,   q = J^T L^-1 f + w
 *
 * The local form has y = r and J = W. */
#ifndef NSDAE_FRICTION_GLOBAL_PROBLEM_H
#define NSDAE_FRICTION_GLOBAL_PROBLEM_H

#include <nsdae/friction.h>

#include "arena.h"
#include "thread_pool.h"

/* A problem as it was given: checked, and the offsets of its parts. */

/* Offsets into the arrays of the caller. */
typedef struct nsdae_fc_view {
  const nsdae_friction_problem *p;
  int items, m, nv;    /* contacts and bilateral rows; entries of r; entries of v */
  int entries;         /* first[items] */
  size_t mass, values; /* entries of M and of value */
  int *row;            /* items + 1: first row of each */
  int *offset;         /* blocks + 1: first entry of v of each */
  size_t *mass_at;     /* blocks + 1: of M */
  size_t *at;          /* entries + 1: of value */
} nsdae_fc_view;

/* Checks all that the public header asks of a problem, except of M and of the symmetry of W. */
int nsdae_fc_problem_check(const nsdae_friction_problem *p, nsdae_error *error);

/* Takes the arrays for the problem in view->p, which has been checked; fills them. */
void nsdae_fc_view_layout(nsdae_fc_view *view, nsdae_arena *arena);
void nsdae_fc_view_fill(nsdae_fc_view *view);

/* Fills the record; returns the status. */
int nsdae_fc_refuse(nsdae_error *error, int status, const char *argument, int index,
                    const char *text);

static inline int nsdae_fc_rows(const nsdae_friction_problem *p, int item)
{
  return item >= p->contacts ? 1 : p->rows ? p->rows[item] : 3;
}

/* Items that a thread takes at a time: some 10 us. */
enum { NSDAE_FC_GRAIN = 64 };

/* Parts that share no block; items that nothing moves (d = 0) are in none. */
typedef struct nsdae_fc_islands {
  int count;
  int *label;        /* items: the island, from 0; -1: none */
  int *member;       /* items: those of island 0 in order, then those of island 1, ... */
  int *start;        /* items + 2: first of each island in member */
  int *listed;       /* blocks: those of island 0 by their number, then those of island 1, ... */
  int *listed_start; /* items + 1: first of each island in listed */
  int *number;       /* blocks (local form: items): their number in their island; -1: in none */
  int *parent;       /* items and blocks: disjoint sets */
} nsdae_fc_islands;

typedef struct nsdae_fc_global {
  nsdae_fc_view view;
  nsdae_thread_pool *pool; /* or NULL */
  double *L;               /* Cholesky factors, in the layout of M */
  int *diagonal;           /* blocks: whether that of the block is, which then is inverted */
  double *J;               /* in the layout of value */
  double *q;               /* m */
  double *d;               /* items: mean of the diagonal entries of W + C */
  double *v;               /* nv: work of the certificate */
  double *low;             /* nv: the same */
  double *r;               /* m: the answer, until it is handed over */
  double *r_low;           /* m: its trailing part */
  double *u;               /* m: velocities of a point on the way to it */
  double scale;            /* max |q|; 1 if that is zero */
  double most_d;           /* max d */
  nsdae_fc_islands islands;
} nsdae_fc_global;

/* Takes the arrays for the problem in whole->view.p, which has been checked. */
void nsdae_fc_global_layout(void *whole, nsdae_arena *arena);

/* Fills them; status as of nsdae_friction_check. */
int nsdae_fc_global_fill(nsdae_fc_global *whole, nsdae_error *error);

/* Whether part e of the whole is not all zeros. One of zeros joins nothing: its block may be
 * another island's. */
int nsdae_fc_touches(const nsdae_fc_global *whole, int e);

/* An item that nothing moves and whose velocity its law forbids; -1: none. */
int nsdae_fc_global_blocked(const nsdae_fc_global *whole);

/* v := M^-1 v of block b. */
void nsdae_fc_divide_by_mass(const nsdae_fc_global *whole, int b, double *v);

/* ---- the certificate, from the data as given (farkas.c); impulses may be double-double, r +
 * low (low NULL: zero) */

/* u [m] of r and low [m], and the residual of the public header; NaN if an entry is not finite.
 */
double nsdae_fc_global_residual(const nsdae_fc_global *whole, const double *r, const double *low,
                                double *u);

/* u in the rows of one island; those of others stay. */
void nsdae_fc_island_velocities(const nsdae_fc_global *whole, int island, const double *r,
                                const double *low, double *u);

#endif
