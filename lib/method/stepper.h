/* What the methods share to compute with. Nothing in it outlives a step but sizes and settings. */
#ifndef NSDAE_STEPPER_H
#define NSDAE_STEPPER_H

#include "exponential_map.h"
#include "newton_kkt.h"
#include "interrupt.h"
#include "kkt.h"
#include "method.h"
#include "system_impl.h"
#include "contact_problem.h"

/* Of the two ends of a step, as in the terms. */
typedef struct nsdae_means {
  double *M, *F;
} nsdae_means;

typedef struct nsdae_stepper {
  const nsdae_system *system;
  const nsdae_sim_options *options;
  nsdae_error *error;
  const nsdae_units *units;  /* of the run */
  nsdae_interrupt interrupt; /* asked before every step, and inside long ones */
  nsdae_counters *counters;  /* of the step in work */
  double iteration_tol;      /* the option, but above the rounding of derivatives by differences */
  nsdae_differences differences;
  nsdae_terms middle;
  nsdae_kkt kkt;           /* of event and penalty */
  nsdae_contacts contacts; /* settings, and the memory of their bases */
  nsdae_problem problem;   /* of time-stepping methods */
  nsdae_means mean;
  double *q, *v, *r; /* nq, nv, nv */
  double *v_other;   /* nv: a velocity in between */
  double *size;      /* nv: how large the terms of a velocity are */
  double *qdot[2];   /* nq: at both ends of a way */
  double *impulse;   /* m: Lambda of the bilateral constraints over the step */
  int *parent;       /* sets of blocks and the ground */
  double *rate;      /* m: rates of the bilateral constraints, then what is not asked for */
} nsdae_stepper;

/* A step in work, of a method that solves one contact problem for it. */
typedef struct nsdae_step {
  nsdae_stepper *tools;
  const nsdae_state *state;
  nsdae_terms *start, *end; /* of the state and the result */
  nsdae_result *result;
  double h, t_end; /* t_end is start.t + h up to rounding */
  int crosses;     /* a change point: 1, or -1 not; 0: not known */
} nsdae_step;

/* Sets sizes and settings, again after options or coefficients changed; then takes the arrays.
 * system, options and error are set before. */
void nsdae_stepper_prepare(nsdae_stepper *stepper);
void nsdae_stepper_layout(nsdae_stepper *stepper, nsdae_arena *arena);
/* The terms of a result belong to the same description. */
void nsdae_stepper_prepare_terms(nsdae_stepper *stepper, nsdae_terms *terms);

/* Why a method was not made, status: NSDAE_E_UNSUPPORTED without SUNDIALS, NSDAE_E_MEMORY; or
 * NSDAE_OK, and it was. */
int nsdae_stepper_made(const nsdae_stepper *stepper, int status, const char *method);

/* Prepares Newton's equations of an integrator at the point of the terms, uncounted. */
int nsdae_stepper_start(nsdae_stepper *stepper, nsdae_newton_kkt *newton, const nsdae_terms *at);

/* Where the evaluations of the step from state into result are counted; no list lacks room yet. */
void nsdae_stepper_count(nsdae_stepper *stepper, const nsdae_state *state, nsdae_result *result);

/* The memory of a method that keeps the bases of its contacts alone; them, which another problem
 * may have, too. */
void nsdae_stepper_lay(const nsdae_stepper *stepper, nsdae_memory_part *part);
int *nsdae_stepper_lay_basis(const nsdae_stepper *stepper, nsdae_memory_part *part);

/* The frame of such a method's advance; the end reads impulse and contacts into the result. */
static inline nsdae_step nsdae_step_begin(nsdae_stepper *stepper, const nsdae_state *state,
                                          double t_end, nsdae_result *result)
{
  nsdae_contacts_remember(&stepper->contacts, result->memory.whole);
  return (nsdae_step){.tools = stepper,
                      .state = state,
                      .start = state->terms,
                      .end = &result->end,
                      .result = result,
                      .h = state->length,
                      .t_end = t_end};
}
/* NSDAE_OK, or NSDAE_E_LCP if the laws have a residual above their tolerance that is not accepted.
 */
int nsdae_step_end(const nsdae_step *step);

/* The problem of the step (contact_problem.h), with what it did counted. update: at another point,
 * as far as closed contacts may have come apart. The terms named have what they need, except lists.
 */
int nsdae_step_close(const nsdae_step *step, nsdae_terms *terms);
int nsdae_step_update(const nsdae_step *step, nsdae_terms *terms);
/* Whether rows of Phi_q may depend on each other, and which do: at the start of the step, where the
 * constraints hold up to their drift. The islands are those of the terms named. */
int nsdae_step_judge_rank(const nsdae_step *step, const nsdae_terms *terms, int *redundant);
/* Whether the step may cross a change point, a pose in which rows become dependent and where two
 * branches of the motion meet: at the distance s from it a row bounds v_1 in a direction that turns
 * by the error of q_1 over s, and h v / 2 s of that is fed back to q_1. So if the smallest sine at
 * the start, or at q_0 + h v_0, is less than it changes in between, its rows are left out of this
 * step: v does not jump without an impulse, and the rows bound it again in a later step. 1 with the
 * rank judged at the start, 0, or a status. end is moved. */
int nsdae_step_cross(const nsdae_step *step);
/* v and the stepper's impulse from momentum r [nv] with the closed contacts of the terms' point:
 * M v + Phi_q^T Lambda = r + W Lambda_c,  Phi_q v = -Phi_t. lambda: impulses nearby, or NULL. */
int nsdae_step_impact(const nsdae_step *step, const nsdae_terms *terms, const double *M,
                      const double *r, const double *lambda, double *v);
/* The same of lambda that comes as the rates Phi_q v, also as if no contact were closed. */
int nsdae_step_solve(const nsdae_step *step, const nsdae_terms *terms, const double *M,
                     const double *r, int with_contacts, double *v, double *lambda);

/* The parts that methods share. */

/* Factors [M Phi_q^T; Phi_q 0] with the given M and Phi_q of the terms; counts the rank. */
int nsdae_stepper_factor(nsdae_stepper *stepper, nsdae_terms *terms, const double *M);

/* After each step of an integrator inside a dt: whether it may go on, from t towards t_end.
 * NSDAE_OK; NSDAE_E_CONVERGENCE past inner_steps_max, with the advice of the method; or the
 * interrupt's. */
int nsdae_stepper_goes_on(const nsdae_stepper *stepper, const char *method, const char *advice,
                          double t, double t_end);

/* r [nv] := M v + h F. */
void nsdae_stepper_momentum(const nsdae_blocks *blocks, const double *M, const double *v, double h,
                            const double *F, double *r);

#endif
