/* One island, packed for the methods: every item in three rows (those it does not have are zero),
 * all scaled by the data. With d the mean diagonal of an item, D the largest one of the problem and
 * s = max |q|,
 *
 *   r = s / (e D) r',   u = s e u',   y = s / sqrt(D) y',   e = sqrt(d / D),
 *
 * so that the diagonal of W' is one in the mean, and the residual of the public header is e times
 * the natural map of r' and u', K being a cone. Of s, D and e the nearest powers of two (of four)
 * are taken, so that nothing is rounded on the way; then the map is that of rho r' and u', with rho
 * = d / (e^2 D) between 1/4 and 4, and weight is e s / max |q|. */
#ifndef NSDAE_FRICTION_SCALED_ISLAND_H
#define NSDAE_FRICTION_SCALED_ISLAND_H

#include "cone.h"
#include "global_problem.h"

/* What each item asks for, and how it is scaled. */
typedef struct nsdae_fc_items {
  int *item;      /* n: its number in the whole */
  int *kind;      /* n: enum nsdae_fc_kind */
  double *mu;     /* n */
  double *size;   /* n: e */
  double *weight; /* n */
  double *rho;    /* n */
  double *factor; /* n: r = factor r' */
  double *q;      /* 3 n */
  double *C;      /* 3 n: compliance */
  double *D;      /* 9 n: diagonal blocks of W + C + NSDAE_FC_PROXIMAL, symmetric, in a frame
                     turned about the normal where D[5] = D[7] = 0 */
  double *turn;   /* 2 n: cosine and sine of that */
  double *S;      /* 9 n: inverse of D + NSDAE_FC_PROXIMAL in its own frame, its lower triangle by
                     columns, S[0] NaN if there is none; and the first row of W + C there */
} nsdae_fc_items;

/* J by parts: item k has parts first[k] .. first[k + 1] - 1, part e the columns of block[e]. */
typedef struct nsdae_fc_parts {
  int entries;   /* parts */
  size_t values; /* of all */
  int *first;    /* n + 1 */
  int *block;    /* entries */
  size_t *at;    /* entries + 1 */
  double *J;     /* size x 3 each, column-major */
  int *size;     /* blocks */
  int *offset;   /* blocks + 1: of y */
  int bodies;    /* every block has six entries of y */
} nsdae_fc_parts;

/* Impulses [3 n] that r is added to, leading and trailing parts, if q are their velocities; NULL:
 * none (see iterative_refinement.c). */
typedef struct nsdae_fc_base {
  const double *high, *low;
} nsdae_fc_base;

typedef struct nsdae_fc_scaled {
  const nsdae_fc_global *global;
  int label;      /* its number in the global problem */
  int n, blocks;  /* items, blocks of y */
  int ny;         /* entries of y */
  int local;      /* y is r and J is W */
  int all_listed; /* of the local form: every pair of items, zeros too */
  double largest; /* D */
  double exact;   /* how closely a sweep solves a contact: |r_T| against mu r_N of a sliding one */
  nsdae_fc_items items;
  nsdae_fc_parts parts;
  double *r, *u; /* 3 n */
  double *y;     /* ny; of the local form r itself */
  double *low;   /* ny: work: trailing part of the sum */
  nsdae_fc_base base;
} nsdae_fc_scaled;

/* The power of two nearest by ratio; 1 if x is not positive. */
double nsdae_fc_power_of_two(double x);

/* Item k of the island: its number in the global problem. */
static inline int nsdae_fc_member(const nsdae_fc_scaled *fc, int k)
{
  const nsdae_fc_islands *all = &fc->global->islands;
  return all->member[all->start[fc->label] + k];
}

/* Takes the arrays of the island fc->label of fc->global. */
void nsdae_fc_layout(void *fc, nsdae_arena *arena);

/* Fills them, and r from that of the whole. */
void nsdae_fc_fill(nsdae_fc_scaled *fc, const double *r);

/* r of the island into that of the whole. */
void nsdae_fc_scatter(const nsdae_fc_scaled *fc, const double *from, double *r);

/* Velocities of the whole into those of the island, 3 n. */
void nsdae_fc_gather(const nsdae_fc_scaled *fc, const double *u, double *to);

/* y and u of the point r [3 n]; y may be fc->y (in the local form it is not touched). */
void nsdae_fc_velocities(const nsdae_fc_scaled *fc, const double *r, double *y, double *u);

/* By how much dr [3 n] changes them, without its compliance. */
void nsdae_fc_response(const nsdae_fc_scaled *fc, const double *dr, double *dy, double *du);

/* Largest entry of the natural map, weighted: the residual of the public header; of item k with
 * velocities u [3], and of all. */
double nsdae_fc_item_residual(const nsdae_fc_scaled *fc, int k, const double *r, const double *u);
double nsdae_fc_residual(const nsdae_fc_scaled *fc, const double *r, const double *u);

/* r of item k with the base, leading and trailing part. */
void nsdae_fc_impulse(const nsdae_fc_scaled *fc, int k, const double *r, double x[3],
                      double low[3]);

/* mu |u_T| of item k: u^ = u + that e_N */
static inline double nsdae_fc_s_of(const nsdae_fc_scaled *fc, int k)
{
  return fc->items.mu[k] * nsdae_fc_length(fc->u[3 * k + 1], fc->u[3 * k + 2]);
}

/* J of part e */
static inline const double *nsdae_fc_part(const nsdae_fc_scaled *fc, int e)
{
  return fc->parts.J + fc->parts.at[e];
}

#endif
