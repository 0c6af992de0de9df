/* Which of the rows that are closed or stick have an equation of their own. Where a body rests on
 * more points than it has freedoms, the rows w of W_C depend on each other: the motion is
 * determined, how its forces share is not. The rows are taken in turn, contacts by their normal
 * force and what sticks after them, and depend as in dense.h, w_p = sum c_l w_l. The
 * forces z_p = (1 in p, -c_l in l) then move nothing, and in place of its row p has a relation F_p
 * = sum r_l F_l:
 *
 *   even   r_l = c_l D_l / D_p       z_p^T D F = 0, so that F^T D F is least; D = 1 for normal
 *                                    forces, 1 / (mu F_N) for friction
 *   kept   F_N = s sum F_N of those taken, F_T = r F_N: the parts that the problem of
 *          accelerations gave it
 *
 * Even is tried first, and taken if with F + Z a that fulfils it nothing pulls and no friction
 * leaves its cone. Each of them is a solution. Where the dependence ends, the gap of such a contact
 * leaves zero and ends the phase. */
#ifndef NSDAE_EVENT_HYPERSTATIC_H
#define NSDAE_EVENT_HYPERSTATIC_H

#include "contacts.h"
#include "dense.h"

/* A problem of accelerations that is solved, and what becomes of its forces. */
typedef struct nsdae_shared {
  nsdae_contacts *problem;       /* its forces may be shared differently afterwards */
  const double *lambda;          /* m: of its solution */
  double rank_tol, none;         /* accelerations up to the second are none */
  double looser;                 /* 1, or more: rows that nearly depend do */
  int *mode;                     /* k: of the solution; what others hold is to stick */
  const int *moving, *breakaway; /* k: slides already; and just began to */
  const int *frictional_joint_mode, *slide_sense; /* f */
  int *related;       /* out, k (1 + nt), by contact F_N and F_T: has a relation */
  double *relation;   /* the square of it: their r, see nsdae_relation_at */
  int *slide_row;     /* out, f: one that sticks has a row */
  double *slide_part; /* out, f: F_S = -(b + mu |lambda|) times this if it has none */
} nsdae_shared;

/* Rows by the columns of the problem, n of them; those of frictional joints come last. */
typedef struct nsdae_hyperstatic {
  const nsdae_shared *of; /* in work */
  nsdae_rank_revealing rows;
  int *normal, *force_number; /* n: column of the same contact's normal; i (1 + nt) of F_N of
                                 contact i, F_T after it */
  double *relation;           /* n x n, by rows */
  double *force, *weight;     /* n */
  double *emphasis;           /* k, by place among the active */
  double *solved;             /* n: forces of the problem's solution */
  int *solved_mode;           /* k */
  double *system, *shift;     /* n x n, n: of fulfil_relations */
  int *pivot;                 /* n */
} nsdae_hyperstatic;

/* The place of r_l of force p: pairs of contacts shell by shell, so that those of fewer contacts
 * are the beginning. */
static inline size_t nsdae_relation_at(int nt, int p, int l)
{
  size_t columns = 1 + (size_t)nt, i = (size_t)p / columns, j = (size_t)l / columns;
  size_t shell = i > j ? i : j, pair = shell * shell + (i == shell ? j : shell + 1 + i);
  return (pair * columns + (size_t)p % columns) * columns + (size_t)l % columns;
}

void nsdae_hyperstatic_layout(nsdae_hyperstatic *sharing, const nsdae_dims *dims,
                              nsdae_arena *arena);

/* Rows and relations. 1; 0 where no friction was found that holds what sticks, and all is as it
 * was. */
int nsdae_share(nsdae_hyperstatic *sharing, const nsdae_shared *of);

#endif
