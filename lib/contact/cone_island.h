/* An island with true cones, or a large one: a friction problem by blocks, in its global form
 *
 *   M v = r + [W, -Phi_q^T] (Lambda, .),  u = W^T v + w + e v(-),  Phi_q v + Phi_t = 0
 *
 * (see nsdae/friction.h), warm from the last impulses. A frictional joint with a bound is a planar
 * contact as in cones.h; its normal row has a compliance d and no part in H. v is formed again from
 * the impulses; what of it is smaller than the certificate can tell from zero, is zero.
 *
 * The row of a position motor (slides.h) is linear within its limit: an active set has the motors
 * within the limit as bilateral rows with compliance, and adds to r the impulses of those at it. It
 * starts from the step before and ends if no motor changes its set; else, after MOTOR_ROUNDS, all
 * are planar contacts. */
#ifndef NSDAE_CONE_ISLAND_H
#define NSDAE_CONE_ISLAND_H

#include <nsdae/friction.h>

#include "island_equations.h"

/* The problem: blocks, items (contacts, planar joints; then rows of Phi_q and of motors), and what
 * their entries take. */
typedef struct nsdae_cone_arrays {
  int *member; /* blocks: that of the system */
  int *size;   /* blocks */
  double *M, *f;
  int *item; /* contact, joint, row or motor of each item */
  int *rows; /* contacts and joints */
  double *mu, *w, *r, *u, *compliance;
  double *guess;      /* r before it was solved */
  int *first, *block; /* first: items + 1 */
  double *value;
} nsdae_cone_arrays;

typedef struct nsdae_cone_island {
  nsdae_cone_arrays at;
  nsdae_friction_problem problem;
  nsdae_friction_options options; /* of the last solution */
  int items, contacts, motors, m;
  int *set;       /* f: enum motor_set of each joint */
  int driven;     /* a velocity is asked of a row, a joint or a contact */
  double slow;    /* velocities of contacts below it are none */
  double fastest; /* of the items without impulses and constraints; 0: not known */
  int *number;    /* of a block of the system: its number in the island */
  double *lever;  /* nv of the system: the largest entry of H along each velocity */
} nsdae_cone_island;

/* system: sizes; then room for contacts, for their values and those of rows of Phi_q. */
void nsdae_cone_island_layout(nsdae_cone_island *cones, const nsdae_system *system,
                              nsdae_arena *arena);
int nsdae_cone_island_grow(nsdae_cone_island *cones, const nsdae_system *system,
                           const nsdae_room *contacts, const nsdae_room *rows);
void nsdae_cone_island_release(nsdae_cone_island *cones);
/* Memory of the solver for all contacts and rows of a system of one block: NSDAE_OK or
 * NSDAE_E_MEMORY. */
int nsdae_cone_island_reserve(nsdae_cone_island *cones, const nsdae_system *system,
                              nsdae_friction_solver *solver);

/* What it is solved with, L has room for a block; info: of the solver; residual: its residual, not
 * scaled. */
typedef struct nsdae_cone_work {
  nsdae_friction_solver *solver;
  double *L;
  const nsdae_accuracy *accuracy;
  double tol; /* the tolerance that was asked for last */
  nsdae_error *error;
  nsdae_friction_info info;
  nsdae_natural_residual residual;
} nsdae_cone_work;

/* NSDAE_OK, NSDAE_E_MASS, NSDAE_E_LCP, NSDAE_E_INFEASIBLE, NSDAE_E_NONFINITE, NSDAE_E_MEMORY with
 * the record. */
int nsdae_cone_island_solve(nsdae_cone_island *cones, const nsdae_island_equations *whole,
                            int island, nsdae_cone_work *work);

/* ---- cone_velocities.c: v = M^-1 (f + H r) over the blocks of the island, and the sizes of the
 * terms of f + H r. L has room for the factor of a block. */

/* v := f; v += H r; v := M^-1 v, NSDAE_E_MASS if a mass is not positive definite. */
void nsdae_cone_begin_velocities(const nsdae_cone_island *c, const nsdae_island_equations *w);
void nsdae_cone_add_impulses(nsdae_cone_island *c, const nsdae_island_equations *w);
int nsdae_cone_solve_masses(const nsdae_cone_island *c, const nsdae_island_equations *w, double *L);
/* All three, and the levers. */
int nsdae_cone_form_velocities(nsdae_cone_island *c, const nsdae_island_equations *w, double *L);
/* The same, and zero for items at rest; speed: of the fastest item without impulses. */
int nsdae_cone_velocities(nsdae_cone_island *c, const nsdae_island_equations *w,
                          const nsdae_cone_work *work, double speed);

/* To tol by budget multiplications by J, from at.r; guess keeps from where. */
int nsdae_cone_solve_to(nsdae_cone_island *c, nsdae_cone_work *work, double tol, double budget);

/* ---- cone_rest.c: of several solutions the one at rest, and rest to rounding. After a solution
 * within its tolerance; a status. */

int nsdae_cone_prefer_rest(nsdae_cone_island *c, const nsdae_island_equations *w,
                           nsdae_cone_work *work, double budget);
int nsdae_cone_solve_rest(nsdae_cone_island *c, const nsdae_island_equations *w,
                          nsdae_cone_work *work, double budget);

#endif
