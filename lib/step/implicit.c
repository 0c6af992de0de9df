/* The implicit time-stepping: the scheme of Zhang, Gu and Sun (Eq. 34) iterated until the LCP is
 * solved with the matrices of the q_1 that it leads to. Closed contacts: g_N(q_0) <= 0.
 *
 *   M_h (v_1 - v_0) + J_h^T Lambda - W_h Lambda_c = h/2 (F_0 + F_1),   M_h = (M_0 + M_1) / 2
 *   J_1 v_1 + Phi_t = 0,   xi = W_1^T v_1 + w_1 + e v(-),   contact laws        (J = Phi_q)
 *   q_1 = q_0 + h/2 (v_0 + v_1);  quaternions move by the exponential map (exponential_map.h)
 *
 * Persisting reactions act along the mean of both ends, J_h = (J_0 + J_1)/2 and W_h likewise:
 * with J_1 alone the scheme is of first order only. Impulses of an impact act along J_1 and W_1,
 * the rows that bound v_1, and with v(-) = W_1^T v_p + w_1, where v_p is v_0 projected to
 * J_1 v_p + Phi_t = 0, they then do exactly the work of Newton's law: none at e = 1. Persisting
 * contacts take v(-) = W_0^T v_0 + w_0, which is zero to rounding, so that nothing is injected.
 *
 * A closed contact is an impact when it closes faster than the turning of its normal over the
 * step explains:  v(-) < -2 |W_N(q_0 + h v_0)^T v_0 + w_1 - v(-)| - impact_velocity.
 *
 * The matrix of the LCP is kept symmetric: (J_1 - J_h)^T Lambda - (W_1 - W_h) Lambda_c of the
 * iterate before goes to the right-hand side. The iteration ends when q_1 and v_1 are stationary.
 *
 * Contacts of a list may come and go between iterates, or their normals jump, as from face to edge.
 * Then no fixed point may exist. If the change of q_1 and v_1 has not been halved for STAGNATION
 * iterations, or is 1 and more for DIVERGED in turn, W_1 and w_1 remain those of the last iterate:
 * the map is continuous again. If it diverges with these, the attempt ends. */
#include <float.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "disjoint_sets.h"
#include "errors.h"
#include "exponential_map.h"
#include "stepper.h"
#include "vector.h"

/* Relative change at which a step with frozen contacts ends after iteration_max iterations: less
 * than the truncation error (omega h)^3 / 12 of the trapezoidal rule in a step of omega h > 0.05,
 * which is 125 steps in a period. A step whose forces are too stiff for dt changes by more than 1.
 */
static const double TRUNCATION = 1e-5;

/* A sine, of loops: what it changes by in a step of 0.25 rad. With 0.1 and steps of 2 ms 2 of 200
 * linkages of tests/system/change_points.c leave their branch, with 0.25 none. */
static const double NEARLY = 0.25;

/* In place of a status. */
enum { SINGULAR = 1 };

enum { STAGNATION = 10 }; /* a contraction by 0.93 and less is halved in fewer */

/* An iterate that has nothing in common with the one before, this often in turn: large impulses
 * that hold each other make (W_1 - W_h) Lambda_c larger than all else, and it grows by squares. */
enum { DIVERGED = 3 };

/* How the iteration goes. */
typedef struct progress {
  double moved, mark; /* relative change of q_1 and v_1; that at the last halving */
  int since, count;   /* iterations since then; in all */
  int apart;          /* those in turn with a change of 1 and more */
  int frozen;         /* W_1 and w_1 are those of an iterate before */
} progress;

enum {
  STEP_TERMS = NSDAE_TERM_MASS | NSDAE_TERM_FORCE | NSDAE_TERM_JACOBIAN | NSDAE_TERM_PHI_T,
  CLOSED_TERMS =
      NSDAE_TERM_NORMAL | NSDAE_TERM_TANGENT | NSDAE_TERM_BIAS | NSDAE_TERM_SLIDE | NSDAE_TERM_BOUND
};

static int need(const nsdae_step *step, nsdae_terms *terms, int frozen)
{
  int contacts = nsdae_problem_any(&step->tools->problem) && !frozen;
  int status = nsdae_terms_need(terms, contacts ? STEP_TERMS | CLOSED_TERMS : STEP_TERMS);
  return status < 0 || frozen ? status : nsdae_step_update(step, terms);
}

/* Marks the impacts; end is at q_0 + h v_0. Returns whether there is one. */
static int mark_impacts(const nsdae_step *step, int all)
{
  const nsdae_problem *p = &step->tools->problem;
  nsdae_impulses *r = &step->result->impulses;
  double slow = step->tools->options->impact_velocity;
  int any = 0;
  for (int a = 0; a < p->count; a++) {
    int i = p->number[a];
    double turned = nsdae_terms_normal_rate(step->end, i, step->start->v);
    r->impact[i] = all || r->before[i] < -2 * fabs(turned - r->before[i]) - slow;
    any |= r->impact[i];
  }
  return any;
}

/* v(-) of the impacts, from v_p: M_h v_p + J_1^T (.) = M_h v_0, J_1 v_p = -Phi_t. */
static int impact_velocities(const nsdae_step *step)
{
  nsdae_stepper *s = step->tools;
  nsdae_problem_mark_hit(&s->problem, step->end);
  memset(s->r, 0, (size_t)s->system->dims.nv * sizeof *s->r);
  nsdae_blocks_add_product(&s->system->blocks, s->mean.M, step->start->v, s->r);
  for (int i = 0; i < s->system->dims.m; i++) s->rate[i] = -step->end->constraint.phi_t[i];
  int status = nsdae_step_solve(step, step->end, s->mean.M, s->r, 0, s->v_other, s->rate);
  if (status == NSDAE_OK) nsdae_problem_before(&s->problem, step->end, s->v_other, 1);
  return status;
}

/* r = M_h v_0 + h/2 (F_0 + F_1) + (J_1 - J_0)^T Lambda / 2 - (W_1 - W_0) Lambda_c / 2, the last two
 * for what persists, with the impulses of the iterate before. */
static void right_hand_side(const nsdae_step *step, int impact)
{
  nsdae_stepper *s = step->tools;
  const nsdae_problem *p = &s->problem;
  const nsdae_terms *start = step->start, *end = step->end;
  for (int i = 0; i < s->system->dims.nv; i++) s->mean.F[i] = (start->F[i] + end->F[i]) / 2;
  nsdae_stepper_momentum(&s->system->blocks, s->mean.M, start->v, step->h, s->mean.F, s->r);
  if (s->system->dims.m > 0) {
    nsdae_problem_add_constraints(p, end, 0.5, impact, s->impulse, s->r);
    nsdae_problem_add_constraints(p, start, -0.5, impact, s->impulse, s->r);
  }
  if (!nsdae_problem_any(p)) return;
  nsdae_problem_no_linear(&s->problem);
  nsdae_problem_add_impulse(p, end, -0.5, 1, s->r);
  nsdae_problem_add_impulse(p, start, 0.5, 1, s->r);
}

static int factor_mean_mass(const nsdae_step *step, int redundant)
{
  nsdae_stepper *s = step->tools;
  size_t size = s->system->blocks.square[s->system->blocks.count];
  for (size_t i = 0; i < size; i++) s->mean.M[i] = (step->start->M[i] + step->end->M[i]) / 2;
  return nsdae_problem_factor(&step->tools->problem, step->end, redundant);
}

/* Moves end to s->q, s->v and solves there for the next s->q, s->v. */
static int iterate(const nsdae_step *step, int first, int frozen, int all_impacts, int *impact)
{
  nsdae_stepper *s = step->tools;
  const double *q_0 = step->start->q;
  int nq = s->system->dims.nq;
  nsdae_terms_at(step->end, step->t_end, s->q, s->v);
  int status = need(step, step->end, frozen);
  /* of redundant constraints as many are left out in all iterates as at the start, and the same if
   * they can: which these are is decided by rounding, and the iteration would go to and fro */
  if (status == NSDAE_OK)
    status = factor_mean_mass(step, step->crosses > 0 ||
                                        s->options->redundant == NSDAE_REDUNDANT_LEAST_NORM);
  if (status < 0) return status;
  if (first) *impact = mark_impacts(step, all_impacts);
  if (*impact) status = impact_velocities(step);
  if (status < 0) return status;
  right_hand_side(step, *impact);
  nsdae_problem_bound(&s->problem, step->h / 2, step->start, step->h / 2, step->end);
  status = nsdae_step_impact(step, step->end, s->mean.M, s->r, s->impulse, s->v);
  if (status < 0) return status;
  nsdae_problem_add_linear(&s->problem, step->end);
  /* q_1 of the rates H_0 v_0 and H_1 v_1 into s->q, of the velocity s->v; H_1 = H(q_1 of end) */
  status = nsdae_kinematics_at(step->end, s->v, s->qdot[1]);
  nsdae_units_mean_rate(s->units, nq, q_0, s->qdot[0], step->end->q, s->qdot[1]);
  nsdae_units_move(s->units, nq, q_0, step->h, s->qdot[1], s->q);
  return status;
}

/* The relative change below which the iteration ends: not less than the rounding of the terms of v,
 * as in contacts.c; those of stiff motors are larger than v.
 *
 * Far from the origin M, F, J and W have the error eps |q| of gaps and arms, and v_1 changes with
 * each rounding of q_1. An iteration that stagnates ends if the changes of v_1 move q_1 by less
 * than twice its rounding:  h/2 |dv| <= 2 eps |q|.
 *
 * With frozen contacts that still stagnate it is never less than the error that contact_tol leaves
 * in velocities, 1e2 contact_tol as in worker.c: the problem of an iterate may have several
 * solutions. */
static double settled(const nsdae_step *step, const progress *p)
{
  const nsdae_stepper *s = step->tools;
  const nsdae_dims *dims = &s->system->dims;
  double speed = 1 + nsdae_largest(dims->nv, s->v),
         rounding = 32 * DBL_EPSILON * nsdae_largest(dims->nv, s->size) / speed,
         noise = fmax(rounding, nsdae_larger(s->iteration_tol, s->problem.dispatch.solved->noise));
  if (p->since < STAGNATION) return noise;
  double moved = 4 * DBL_EPSILON * nsdae_largest(dims->nq, s->q) / (step->h * speed);
  return fmax(noise, fmax(moved, p->frozen ? 1e2 * s->problem.dispatch.solved->tol : 0));
}

/* The constraint with the largest |Phi| at the end of the step; -1: none. */
static int most_violated(const nsdae_step *step)
{
  const double *phi = step->end->constraint.phi;
  int worst = -1, m = step->tools->system->dims.m;
  if (nsdae_terms_need(step->end, NSDAE_TERM_PHI) < 0) return -1;
  for (int i = 0; i < m; i++)
    if (worst < 0 || fabs(phi[i]) > fabs(phi[worst])) worst = i;
  return worst;
}

static int no_convergence(const nsdae_step *step, const progress *p)
{
  const nsdae_stepper *s = step->tools;
  int violated = most_violated(step);
  char text[48] = "";
  if (violated >= 0)
    snprintf(text, sizeof text, "; largest violation %.3g",
             fabs(step->end->constraint.phi[violated]));
  if (p->since >= STAGNATION && p->moved <= TRUNCATION)
    nsdae_error_set(
        s->error, NSDAE_E_CONVERGENCE, "nsdae_implicit", "iteration_tol",
        "the step from t = %g did not converge in %d iterations, and stagnates at the change "
        "%.3g, wanted %.3g: make iteration_tol larger, if callbacks have noise of this size, or dt "
        "smaller%s",
        nsdae_terms_time(step->start), p->count, p->moved, settled(step, p), text);
  else
    nsdae_error_set(s->error, NSDAE_E_CONVERGENCE, "nsdae_implicit", "dt",
                    "the step from t = %g did not converge in %d iterations (change %.3g, wanted "
                    "%.3g): make dt smaller%s%s",
                    nsdae_terms_time(step->start), p->count, p->moved, settled(step, p),
                    p->apart < DIVERGED ? "" : ", and check force: it may have no bound", text);
  if (violated >= 0) nsdae_system_name_item(s->system, NSDAE_NAME_CONSTRAINT, violated, s->error);
  s->error->time = nsdae_terms_time(step->start);
  return NSDAE_E_CONVERGENCE;
}

/* If q_1 of the matrices is further from that of v_1 than by iteration_tol, end moves there: the
 * error of velocities that contact_tol leaves is none of q_1 = q_0 + h/2 (v_0 + v_1). */
static int end_iteration(const nsdae_step *step, const progress *p)
{
  nsdae_stepper *s = step->tools;
  int moves = p->moved > s->iteration_tol;
  step->result->counters.frozen = p->frozen;
  if (moves)
    nsdae_terms_at(step->end, step->t_end, s->q, s->v);
  else
    nsdae_terms_set_velocity(step->end, s->v);
  return moves || p->frozen ? need(step, step->end, 0) : NSDAE_OK;
}

/* Whether constraints close a loop of blocks: those of a tree are independent. Rows of a joint
 * follow each other. */
static int has_loop(const nsdae_step *step)
{
  const nsdae_rows *J = &step->end->by.jacobian;
  int *parent = step->tools->parent, ground = step->tools->system->blocks.count;
  nsdae_sets_begin(parent, ground + 1);
  for (int i = 0, last[2] = {-1, -1}; i < J->count; i++) {
    int parts = J->first[i + 1] - J->first[i];
    const int *block = J->block + J->first[i];
    int pair[2] = {parts > 0 ? block[0] : ground, parts > 1 ? block[1] : ground};
    if (parts > 2) return 1;
    if (pair[0] == last[0] && pair[1] == last[1]) continue;
    if (nsdae_sets_root(parent, pair[0]) == nsdae_sets_root(parent, pair[1])) return 1;
    nsdae_sets_join(parent, pair[0], pair[1]);
    memcpy(last, pair, sizeof last);
  }
  return 0;
}

/* Whether the constraints are nearly dependent at q_0 + h v_0. */
static int is_singular(const nsdae_step *step, int status)
{
  const nsdae_solved *solved = step->tools->problem.dispatch.solved;
  return step->tools->system->dims.m > 0 &&
         (status == NSDAE_E_RANK || (status == NSDAE_OK && solved->kept < NEARLY)) &&
         has_loop(step);
}

/* On return end is at q_1 with the velocity v_1. SINGULAR: it is to be seen whether the step
 * crosses a change point. */
static int attempt(const nsdae_step *step, int all_impacts)
{
  nsdae_stepper *s = step->tools;
  const nsdae_dims *dims = &s->system->dims;
  progress p = {.moved = INFINITY, .mark = INFINITY};
  int impact = 0;
  nsdae_problem_before(&s->problem, step->start, step->start->v, 0);
  int status = nsdae_problem_position(&s->problem, step->start, step->h, step->h / 2);
  if (status < 0) return status;
  nsdae_units_move(s->units, dims->nq, step->start->q, step->h, s->qdot[0], s->q);
  memcpy(s->v, step->start->v, (size_t)dims->nv * sizeof *s->v);
  memset(s->impulse, 0, (size_t)dims->m * sizeof *s->impulse);
  for (int i = 0; i < s->options->iteration_max; i++) {
    status = iterate(step, i == 0, p.frozen, all_impacts, &impact);
    if (i == 0 && step->crosses == 0 && is_singular(step, status)) return SINGULAR;
    if (status < 0) return status;
    step->result->counters.iterations++;
    p.moved = nsdae_relative_change(dims->nq, s->q, step->end->q) +
              nsdae_relative_change(dims->nv, s->v, step->end->v);
    p.since++;
    p.count++;
    p.apart = p.moved < 1 ? 0 : p.apart + 1;
    if (p.moved <= p.mark / 2) p.mark = p.moved, p.since = 0;
    if (p.moved <= settled(step, &p)) return end_iteration(step, &p);
    if (p.frozen && p.apart >= DIVERGED) break; /* or NaN */
    if (p.frozen || (p.since < STAGNATION && p.apart < DIVERGED) || s->problem.count == 0) continue;
    p.mark = p.moved, p.since = p.apart = 0, p.frozen = 1;
  }
  /* between solutions of the contact problem, which friction makes several */
  if (p.frozen && p.since >= STAGNATION && p.moved <= TRUNCATION) return end_iteration(step, &p);
  return no_convergence(step, &p);
}

static int worth_another_attempt(const nsdae_step *step, int status)
{
  return step->tools->problem.count > 0 &&
         (status == NSDAE_E_LCP || status == NSDAE_E_INFEASIBLE || status == NSDAE_E_CONVERGENCE);
}

/* Near a change point: no velocity jumps without an impulse, so that a change by half of v in a
 * step is another branch. */
static int check_jump(const nsdae_step *step)
{
  nsdae_stepper *s = step->tools;
  const nsdae_blocks *blocks = &s->system->blocks;
  const double part = 0.5, *from = step->start->v;
  for (int i = 0; i < s->system->dims.nv; i++) s->v_other[i] = s->v[i] - from[i];
  double jump = sqrt(nsdae_blocks_square(blocks, s->mean.M, s->v_other)),
         speed = sqrt(nsdae_blocks_square(blocks, s->mean.M, from)),
         t = nsdae_terms_time(step->start);
  int near = step->crosses > 0 || step->result->crossed.sine > 0;
  if (!near || !(jump > part * speed)) return NSDAE_OK;
  nsdae_error_set(
      s->error, NSDAE_E_CONVERGENCE, "nsdae_implicit", "dt",
      "at t = %g the velocity changes by %.3g of itself in a step near a change point of "
      "the constraints: this is another branch; make dt smaller, or use method = event",
      t, jump / speed);
  return nsdae_error_at(s->error, NSDAE_E_CONVERGENCE, -1, t);
}

/* The same, across a change point if there is one near. */
static int attempt_across(nsdae_step *step)
{
  nsdae_counters *counters = &step->result->counters;
  step->crosses = 0;
  int status = attempt(step, 0), rank = counters->rank_most;
  if (status != SINGULAR) return status;
  int crosses = nsdae_step_cross(step);
  if (crosses < 0) return crosses;
  step->crosses = crosses > 0 ? 1 : -1;
  const int *held = step->tools->problem.dispatch.factorisation.held;
  nsdae_crossed *crossed = &step->result->crossed;
  for (int i = 0; crosses > 0 && i < step->tools->system->dims.m && crossed->constraint < 0; i++)
    if (!held[i]) *crossed = (nsdae_crossed){i, step->t_end, 0};
  status = nsdae_step_close(step, step->start);
  if (status == NSDAE_OK) status = attempt(step, 0);
  if (crosses > 0) counters->rank = counters->rank_most = rank; /* of the poses beside it */
  if (status == NSDAE_OK && step->tools->problem.count == 0) status = check_jump(step);
  return status;
}

static int advance(void *own, const nsdae_state *state, double t_end, nsdae_result *result)
{
  nsdae_stepper *s = own;
  nsdae_terms *start = state->terms;
  nsdae_step step = nsdae_step_begin(s, state, t_end, result);
  int status = nsdae_terms_need(start, NSDAE_TERM_GAP);
  if (status == NSDAE_OK) status = nsdae_kinematics_at(start, start->v, s->qdot[0]);
  if (status < 0) return status;
  status = nsdae_step_close(&step, start);
  if (status == NSDAE_OK) status = need(&step, start, 0);
  int redundant;
  if (status == NSDAE_OK) status = nsdae_step_judge_rank(&step, start, &redundant);
  if (status == NSDAE_OK) status = attempt_across(&step);
  if (worth_another_attempt(&step, status)) {
    status = nsdae_step_close(&step, start);
    if (status == NSDAE_OK) status = attempt(&step, 1);
  }
  return status < 0 ? status : nsdae_step_end(&step);
}

const nsdae_stepping nsdae_stepping_implicit = {
    .name = "implicit",
    .summary = "the scheme iterated to the end of the step: second order between impacts",
    .lay = nsdae_stepper_lay,
    .advance = advance,
    .closes = 1};
