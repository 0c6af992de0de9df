/* The time-stepping of Zhang, Gu and Sun as it is printed (Fig. 1, Eq. 34). Without a closed
 * contact (g_N(q_0) > 0 for all) a step of Newmark's rule; otherwise the LCP with all terms at
 * (t_0, q_0, v_0) for Lambda and x, then, with dv = M(q_0)^-1 (h F - Phi_q^T Lambda + W Lambda_c),
 *
 *   v~  = v_0 + dv at q_0,   q_1 = q_0 + h/2 (v_0 + v~),   v_1 = v_0 + dv with Phi_q, W at q_1
 *
 * One pass, of first order; v_1 does not satisfy Phi_q(q_1) v_1 + Phi_t = 0. */
#include <float.h>
#include <math.h>

#include "stepper.h"
#include "vector.h"

enum {
  CONTACT_TERMS = NSDAE_TERM_MASS | NSDAE_TERM_FORCE | NSDAE_TERM_JACOBIAN | NSDAE_TERM_PHI_T |
                  NSDAE_TERM_NORMAL | NSDAE_TERM_TANGENT | NSDAE_TERM_BIAS | NSDAE_TERM_SLIDE,
  END_TERMS = NSDAE_TERM_JACOBIAN | NSDAE_TERM_NORMAL | NSDAE_TERM_TANGENT | NSDAE_TERM_SLIDE
};

static int smooth_step(nsdae_stepper *s)
{
  int status = nsdae_newmark_step(&s->newmark, &s->start, &s->end, s->t_end, s->multiplier);
  s->iterations += s->newmark.iterations;
  s->smooth = 1;
  s->work = 0;
  s->worst_residual = 0;
  if (s->kkt.rank < s->rank) s->rank = s->kkt.rank;
  return status;
}

/* Lambda and x at the start, v~ into s->v. */
static int solve_at_start(nsdae_stepper *s, double h)
{
  nsdae_terms *start = &s->start;
  int status = nsdae_terms_need(start, CONTACT_TERMS);
  if (status == NSDAE_OK) status = nsdae_stepper_factor(s, start, start->M);
  if (status < 0) return status;
  nsdae_contacts_before(&s->contacts, start, start->v, 0);
  nsdae_stepper_momentum(start->M, start->v, h, start->F, s->system->dims.nv, s->r);
  return nsdae_stepper_impact(s, start, s->r, s->v);
}

static int positions(nsdae_stepper *s, double h)
{
  nsdae_terms *start = &s->start;
  const nsdae_dims *dims = &s->system->dims;
  for (int i = 0; i < dims->nv; i++) s->last[i] = (start->v[i] + s->v[i]) / 2;
  int status = nsdae_stepper_kinematics(s, start->t, start->q, s->last, s->qdot0);
  for (int i = 0; i < dims->nq; i++) s->q[i] = start->q[i] + h * s->qdot0[i];
  nsdae_terms_at(&s->end, s->t_end, s->q, s->v);
  return status < 0 ? status : nsdae_terms_need(&s->end, END_TERMS);
}

/* v_1 = M(q_0)^-1 (M v_0 + h F - Phi_q(q_1)^T Lambda + W(q_1) Lambda_c); s->r holds M v_0 + h F. */
static void velocity_at_end(nsdae_stepper *s)
{
  const nsdae_dims *dims = &s->system->dims;
  nsdae_add_transposed(dims->m, dims->nv, -1, s->end.J, s->impulse, s->r);
  nsdae_contacts_add_impulse(&s->contacts, &s->end, 1, 0, s->r);
  nsdae_kkt_solve_mass(&s->kkt, s->r);
  /* where the matrices did not change, v_1 is v~ and not its rounding: what rests, rests */
  for (int i = 0; i < dims->nv; i++)
    if (fabs(s->r[i] - s->v[i]) <= 64 * DBL_EPSILON * (fabs(s->size[i]) + fabs(s->v[i])))
      s->r[i] = s->v[i];
  nsdae_terms_set_velocity(&s->end, s->r);
}

static int contact_step(nsdae_stepper *s, double h)
{
  s->newmark.have_start = 0;
  s->smooth = 0;
  int status = solve_at_start(s, h);
  if (status == NSDAE_OK) status = positions(s, h);
  if (status < 0) return status;
  velocity_at_end(s);
  for (int i = 0; i < s->system->dims.m; i++) s->multiplier[i] = s->impulse[i] / h;
  s->work = nsdae_contacts_work(&s->contacts);
  s->worst_residual = s->contacts.info.residual;
  return NSDAE_OK;
}

static int advance(nsdae_stepper *s, double h)
{
  int status = nsdae_terms_need(&s->start, NSDAE_TERM_GAP);
  if (status < 0) return status;
  nsdae_contacts_close(&s->contacts, &s->start);
  return nsdae_contacts_any(&s->contacts) ? contact_step(s, h) : smooth_step(s);
}

const nsdae_stepping nsdae_stepping_printed = {
    .name = "implicit-printed",
    .summary = "the source paper's one-pass scheme, letter for letter: first order",
    .advance = advance};
