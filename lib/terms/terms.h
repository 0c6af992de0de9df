/* The terms of the equations at one point (t, q, v), each evaluated when it is first needed and
 * only once per point. */
#ifndef NSDAE_TERMS_H
#define NSDAE_TERMS_H

#include <nsdae/system.h>

#include "arena.h"
#include "differences.h"
#include "kkt.h"
#include "lists.h"
#include "system_impl.h"
#include "vector.h"

/* What can be asked for, as a sum. */
enum {
  NSDAE_TERM_MASS = 1,
  NSDAE_TERM_FORCE = 2, /* depends on v */
  NSDAE_TERM_PHI = 4,
  NSDAE_TERM_JACOBIAN = 8,
  NSDAE_TERM_PHI_T = 16,
  NSDAE_TERM_OMEGA = 32, /* depends on v */
  NSDAE_TERM_GAP = 64,
  NSDAE_TERM_NORMAL = 128,
  NSDAE_TERM_TANGENT = 256,
  NSDAE_TERM_BIAS = 512, /* w_N, w_T */
  NSDAE_TERM_POTENTIAL = 1024,
  NSDAE_TERM_SLIDE = 2048,        /* W and w of the frictional joints */
  NSDAE_TERM_ACCELERATION = 4096, /* omega of contacts and frictional joints; depends on v */
  NSDAE_TERM_CONTACTS = 8192,     /* the list, see nsdae_terms_contacts */
  NSDAE_TERM_BOUND = 16384        /* of the frictional joints; depends on v */
};

/* By rows over blocks: those of a dense array, Phi_q [m x nv], W_N [nv x k], W_T [nv x k nt] and W
 * of the frictional joints [nv x f], or those of a list (listed.h). A row of an array has a part
 * for each block in which it is not zero; a system without blocks has one part for all of v. */
typedef struct nsdae_by_blocks {
  nsdae_rows jacobian;             /* m */
  nsdae_rows normal, tangent;      /* k, k nt; by list: of the contacts that the step selected */
  nsdae_rows frictional_joint;     /* f */
  nsdae_row_list rows, joint_rows; /* what fills jacobian, frictional_joint */
  nsdae_contact_list list;
  double reach; /* of the list */
  double *work; /* nv */
  int *place;   /* k: the entry of the list that is in each slot; -1: none */
} nsdae_by_blocks;

typedef struct nsdae_evals {
  long mass, force, jacobian;
} nsdae_evals;

/* Of the bilateral constraints. */
typedef struct nsdae_constraint_terms {
  double *phi;           /* m */
  double *phi_t, *omega; /* m */
} nsdae_constraint_terms;

/* What the contacts' rates have beside W^T v': of N and T. */
typedef struct nsdae_contact_turns {
  double *N, *T; /* k, k nt */
} nsdae_contact_turns;

/* Of the frictional joints. */
typedef struct nsdae_slide_terms {
  double *w, *omega; /* f */
  double *bound;     /* f: |F_S| <= bound + mu |lambda| */
} nsdae_slide_terms;

typedef struct nsdae_terms {
  const nsdae_system *system;
  nsdae_differences *differences;
  nsdae_error *error;
  nsdae_evals *evals;
  unsigned have;   /* the terms that are up to date, */
  unsigned absent; /* and those among them that the system has none of */
  double t, *q, *v;
  double *M; /* nv x nv, its blocks one after another */
  double *F; /* nv */
  nsdae_constraint_terms constraint;
  double *gap;       /* k */
  double *w_N, *w_T; /* k, k nt */
  nsdae_contact_turns omega;
  nsdae_slide_terms frictional_joint;
  double potential;
  nsdae_by_blocks by;
} nsdae_terms;

/* Takes the arrays; system, differences, error and evals are set before. */
void nsdae_terms_layout(nsdae_terms *terms, nsdae_arena *arena);
/* Rows of a dense array over the blocks: begin is how far apart they are, stride the same of the
 * values of one. Of one block each has one part. */
void nsdae_terms_layout_rows(nsdae_rows *rows, const nsdae_blocks *blocks, long count, long begin,
                             long stride, nsdae_arena *arena);

/* Every term is out of date, except those that there are none of. */
static inline void nsdae_terms_forget(nsdae_terms *terms)
{
  terms->have = terms->absent;
}

/* The user's time of the point. */
static inline double nsdae_terms_time(const nsdae_terms *terms)
{
  return nsdae_system_time(terms->system, terms->t);
}

/* Moves to a new point. */
void nsdae_terms_at(nsdae_terms *terms, double t, const double *q, const double *v);
/* Changes v alone: what depends on q only stays. */
void nsdae_terms_set_velocity(nsdae_terms *terms, const double *v);

/* Brings the terms of the sum up to date. NSDAE_OK, NSDAE_E_CALLBACK, NSDAE_E_NONFINITE; a term
 * that failed is not counted as there. */
int nsdae_terms_evaluate(nsdae_terms *terms, unsigned which);
static inline int nsdae_terms_need(nsdae_terms *terms, unsigned which)
{
  return (which & ~terms->have) == 0 ? NSDAE_OK : nsdae_terms_evaluate(terms, which);
}

/* The status of a callback's code and output [rows x columns] at the point, with the record. */
int nsdae_terms_outcome(const nsdae_terms *terms, int code, const char *callback, const double *a,
                        int rows, int columns);

/* Compares both triangles of M, which must be there: only the lower one is factored. Entries are
 * sums of products, m_b J_bi J_bj over the bodies b, and sum |m_b J_bi J_bj| <= sqrt(M_ii M_jj) by
 * Cauchy and Schwarz: however they are summed, p roundings make them differ by at most p eps of
 * that. With p = 10^4, NSDAE_E_MASS names the first two that differ by more. */
int nsdae_terms_symmetric(const nsdae_terms *terms);

/* NSDAE_OK, or NSDAE_E_NONFINITE with the record, where `what`, one for each of a kind (enum
 * nsdae_name_kind), computed at the point, is not finite. */
int nsdae_terms_finite(const nsdae_terms *terms, const char *what, int kind, const double *a);

/* W_i^T v + w_i: the velocity along row i of those by blocks, or with omega in place of w and an
 * acceleration in place of v, its rate. */
static inline double nsdae_terms_rate(const nsdae_terms *T, const nsdae_rows *rows, const double *w,
                                      int i, const double *v)
{
  return nsdae_rows_add_dot(&T->system->blocks, rows, i, v, w[i]);
}

/* Of the normal of contact i, tangent i, frictional joint i; d Phi_i / dt = (Phi_q v)_i + Phi_t. */
static inline double nsdae_terms_normal_rate(const nsdae_terms *T, int i, const double *v)
{
  return nsdae_terms_rate(T, &T->by.normal, T->w_N, i, v);
}

static inline double nsdae_terms_tangent_rate(const nsdae_terms *T, int i, const double *v)
{
  return nsdae_terms_rate(T, &T->by.tangent, T->w_T, i, v);
}

/* Normal and tangential velocities of contact i, into their places in all. */
static inline void nsdae_terms_contact_rates(const nsdae_terms *T, int i, const double *v,
                                             double *normal, double *tangential)
{
  int nt = T->system->dims.nt;
  normal[i] = nsdae_terms_normal_rate(T, i, v);
  for (int j = i * nt; j < (i + 1) * nt; j++) tangential[j] = nsdae_terms_tangent_rate(T, j, v);
}

static inline double nsdae_terms_slide_rate(const nsdae_terms *T, int i, const double *v)
{
  return nsdae_terms_rate(T, &T->by.frictional_joint, T->frictional_joint.w, i, v);
}

/* sum W_l^2 / M_ll of row i: W^T M^-1 W of a diagonal M; 1 of a row of zeros. */
double nsdae_terms_mobility(const nsdae_terms *terms, const double *M, const nsdae_rows *rows,
                            int i);

/* radius |lambda| of the friction circle of joint j. */
static inline double nsdae_terms_circle(const nsdae_system *s, int j, const double *lambda)
{
  const nsdae_frictional_joint *joint = &s->frictional_joint[j];
  return joint->rows > 0 ? joint->radius * nsdae_norm(joint->rows, lambda + joint->first) : 0;
}

/* Friction circles by substitution: lambda of the bounds b, then b = own + radius |lambda|, until
 * no bound changes by more than `part` of itself, or by rounding of forces of this size. It
 * contracts by radius |d lambda / d F_S|. A joint that sticks within both bounds may have either:
 * where lambda is not unique, as of several that stick in a loop, it differs from round to round.
 *
 *   do status = solve(bound, lambda); while (nsdae_circles_again(&circles, lambda, &status)); */
typedef struct nsdae_circles {
  const nsdae_terms *terms;
  const double *own; /* f, or NULL: 0 */
  double part, size;
  double *bound; /* f */
  int rounds;
  const double *friction; /* f: F_S of the solution; NULL: all slide */
} nsdae_circles;

/* An impulse or force is at a bound from this part of it on: 1e-6 is far above rounding. */
#define NSDAE_AT_BOUND    (1 - 1e-6)
#define NSDAE_CIRCLE_PART 1e-13

/* bound := own, and the circles of a lambda nearby, NULL: none. */
nsdae_circles nsdae_circles_begin(const nsdae_terms *terms, const double *own, const double *lambda,
                                  double part, double size, double *bound);
/* Whether lambda is due again. NSDAE_E_CONVERGENCE with the record after too many rounds. */
int nsdae_circles_again(nsdae_circles *circles, const double *lambda, int *status);

/* bound + mu |lambda| + radius |lambda| of frictional joint j; lambda [m]. */
static inline double nsdae_terms_friction_limit(const nsdae_terms *T, int j, const double *lambda)
{
  const nsdae_frictional_joint *joint = &T->system->frictional_joint[j];
  double load = joint->mu > 0 ? joint->mu * fabs(lambda[joint->constraint]) : 0;
  return T->frictional_joint.bound[j] + load + nsdae_terms_circle(T->system, j, lambda);
}

static inline double nsdae_terms_constraint_rate(const nsdae_terms *T, int i, const double *v)
{
  return nsdae_terms_rate(T, &T->by.jacobian, T->constraint.phi_t, i, v);
}

/* linear [3] += the share W_N L_N + W_T L_T [nt] of contact i in the first velocities of the last
 * block that it touches: of bodies the linear impulse or the force on that of the larger number, in
 * the axes of space. */
void nsdae_terms_add_linear(const nsdae_terms *T, int i, double share, double normal,
                            const double *tangential, double *linear);
/* The same of all contacts [k] with a force, if the system is of bodies. */
void nsdae_terms_add_all_linear(const nsdae_terms *T, const double *normal,
                                const double *tangential, double *linear);

/* |W_T^T v + w_T| of contact i */
static inline double nsdae_terms_slip(const nsdae_terms *T, int i, const double *v)
{
  int nt = T->system->dims.nt;
  double slip = 0;
  for (int j = i * nt; j < (i + 1) * nt; j++) slip = hypot(slip, nsdae_terms_tangent_rate(T, j, v));
  return slip;
}

/* dq/dt = H v of a velocity at the point; NSDAE_OK, NSDAE_E_CALLBACK, NSDAE_E_NONFINITE. */
int nsdae_kinematics_at(const nsdae_terms *terms, const double *v, double *qdot);

/* T = v^T M v / 2 of a velocity [nv]; the mass matrix must be there. */
static inline double nsdae_terms_energy(const nsdae_terms *terms, const double *v)
{
  return nsdae_blocks_square(&terms->system->blocks, terms->M, v) / 2;
}

/* A gap below this touches: gaps are made of coordinates and constants, and a few roundings of
 * those are all that it says, 8 eps (1 + max |q|). */
double nsdae_terms_touch(const nsdae_terms *terms);

/* Records of what failed at the point, in a part of the system that the text names, "" in all. Each
 * returns its status: a pivot, from 1, of n velocities, which is that velocity's; the equations of
 * m constraints; their rank, with the first of those that are left when the independent ones are
 * taken, best first. */
int nsdae_terms_bad_mass(const nsdae_terms *terms, nsdae_error *error, const char *of, int pivot,
                         int n, int velocity);
int nsdae_terms_bad_equations(const nsdae_terms *terms, nsdae_error *error, const char *in, int m,
                              int status);
int nsdae_terms_bad_rank(const nsdae_terms *terms, nsdae_error *error, const char *in, int rank,
                         int m, int dependent);

/* The record of a status of nsdae_kkt_factor or nsdae_kkt_solve at the point, which is returned. */
int nsdae_terms_unsolved(const nsdae_terms *terms, const nsdae_kkt *kkt, int status);

/* nsdae_kkt_solve with the record. */
static inline int nsdae_terms_solve(const nsdae_terms *terms, const nsdae_kkt *kkt, int nrhs,
                                    double *R, double *C)
{
  int status = nsdae_kkt_solve(kkt, nrhs, R, kkt->n, C, kkt->m);
  return status < 0 ? nsdae_terms_unsolved(terms, kkt, status) : status;
}

/* Factors M and Phi_q (M may be another than that of the point, by blocks as that). A status of
 * nsdae_kkt_factor, and NSDAE_E_RANK unless least_norm allows a deficient rank, with the record. */
int nsdae_terms_factor(nsdae_terms *terms, const double *M, nsdae_kkt *kkt, int least_norm);

#endif
