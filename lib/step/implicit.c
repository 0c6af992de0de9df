/* The implicit time-stepping: the scheme of Zhang, Gu and Sun (Eq. 34) iterated until the LCP is
 * solved with the matrices of the q_1 that it leads to. Closed contacts: g_N(q_0) <= 0.
 *
 *   M_h (v_1 - v_0) + J_h^T Lambda - W_h Lambda_c = h/2 (F_0 + F_1),   M_h = (M_0 + M_1) / 2
 *   J_1 v_1 + Phi_t = 0,   xi = W_1^T v_1 + w_1 + e v(-),   contact laws        (J = Phi_q)
 *   q_1 = q_0 + h/2 (v_0 + v_1)
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
 */
#include <math.h>
#include <string.h>

#include "errors.h"
#include "stepper.h"
#include "vector.h"

enum {
  STEP_TERMS = NSDAE_TERM_MASS | NSDAE_TERM_FORCE | NSDAE_TERM_JACOBIAN | NSDAE_TERM_PHI_T,
  CLOSED_TERMS = NSDAE_TERM_NORMAL | NSDAE_TERM_TANGENT | NSDAE_TERM_BIAS | NSDAE_TERM_SLIDE
};

static int need(const nsdae_stepper *s, nsdae_terms *terms)
{
  return nsdae_terms_need(terms, nsdae_contacts_any(&s->contacts) ? STEP_TERMS | CLOSED_TERMS
                                                                  : STEP_TERMS);
}

/* Marks the impacts; end is at q_0 + h v_0. Returns whether there is one. */
static int mark_impacts(nsdae_stepper *s, int all)
{
  nsdae_contacts *c = &s->contacts;
  const nsdae_terms *end = &s->end;
  int nv = s->system->dims.nv, any = 0;
  for (int a = 0; a < c->active_count; a++) {
    int i = c->active[a];
    const double *W = end->W_N + (size_t)i * (size_t)nv;
    double turning = fabs(nsdae_dot(nv, W, s->start.v) + end->w_N[i] - c->before[i]);
    c->impact[i] = all || c->before[i] < -2 * turning - s->options->impact_velocity;
    any |= c->impact[i];
  }
  return any;
}

/* v(-) of the impacts, from v_p: M_h v_p + J_1^T (.) = M_h v_0, J_1 v_p = -Phi_t. */
static void impact_velocities(nsdae_stepper *s)
{
  int n = s->system->dims.nv, m = s->system->dims.m;
  double *v_p = s->last, *ignored = s->multiplier;
  for (int i = 0; i < n; i++) v_p[i] = 0;
  nsdae_add_product(n, n, s->M, s->start.v, v_p);
  for (int i = 0; i < m; i++) ignored[i] = -s->end.phi_t[i];
  nsdae_kkt_solve(&s->kkt, 1, v_p, n, ignored, m);
  nsdae_contacts_before(&s->contacts, &s->end, v_p, 1);
}

/* r = M_h v_0 + h/2 (F_0 + F_1) + (J_1 - J_0)^T Lambda / 2 - (W_1 - W_0) Lambda_c / 2, the last two
 * for what persists, with the impulses of the iterate before. */
static void right_hand_side(nsdae_stepper *s, double h, int impact)
{
  const nsdae_dims *dims = &s->system->dims;
  double *F = s->last;
  for (int i = 0; i < dims->nv; i++) F[i] = (s->start.F[i] + s->end.F[i]) / 2;
  nsdae_stepper_momentum(s->M, s->start.v, h, F, dims->nv, s->r);
  if (!impact) {
    nsdae_add_transposed(dims->m, dims->nv, 0.5, s->end.J, s->impulse, s->r);
    nsdae_add_transposed(dims->m, dims->nv, -0.5, s->start.J, s->impulse, s->r);
  }
  nsdae_contacts_add_impulse(&s->contacts, &s->end, -0.5, 1, s->r);
  nsdae_contacts_add_impulse(&s->contacts, &s->start, 0.5, 1, s->r);
}

static int factor_mean_mass(nsdae_stepper *s)
{
  int size = s->system->dims.nv * s->system->dims.nv;
  for (int i = 0; i < size; i++) s->M[i] = (s->start.M[i] + s->end.M[i]) / 2;
  return nsdae_stepper_factor(s, &s->end, s->M);
}

/* q_1 = q_0 + h/2 (H_0 v_0 + H_1 v_1) into s->q, of the velocity s->v; H_1 = H(q_1 of end). */
static int positions(nsdae_stepper *s, double h)
{
  const nsdae_terms *end = &s->end;
  int status = nsdae_stepper_kinematics(s, end->t, end->q, s->v, s->qdot1);
  for (int i = 0; i < s->system->dims.nq; i++)
    s->q[i] = s->start.q[i] + h / 2 * (s->qdot0[i] + s->qdot1[i]);
  return status;
}

/* Moves end to s->q, s->v and solves there for the next s->q, s->v. */
static int iterate(nsdae_stepper *s, double h, int first, int all_impacts, int *impact)
{
  nsdae_terms_at(&s->end, s->t_end, s->q, s->v);
  int status = need(s, &s->end);
  if (status == NSDAE_OK) status = factor_mean_mass(s);
  if (status < 0) return status;
  if (first) *impact = mark_impacts(s, all_impacts);
  if (*impact) impact_velocities(s);
  right_hand_side(s, h, *impact);
  status = nsdae_stepper_impact(s, &s->end, s->r, s->v);
  return status < 0 ? status : positions(s, h);
}

static int no_convergence(nsdae_stepper *s, double moved)
{
  const nsdae_sim_options *o = s->options;
  nsdae_error_set(s->error, NSDAE_E_CONVERGENCE, "nsdae_implicit", "dt",
                  "the step from t = %.17g did not converge in %d iterations (change %.3g, wanted "
                  "%.3g): make dt smaller",
                  s->start.t, o->iteration_max, moved, s->iteration_tol);
  s->error->time = s->start.t;
  return NSDAE_E_CONVERGENCE;
}

static void first_guess(nsdae_stepper *s, double h)
{
  const nsdae_dims *dims = &s->system->dims;
  for (int i = 0; i < dims->nq; i++) s->q[i] = s->start.q[i] + h * s->qdot0[i];
  memcpy(s->v, s->start.v, (size_t)dims->nv * sizeof *s->v);
  memset(s->impulse, 0, (size_t)dims->m * sizeof *s->impulse);
}

/* On return end is where the matrices of the solution were taken, with the velocity v_1. */
static int attempt(nsdae_stepper *s, double h, int all_impacts)
{
  const nsdae_dims *dims = &s->system->dims;
  double moved = INFINITY;
  int impact = 0;
  nsdae_contacts_close(&s->contacts, &s->start);
  nsdae_contacts_before(&s->contacts, &s->start, s->start.v, 0);
  first_guess(s, h);
  for (int i = 0; i < s->options->iteration_max; i++) {
    int status = iterate(s, h, i == 0, all_impacts, &impact);
    if (status < 0) return status;
    s->iterations++;
    moved = nsdae_relative_change(dims->nq, s->q, s->end.q) +
            nsdae_relative_change(dims->nv, s->v, s->end.v);
    if (!(moved <= s->iteration_tol)) continue; /* NaN goes on, to be reported */
    nsdae_terms_set_velocity(&s->end, s->v);
    return NSDAE_OK;
  }
  return no_convergence(s, moved);
}

static int worth_another_attempt(const nsdae_stepper *s, int status)
{
  return s->contacts.active_count > 0 &&
         (status == NSDAE_E_LCP || status == NSDAE_E_INFEASIBLE || status == NSDAE_E_CONVERGENCE);
}

static int advance(nsdae_stepper *s, double h)
{
  nsdae_terms *start = &s->start;
  int status = nsdae_terms_need(start, NSDAE_TERM_GAP);
  if (status == NSDAE_OK)
    status = nsdae_stepper_kinematics(s, start->t, start->q, start->v, s->qdot0);
  if (status < 0) return status;
  nsdae_contacts_close(&s->contacts, start);
  status = need(s, start);
  if (status == NSDAE_OK) status = attempt(s, h, 0);
  if (worth_another_attempt(s, status)) status = attempt(s, h, 1);
  if (status < 0) return status;
  for (int i = 0; i < s->system->dims.m; i++) s->multiplier[i] = s->impulse[i] / h;
  s->smooth = !nsdae_contacts_any(&s->contacts);
  s->work = nsdae_contacts_work(&s->contacts);
  s->worst_residual = s->contacts.info.residual;
  return NSDAE_OK;
}

const nsdae_stepping nsdae_stepping_implicit = {
    .name = "implicit",
    .summary = "the scheme iterated to the end of the step: second order between impacts",
    .advance = advance};
