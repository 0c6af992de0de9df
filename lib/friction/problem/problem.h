/* A problem as it was given: checked, and the offsets of its parts. */
#ifndef NSDAE_FRICTION_PROBLEM_H
#define NSDAE_FRICTION_PROBLEM_H

#include <nsdae/friction.h>

#include "arena.h"

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

#endif
