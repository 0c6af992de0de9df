/* The time-stepping of Zhang, Gu and Sun as it is printed (Fig. 1, Eq. 34). Without a closed
 * contact (g_N(q_0) > 0 for all) a step of Newmark's rule; otherwise the LCP with all terms at
 * (t_0, q_0, v_0) for Lambda and x, then, with dv = M(q_0)^-1 (h F - Phi_q^T Lambda + W Lambda_c),
 *
 *   v~  = v_0 + dv at q_0,   q_1 = q_0 + h/2 (v_0 + v~),   v_1 = v_0 + dv with Phi_q, W at q_1
 *
 * One pass, of first order; v_1 does not satisfy Phi_q(q_1) v_1 + Phi_t = 0. */
#include <float.h>
#include <math.h>
#include <string.h>

#include "errors.h"
#include "exponential_map.h"
#include "stepper.h"
#include "vector.h"

enum {
  CONTACT_TERMS = NSDAE_TERM_MASS | NSDAE_TERM_FORCE | NSDAE_TERM_JACOBIAN | NSDAE_TERM_PHI_T |
                  NSDAE_TERM_NORMAL | NSDAE_TERM_TANGENT | NSDAE_TERM_BIAS | NSDAE_TERM_SLIDE |
                  NSDAE_TERM_BOUND,
  SMOOTH_TERMS = NSDAE_TERM_MASS | NSDAE_TERM_FORCE | NSDAE_TERM_PHI | NSDAE_TERM_JACOBIAN |
                 NSDAE_TERM_PHI_T | NSDAE_TERM_OMEGA,
  END_TERMS = NSDAE_TERM_JACOBIAN | NSDAE_TERM_NORMAL | NSDAE_TERM_TANGENT | NSDAE_TERM_SLIDE
};

/* Beside the contacts' warm start: a and lambda of the end of a smooth step, and whether they are
 * there. */
static void lay(const nsdae_stepper *s, nsdae_memory_part *part)
{
  nsdae_stepper_lay(s, part);
  nsdae_memory_reals(part, NSDAE_OF_ALL((size_t)s->system->dims.nv + (size_t)s->system->dims.m));
  nsdae_memory_wholes(part, NSDAE_OF_ALL(1));
}

static void jump(void *own, nsdae_memory *memory)
{
  (void)own;
  memory->whole[memory->wholes - 1] = 0;
}

/* ---- Newmark's rule
 *
 * gamma = 1/2, beta = 1/4 on the index-1 form with Baumgarte's stabilisation, Eq. (6):
 *
 *   [ M      Phi_q^T ] [ a      ]   [ F                                                    ]
 *   [ Phi_q  0       ] [ lambda ] = [ -omega - 2 alpha (Phi_q v + Phi_t) - beta^2 Phi      ]
 *   q1 = q0 + h v0 + h^2/4 (a0 + a1),   v1 = v0 + h/2 (a0 + a1)
 *
 * of second order, solved for a1 by fixed-point iteration. If dq/dt = H(q) v, q1 takes the mean
 * of H v at both ends. */

/* a and lambda at the terms' point. The stabilisation is stiff: with s = alpha h + beta^2 h^2/4,
 * the share of a in 2 alpha Phi' + beta^2 Phi, the right-hand side R of Phi_q a = R is replaced
 * by (R + s Phi_q a_last) / (1 + s). It has the same solution, and alpha and beta no longer
 * bound h. a holds a_last on entry where s > 0. */
static int acceleration(const nsdae_step *step, nsdae_terms *T, double s, double *a, double *lambda)
{
  const nsdae_system *system = T->system;
  const nsdae_blocks *blocks = &system->blocks;
  const nsdae_sim_options *o = step->tools->options;
  double alpha = o->baumgarte_alpha, beta = o->baumgarte_beta;
  int status = nsdae_terms_need(T, SMOOTH_TERMS);
  for (int i = 0; i < system->dims.m && status == NSDAE_OK; i++) {
    double rate = nsdae_terms_constraint_rate(T, i, T->v);
    double last = nsdae_rows_dot(blocks, &T->by.jacobian, i, a);
    double target = -T->constraint.omega[i] - 2 * alpha * rate - beta * beta * T->constraint.phi[i];
    lambda[i] = s > 0 ? (target + s * last) / (1 + s) : target;
  }
  if (status == NSDAE_OK) status = nsdae_problem_factor(&step->tools->problem, T, 0);
  return status < 0 ? status : nsdae_step_solve(step, T, T->M, T->F, 0, a, lambda);
}

/* Iterates on a1 from a0; the terms of the last iterate are those of the end. */
static int iterate(const nsdae_step *step, const double *a0, double *a1, double *lambda1)
{
  nsdae_stepper *s = step->tools;
  const nsdae_terms *start = step->start;
  nsdae_terms *end = step->end;
  const nsdae_dims *dims = &s->system->dims;
  const nsdae_sim_options *o = s->options;
  double alpha = o->baumgarte_alpha, beta = o->baumgarte_beta, h = step->h;
  double share = alpha * h + beta * beta * h * h / 4, moved = INFINITY;
  for (int i = 0; i < o->iteration_max; i++) {
    step->result->counters.iterations++;
    /* q1 and v1 of a0 and a1. With dq/dt = H v the positions take the mean of both ends, that of q1
     * at a point near it; for H = 1 that is h v0 + h^2/4 (a0 + a1). */
    for (int j = 0; j < dims->nv; j++) s->v[j] = start->v[j] + h / 2 * (a0[j] + a1[j]);
    const nsdae_terms *near = i == 0 ? start : end;
    int status = nsdae_kinematics_at(near, s->v, s->qdot[1]);
    nsdae_units_mean_rate(s->units, dims->nq, start->q, s->qdot[0], near->q, s->qdot[1]);
    nsdae_units_move(s->units, dims->nq, start->q, h, s->qdot[1], s->q);
    if (status < 0) return status;
    if (i > 0)
      moved = nsdae_relative_change(dims->nq, s->q, end->q) +
              nsdae_relative_change(dims->nv, s->v, end->v);
    if (moved <= s->iteration_tol) return NSDAE_OK;
    nsdae_terms_at(end, step->t_end, s->q, s->v);
    status = acceleration(step, end, share, a1, lambda1);
    if (status < 0) return status;
  }
  nsdae_error_set(s->error, NSDAE_E_CONVERGENCE, "nsdae_newmark", "dt",
                  "the smooth step from t = %g did not converge in %d iterations (change %.3g, "
                  "wanted %.3g): make dt smaller",
                  nsdae_terms_time(start), o->iteration_max, moved, s->iteration_tol);
  return nsdae_error_at(s->error, NSDAE_E_CONVERGENCE, -1, nsdae_terms_time(start));
}

static int smooth_step(const nsdae_step *step)
{
  nsdae_stepper *s = step->tools;
  nsdae_memory *memory = &step->result->memory;
  const nsdae_dims *dims = &s->system->dims;
  double *a0 = memory->real, *lambda0 = a0 + dims->nv, *a1 = s->v_other, *lambda1 = s->impulse;
  int *have_start = &memory->whole[memory->wholes - 1];
  step->result->smooth = 1;
  int status = nsdae_kinematics_at(step->start, step->start->v, s->qdot[0]);
  if (status == NSDAE_OK && !*have_start) status = acceleration(step, step->start, 0, a0, lambda0);
  if (status < 0) return status;
  memcpy(a1, a0, (size_t)dims->nv * sizeof *a1);
  status = iterate(step, a0, a1, lambda1);
  if (status < 0) return status;
  for (int i = 0; i < dims->m; i++) step->result->multiplier[i] = (lambda0[i] + lambda1[i]) / 2;
  memcpy(a0, a1, (size_t)dims->nv * sizeof *a0);
  memcpy(lambda0, lambda1, (size_t)dims->m * sizeof *lambda0);
  *have_start = 1;
  return NSDAE_OK;
}

/* ---- a step with contacts */

/* Lambda and x at the start, v~ into s->v. */
static int solve_at_start(const nsdae_step *step)
{
  nsdae_stepper *s = step->tools;
  nsdae_terms *start = step->start;
  int status = nsdae_terms_need(start, CONTACT_TERMS);
  if (status == NSDAE_OK) status = nsdae_problem_factor(&step->tools->problem, start, 0);
  if (status < 0) return status;
  nsdae_problem_before(&s->problem, start, start->v, 0);
  nsdae_problem_bound(&s->problem, step->h, start, 0, start);
  status = nsdae_problem_position(&s->problem, start, step->h, step->h / 2);
  if (status < 0) return status;
  nsdae_stepper_momentum(&s->system->blocks, start->M, start->v, step->h, start->F, s->r);
  return nsdae_step_impact(step, start, start->M, s->r, NULL, s->v);
}

static int positions(const nsdae_step *step)
{
  nsdae_stepper *s = step->tools;
  const nsdae_terms *start = step->start;
  const nsdae_dims *dims = &s->system->dims;
  for (int i = 0; i < dims->nv; i++) s->v_other[i] = (start->v[i] + s->v[i]) / 2;
  int status = nsdae_kinematics_at(start, s->v_other, s->qdot[0]);
  nsdae_units_move(s->units, dims->nq, start->q, step->h, s->qdot[0], s->q);
  nsdae_terms_at(step->end, step->t_end, s->q, s->v);
  if (status == NSDAE_OK) status = nsdae_terms_need(step->end, END_TERMS);
  return status < 0 ? status : nsdae_step_update(step, step->end);
}

/* v_1 = M(q_0)^-1 (M v_0 + h F - Phi_q(q_1)^T Lambda + W(q_1) Lambda_c); s->r holds M v_0 + h F. */
static int velocity_at_end(const nsdae_step *step)
{
  nsdae_stepper *s = step->tools;
  nsdae_problem_add_constraints(&s->problem, step->end, -1, 0, s->impulse, s->r);
  nsdae_problem_add_impulse(&s->problem, step->end, 1, 0, s->r);
  int status = nsdae_island_dispatch_solve_mass(&s->problem.dispatch, step->start, s->r);
  /* where the matrices did not change, v_1 is v~ and not its rounding: a body at rest stays at rest
   */
  for (int i = 0; i < s->system->dims.nv; i++)
    if (fabs(s->r[i] - s->v[i]) <= 64 * DBL_EPSILON * (fabs(s->size[i]) + fabs(s->v[i])))
      s->r[i] = s->v[i];
  nsdae_terms_set_velocity(step->end, s->r);
  return status;
}

static int contact_step(const nsdae_step *step)
{
  nsdae_memory *memory = &step->result->memory;
  memory->whole[memory->wholes - 1] = 0;
  int status = solve_at_start(step);
  if (status == NSDAE_OK) status = positions(step);
  if (status < 0) return status;
  status = velocity_at_end(step);
  return status < 0 ? status : nsdae_step_end(step);
}

static int advance(void *own, const nsdae_state *state, double t_end, nsdae_result *result)
{
  nsdae_stepper *s = own;
  const nsdae_step step = nsdae_step_begin(s, state, t_end, result);
  int status = nsdae_terms_need(step.start, NSDAE_TERM_GAP);
  if (status == NSDAE_OK) status = nsdae_step_close(&step, step.start);
  if (status < 0) return status;
  return nsdae_problem_any(&s->problem) ? contact_step(&step) : smooth_step(&step);
}

const nsdae_stepping nsdae_stepping_printed = {
    .name = "implicit-printed",
    .summary = "the source paper's one-pass scheme, letter for letter: first order",
    .lay = lay,
    .jump = jump,
    .advance = advance,
    .closes = 1};
